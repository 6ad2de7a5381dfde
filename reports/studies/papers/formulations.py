"""Two forms that the papers name, on a pendulum and a top: mu' = lambda ("index 0"), and Euler's angles.

Small solvers of their own, of plain arrays: what is shown belongs to the forms, not to this project's solver.
"""

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY, LENGTH = 9.81, 1.0  # m/s^2, m; a unit mass
STEPS = (1e-2, 1e-3, 1e-4)  # s, of RK4, and of the difference that turns mu into lambda
GIMBAL = 1e-5  # |sin of the middle angle| below which Euler's angles have no rates
SINGULAR = "singular"


def multipliers() -> dict[str, float | str]:
    """Return the error of lambda: solved for at index 1, and as the derivative of a computed mu (Fox 1999 eqs 16-17).

    RK4 in double and in single precision: a difference of mu is of order two where the solution is of order four, and
    divides mu's roundoff by the step, so that single precision soon grows worse as steps get shorter.
    """
    figures: dict[str, float | str] = {}
    for h in STEPS:
        times = h * np.arange(round(1.0 / h) + 1)
        exact = _exact_multiplier(times)
        for precision in ("float64", "float32"):
            path = _rk4(h, len(times), np.dtype(precision))
            solved = np.array([_multiplier(y) for y in path])
            differences = (path[2:, 4] - path[:-2, 4]) / path.dtype.type(2.0 * h)
            figures[f"multiplier.index1.{precision}.{h:g}"] = _worst(solved, exact)
            figures[f"multiplier.mu.{precision}.{h:g}"] = _worst(differences, exact[1:-1])
    return figures


def _worst(result: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(result - exact).max() / np.abs(exact).max())


def _rk4(h: float, count: int, precision: np.dtype) -> np.ndarray:
    """Return x, y, their rates and mu (count, 5)."""
    step = precision.type(h)
    half, sixth = precision.type(0.5), precision.type(1.0 / 6.0)
    path = np.zeros((count, 5), dtype=precision)
    path[0, 0] = LENGTH
    for n in range(count - 1):
        k1 = _pendulum(path[n])
        k2 = _pendulum(path[n] + half * step * k1)
        k3 = _pendulum(path[n] + half * step * k2)
        k4 = _pendulum(path[n] + step * k3)
        path[n + 1] = path[n] + sixth * step * (k1 + k2 + k2 + k3 + k3 + k4)
    return path


def _multiplier(y: np.ndarray):
    """lambda of C = (x^2 + y^2 - L^2) / 2 from the augmented system."""
    return (y[2] ** 2 + y[3] ** 2 - y.dtype.type(GRAVITY) * y[1]) / (y[0] ** 2 + y[1] ** 2)


def _pendulum(y: np.ndarray) -> np.ndarray:
    """Slopes of x, y, their rates, and mu with mu' = lambda."""
    pull = _multiplier(y)
    return np.array([y[2], y[3], -pull * y[0], -y.dtype.type(GRAVITY) - pull * y[1], pull], dtype=y.dtype)


def _exact_multiplier(times: np.ndarray) -> np.ndarray:
    """By the angle phi from the horizontal, at rest at phi = 0: L w^2 = 2 g sin(phi), lambda = 3 g sin(phi) / L."""
    swing = solve_ivp(
        lambda _, s: [s[1], GRAVITY / LENGTH * np.cos(s[0])], (0.0, float(times[-1])), [0.0, 0.0], t_eval=times,
        rtol=1e-13, atol=1e-14, method="DOP853",
    )  # fmt: skip
    return 3.0 * GRAVITY / LENGTH * np.sin(swing.y[0])


def euler_angles(tilt: float) -> dict[str, float | str]:
    """Turn a free body whose axis passes the pole within `tilt` (rad), in z-x-z angles and in Euler parameters."""
    spin = np.array([1.0, 0.0, 0.0])  # rad/s, world; the body's third axis starts at -1 rad from the pole

    def rates(_: float, angles: np.ndarray) -> np.ndarray:
        return _rate_matrix(angles[0], angles[1]) @ spin

    def pole(_: float, angles: np.ndarray) -> float:
        return abs(np.sin(angles[1])) - GIMBAL

    pole.terminal = True  # type: ignore[attr-defined]
    axis = np.array([np.sin(tilt), np.sin(1.0) * np.cos(tilt), np.cos(1.0) * np.cos(tilt)])
    start = [np.arctan2(axis[0], -axis[1]), np.arccos(axis[2]), 0.0]
    path = solve_ivp(rates, (0.0, 2.0), start, rtol=1e-8, atol=1e-10, events=pole)
    stopped = len(path.t_events[0]) > 0 or not path.success
    turned = solve_ivp(lambda _, p: 0.5 * _left(spin) @ p, (0.0, 2.0), [1.0, 0.0, 0.0, 0.0], rtol=1e-8, atol=1e-10)
    return {
        "status": SINGULAR if stopped else "success", "until": float(path.t[-1]), "calls": float(path.nfev),
        "parameters_calls": float(turned.nfev), "parameters_norm": float(abs(np.linalg.norm(turned.y[:, -1]) - 1.0)),
    }  # fmt: skip


def _rate_matrix(precession: float, nutation: float) -> np.ndarray:
    """Return the matrix (3, 3) from the world's angular velocity to the angles' rates; infinite at nutation = 0."""
    c, s, sn, cn = np.cos(precession), np.sin(precession), np.sin(nutation), np.cos(nutation)
    return np.array([[-s * cn / sn, c * cn / sn, 1.0], [c, s, 0.0], [s / sn, -c / sn, 0.0]])


def _left(w: np.ndarray) -> np.ndarray:
    """The matrix of the quaternion product (0, w) p."""
    x, y, z = w
    return np.array([[0, -x, -y, -z], [x, 0, -z, y], [y, z, 0, -x], [z, -y, x, 0]], dtype=float)
