"""Truths of tops: Euler's and Lagrange's, in Jacobi's elliptic functions, and Euler's disk."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.truths.made_by.numerics import closed_forms
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period, running_integral
from cross_checks.truths.truth import EPS, NoConvergenceError, Truth
from mbs_ref import Scene
from mbs_ref.scene.euler_parameters import from_axis_angle, from_matrix, product, rotation_matrices

Z, Y = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
ARM_MASS, ARM = 1.0, 0.3  # kg; m, of the heavy top, from the fixed point to the centre of mass
AXIAL, TRANSVERSE = 0.02, 0.04  # kg m^2, about the centre of mass


def heavy_top(scene: Scene, times: np.ndarray) -> Truth:
    """u = cos(theta): u'^2 = beta (u0 - u)(1 - u^2) - a^2 (u0 - u)^2 from rest at u0 (Goldstein sec. 5-7).

    With u1 < u0 < u3 its roots, u = u1 + (u0 - u1) sn^2(K + p t), p = sqrt(beta (u3 - u1)) / 2; precession
    phi' = a (u0 - u) / (1 - u^2) and spin psi' = omega_3 - phi' u by quadrature. Steady: phi' is
    a root of its quadratic.
    """
    given = scene.parameters
    spin, tilt, gravity = (float(given[key]) for key in ("spin", "tilt", "gravity"))
    grid = times.astype(np.longdouble)
    data = np.array([spin, tilt, gravity], dtype=np.longdouble)
    if given["motion"] == "steady":
        rate = _steady_precession(*data)
        theta, phi = np.full(len(times), np.longdouble(tilt)), rate * grid
        psi = (spin - rate * np.cos(theta)) * grid
        error = EPS * (abs(float(rate)) + abs(spin)) * float(times[-1])
    else:
        *angles, error = _nutation(data, grid)
        theta, phi, psi = angles
        error += closed_forms.rounding_error(lambda near, few: np.stack(_nutation(near, few)[:3]), data, grid)
    full = 2 * np.arctan2(np.longdouble(0), np.longdouble(-1))
    phi, psi = np.remainder(phi, full).astype(float), np.remainder(psi, full).astype(float)
    turned = product(product(from_axis_angle(Z, phi), from_axis_angle(Y, theta.astype(float))), from_axis_angle(Z, psi))
    axis = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1).astype(float)
    how = "elliptic functions by the arithmetic-geometric mean, quadrature in extended precision"
    return Truth(ARM * axis[:, None], turned[:, None], 1e-15 + error, "exact", how)


def _steady_precession(spin: Any, tilt: Any, gravity: Any) -> Any:
    """Return the slow root of A Omega^2 cos(tilt) - C spin Omega + m g l = 0 (rad/s), A about the fixed point."""
    pivot, weight = TRANSVERSE + ARM_MASS * np.longdouble(ARM) ** 2, ARM_MASS * gravity * ARM
    return 2 * weight / (AXIAL * spin + np.sqrt((AXIAL * spin) ** 2 - 4 * pivot * np.cos(tilt) * weight))


def _nutation(data: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return the three Euler angles (z, y, z), each (n_t,), and the error of their quadrature, rad."""
    spin, tilt, gravity = data
    about_pivot = TRANSVERSE + ARM_MASS * np.longdouble(ARM) ** 2
    beta, a = 2 * ARM_MASS * gravity * ARM / about_pivot, AXIAL * spin / about_pivot
    u0 = np.cos(tilt)
    root = np.sqrt(a**4 - 4 * beta * (a**2 * u0 - beta))
    u1, u3 = 2 * (a**2 * u0 - beta) / (a**2 + root), (a**2 + root) / (2 * beta)
    m, p = (u0 - u1) / (u3 - u1), np.sqrt(beta * (u3 - u1)) / 2
    quarter = quarter_period(m)

    def height(t):
        return u1 + (u0 - u1) * np.sin(amplitude(quarter + p * t, m)) ** 2

    def precession(t):
        u = height(t)
        return a * (u0 - u) / (1 - u**2)

    piece = float(quarter / p) / 8
    phi, error = running_integral(precession, times, piece)
    back, more = running_integral(lambda t: precession(t) * height(t), times, piece)
    return np.arccos(height(times)), phi, spin * times - back, error + more


CLOSEST = 1e-9  # of 1 - m: closer to the separatrix rounded data decide the motion


def torque_free_top(scene: Scene, times: np.ndarray) -> Truth:
    """Body rates by Landau and Lifshitz, sec. 37; the precession of one axis about the momentum by quadrature."""
    body: Any = scene.bodies[0]
    moments = np.array(body.inertia[:3], dtype=np.longdouble)
    start = rotation_matrices(np.array(body.orientation, dtype=np.longdouble))
    omega = start.T @ np.array(body.angular_velocity, dtype=np.longdouble)
    theta, error = _orientations(moments, omega, start, times)
    error += 2.0 * closed_forms.rounding_error(
        lambda near, few: _orientations(moments, near, start, few)[0], omega, times
    )
    position = np.zeros((len(times), 1, 3))
    return Truth(
        position + np.array(body.position), theta[:, None].astype(float), 4.6e-16 + error, "exact",
        "Jacobi elliptic functions by the arithmetic-geometric mean, precession by quadrature, extended precision",
    )  # fmt: skip


