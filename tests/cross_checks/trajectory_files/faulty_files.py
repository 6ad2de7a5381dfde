"""Files of tools with one known fault each, and right files of other engines.

The tools integrate their own equations of motion in minimal coordinates by SciPy, or are other engines: nothing here
comes from the code that looks for faults.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import cross_checks
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

G = 9.81  # m/s^2
ROD = scenes.make("pendulum_chain", links=1)
TWO = scenes.make("double_pendulum")
SPRING = scenes.make("spring_pendulum")
TOP = scenes.make("heavy_top")


def swing(scene: Scene, accelerate: Callable, q: list[float], v: list[float], samples: int = 101, **options):
    """Return times and coordinates (n, n_q) and rates of a system whose accelerations are given."""
    times, n = np.linspace(0.0, scene.duration, samples), len(q)
    run = solve_ivp(
        lambda t, y: np.concatenate((y[n:], accelerate(y[:n], y[n:]))), (0.0, scene.duration), [*q, *v], t_eval=times,
        **({"method": "DOP853", "rtol": 1e-11, "atol": 1e-12} | options),
    )  # fmt: skip
    return times, run.y[:n].T, run.y[n:].T


def two_rods(g: float = G, m_2: float = 0.6, j_1: float = 1.0 / 12.0, j_2: float = 0.032, **options):
    """Return the motion of the double pendulum in its two angles (Levien and Tan 1993)."""
    l_1, l_2, m_1 = 1.0, 0.8, 1.0

    def accelerate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        between = q[0] - q[1]
        coupling = 0.5 * m_2 * l_1 * l_2 * np.array([np.cos(between), np.sin(between)])
        mass = [[j_1 + 0.25 * m_1 * l_1**2 + m_2 * l_1**2, coupling[0]], [coupling[0], j_2 + 0.25 * m_2 * l_2**2]]
        weight = g * np.array([(0.5 * m_1 + m_2) * l_1 * np.cos(q[0]), 0.5 * m_2 * l_2 * np.cos(q[1])])
        return np.linalg.solve(mass, coupling[1] * np.array([-(v[1] ** 2), v[0] ** 2]) - weight)

    times, q, v = swing(TWO, accelerate, [0.0, 0.5], [0.0, 0.0], **options)
    along = np.stack([np.cos(q), np.sin(q)], axis=-1)  # (n, 2 rods, 2)
    across = np.stack([-np.sin(q), np.cos(q)], axis=-1) * v[..., None]
    upper, lower = 0.5 * l_1 * along[:, 0], l_1 * along[:, 0] + 0.5 * l_2 * along[:, 1]
    fast = (0.5 * l_1 * across[:, 0], l_1 * across[:, 0] + 0.5 * l_2 * across[:, 1])
    return plane(times, {"upper": (upper, q[:, 0], fast[0], v[:, 0]), "lower": (lower, q[:, 1], fast[1], v[:, 1])})


def plane(times: np.ndarray, bodies: dict[str, tuple[np.ndarray, ...]]) -> dict[str, np.ndarray]:
    """Return columns of positions (n, 2), angles, velocities and angular velocities."""
    columns = {"t": times}
    for name, (place, angle, velocity, rate) in bodies.items():
        every = (*place.T, angle, *velocity.T, rate)
        columns |= {f"{name}.{word}": v for word, v in zip(("x", "y", "angle", "vx", "vy", "rate"), every, strict=True)}
    return columns


def on_a_spring(g: float = G, stiffness: float = 100.0, **options) -> dict[str, np.ndarray]:
    """Return the motion of the point mass on a spring of 1 m."""

    def accelerate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        length = np.hypot(*q)
        return -stiffness * (length - 1.0) / length * q - [0.0, g]

    times, q, v = swing(SPRING, accelerate, [1.0, 0.0], [0.0, 0.0], **options)
    return {"t": times, "bob.x": q[:, 0], "bob.y": q[:, 1], "bob.vx": v[:, 0], "bob.vy": v[:, 1]}


def top(about_centre: tuple[float, float, float] = (0.04, 0.04, 0.02)) -> dict[str, np.ndarray]:
    """Return the motion of the heavy top by Euler's equations about its pivot, in body axes, and its quaternion."""
    body = TOP.bodies[0]
    arm = np.array([0.0, 0.0, np.linalg.norm(body.position)])
    inertia = np.array(about_centre) + body.mass * arm[2] ** 2 * np.array([1.0, 1.0, 0.0])

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        e, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        turn = Rotation.from_quat(e, scalar_first=True)
        torque = np.cross(arm, turn.inv().apply([0.0, 0.0, -body.mass * G]))
        spin = 0.5 * np.concatenate(([-e[1:] @ w], e[0] * w + np.cross(e[1:], w)))
        return np.concatenate((spin, (torque - np.cross(w, inertia * w)) / inertia))

    start = Rotation.from_quat(body.orientation, scalar_first=True)
    times = np.linspace(0.0, TOP.duration, 101)
    y = solve_ivp(rate, (0.0, TOP.duration), [*body.orientation, *start.inv().apply(body.angular_velocity)],
                  method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times).y.T  # fmt: skip
    turn = Rotation.from_quat(y[:, :4], scalar_first=True)
    spin, place = turn.apply(y[:, 4:]), turn.apply(arm)
    every = np.column_stack((place, turn.as_quat(scalar_first=True), np.cross(spin, place), spin))
    names = ("x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "wx", "wy", "wz")
    return {"t": times} | {f"top.{name}": every[:, k] for k, name in enumerate(names)}


def scaled(columns: dict[str, np.ndarray], factor: float, *endings: str) -> dict[str, np.ndarray]:
    """Return the columns with some of them multiplied."""
    return {name: v * (factor if name.rpartition(".")[2] in endings else 1.0) for name, v in columns.items()}


def half_a_step_early(step: float) -> dict[str, np.ndarray]:
    """Return the double pendulum with velocities of half a step before the positions, as leapfrog has them."""
    fine = two_rods(samples=601)  # 5 ms apart
    late, now = slice(10 - int(step / 0.01), None, 10), slice(10, None, 10)
    rates = ("vx", "vy", "rate")
    return {name: v[late][: len(v[now])] if name.rpartition(".")[2] in rates else v[now] for name, v in fine.items()}


# What a tool with one fault writes of a scene, and the words that name the fault.
FAULTS: dict[str, Callable[[], tuple[Scene, dict[str, np.ndarray], tuple[str, ...]]]] = {
    "y points down": lambda: (TWO, scaled(two_rods(), -1.0, "y", "vy", "angle", "rate"), ("mirrored along y",)),
    "gravity upwards": lambda: (SPRING, on_a_spring(g=-G), ("gravity acts along (0, 1)",)),
    "velocities half a step early": lambda: (TWO, half_a_step_early(0.01), ("velocities", "are late by 0.005 s")),
    "stiffness 10 % high": lambda: (SPRING, on_a_spring(stiffness=110.0), ("stiffness of 'spring' is 1.1 times",)),
    "mass twice": lambda: (TWO, two_rods(m_2=1.2), ("mass of 'lower' is 2 times",)),
    "inertia 30 % high": lambda: (TWO, two_rods(j_1=1.3 / 12.0), ("inertia of 'upper' is 1.3 times",)),
    "inertia about the elbow": lambda: (
        TWO, two_rods(j_2=0.032 + 0.6 * 0.16), ("inertia of lower is about", "'elbow'")
    ),
    "inertia about the pivot": lambda: (
        TOP, top((0.04 + 0.09, 0.04 + 0.09, 0.02)), ("inertia of top is about", "'pivot'")
    ),
    "loose tolerance": lambda: (TWO, two_rods(method="RK45", rtol=1e-3, atol=1e-6), ("tolerance",)),
    "degrees": lambda: (TWO, scaled(two_rods(), 180.0 / np.pi, "angle"), ("orientation columns look like deg",)),
    "millimetres": lambda: (TWO, scaled(two_rods(), 1e3, "x", "y"), ("position columns look like mm",)),
    "gravity of the standard": lambda: (TWO, two_rods(g=9.80665), ("gravity is 0.9997 times",)),
}  # fmt: skip


RIGHT = (
    (TWO, "exudyn", {"step": 1e-3}), (TWO, "pinocchio", {"method": "rk4", "step": 1e-2}),
    (TWO, "mujoco", {"method": "rk4", "step": 1e-2}), (TWO, "mujoco", {"method": "implicit", "step": 1e-3}),
    (SPRING, "exudyn", {"step": 1e-3}), (SPRING, "pinocchio", {"method": "rk4", "step": 1e-2}),
    (SPRING, "mujoco", {"method": "rk4", "step": 1e-2}), (ROD, "exudyn", {"step": 1e-3}),
    (ROD, "mujoco", {"method": "implicit", "step": 1e-3}), (TOP, "exudyn", {"step": 1e-4}),
    (TOP, "pinocchio", {"method": "rk4", "step": 1e-3}), (TOP, "mujoco", {"method": "rk4", "step": 1e-3}),
)  # fmt: skip


def right(scene: Scene, engine: str, settings: dict) -> Trajectory:
    """Return the motion that an engine computes at a decent setting."""
    run = cross_checks.run(scene, engine, **settings)
    assert run.path is not None, run.record.message
    return run.path