@dataclass(frozen=True)
class Rates:
    """The body rates: cn, sn and dn of an argument linear in time, by body axis."""

    place: tuple[int, int, int]  # body axes of cn, sn, dn
    size: np.ndarray  # (3,) signed amplitudes of cn, sn, dn, rad/s
    m: Any
    speed: Any  # 1/s
    offset: Any

    def at(self, t: np.ndarray) -> np.ndarray:
        """Return omega (n_t, 3), rad/s, in body axes."""
        phi = amplitude(self.offset + self.speed * t, self.m)
        values = np.stack([np.cos(phi), np.sin(phi), np.sqrt(1 - self.m * np.sin(phi) ** 2)], axis=1) * self.size
        result = np.empty_like(values)
        result[:, list(self.place)] = values
        return result


def _rates(moments: np.ndarray, omega: np.ndarray) -> Rates:
    """Landau and Lifshitz (37.8) to (37.10) with the axes ordered so that the momentum circles the dn axis."""
    energy2, momentum2 = np.sum(moments * omega**2), np.sum((moments * omega) ** 2)
    low, middle, high = (int(k) for k in np.argsort(moments, kind="stable"))
    place = (low, middle, high) if momentum2 > energy2 * moments[middle] else (high, middle, low)
    i1, i2, i3 = (moments[k] for k in place)
    roundoff = 64 * np.finfo(np.longdouble).eps * momentum2  # a difference below is that of a steady spin
    lack, excess = (
        gap if abs(gap) > roundoff else np.longdouble(0) for gap in (energy2 * i3 - momentum2, momentum2 - energy2 * i1)
    )
    squares = np.array([lack / (i1 * (i3 - i1)), lack / (i2 * (i3 - i2)), excess / (i3 * (i3 - i1))])
    size = np.sqrt(squares)
    speed, m = np.sqrt((i3 - i2) * excess / (i1 * i2 * i3)), (i2 - i1) * lack / ((i3 - i2) * excess)
    mirrored = -1 if (low, middle, high) in ((0, 2, 1), (2, 1, 0), (1, 0, 2)) else 1  # left-handed axes run backwards
    down = np.sign(omega[place[2]])
    size = size * np.array([1, mirrored * down, down])
    if not 1 - m > CLOSEST:
        raise NoConvergenceError("the spin about the intermediate axis is on the separatrix: no period, no way to tell")
    if lack == 0:  # steady about the dn axis
        return Rates(place, size, m, speed, np.longdouble(0))
    c, s = omega[place[0]] / size[0], omega[place[1]] / size[1]
    return Rates(place, size, m, speed, closed_forms.argument(np.arctan2(s, c), m))


def _orientations(
    moments: np.ndarray, omega: np.ndarray, start: np.ndarray, times: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return theta (n_t, 4) and the error of its quadrature, rad.

    The momentum and the cn axis, known in the body and in the world, fix the orientation.
    """
    rates = _rates(moments, omega)
    axis = rates.place[0]
    others = [k for k in range(3) if k != axis]

    def precession(t: np.ndarray) -> np.ndarray:
        rate = rates.at(t)[:, others]
        part = rate * moments[others]
        return size * np.sum(rate * part, axis=1) / np.sum(part**2, axis=1)

    size = np.sqrt(np.sum((moments * omega) ** 2))
    period = 4 * quarter_period(rates.m) / rates.speed
    piece = min(float(period), 2 * np.pi / float(size / moments.min())) / 8
    turned, error = closed_forms.periodic_integral(precession, times.astype(np.longdouble), piece, period)
    up = start @ (moments * omega) / size  # the momentum in the world
    e = np.zeros(3, dtype=np.longdouble)
    e[axis] = 1
    seen = start @ e
    across = seen - up * (up @ seen)
    across = across / np.sqrt(across @ across)
    result = []
    for body_momentum, angle in zip(rates.at(times.astype(np.longdouble)) * moments, turned, strict=True):
        direction = across * np.cos(angle) + np.cross(up, across) * np.sin(angle)
        result.append(from_matrix(_triad(up, direction) @ _triad(body_momentum / size, e).T))
    return np.array(result), error


def _triad(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3): columns along `first`, along the part of `second` normal to it, and normal to both."""
    first = first / np.sqrt(first @ first)
    second = second - first * (first @ second)
    second = second / np.sqrt(second @ second)
    return np.stack([first, second, np.cross(first, second)], axis=1)


def euler_disk(scene: Scene, times: np.ndarray) -> Truth:
    """Steady precession at sqrt(4 g/(r sin tilt)) about the vertical through the centre, which rests."""
    wheel: Any = scene.joints[0]
    bend = np.radians(float(scene.parameters["tilt"]))
    rate = np.sqrt(4.0 * np.longdouble(scene.parameters["gravity"]) / (wheel.radius * np.sin(bend)))
    full = 2 * np.arctan2(np.longdouble(0), np.longdouble(-1))
    turned, spun = (np.remainder(w * times, full).astype(float) for w in (rate, -rate * np.cos(bend)))
    leaning = product(from_axis_angle(Z, turned), from_axis_angle(Y, np.full(len(times), bend)))
    poses = np.tile(scene.bodies[0].position, (len(times), 1, 1)), product(leaning, from_axis_angle(Z, spun))[:, None]
    error = 2.0 * EPS * (1.0 + float(rate * times[-1]))
    return Truth(*poses, error, "exact", "closed form: steady precession, nothing slips")


TRUTHS = {"nesc_tumbling_brick": torque_free_top}
