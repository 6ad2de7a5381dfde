"""Libration in the orbit's plane: Lagrange's equations of distance, anomaly and attitude, in extended precision."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.numerics.extrapolation import extrapolate
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import GravityGradient
from mbs_ref.scene.euler_parameters import from_axis_angle

FINE, COARSE = 1e-17, 1e-15  # tolerances, whose results tell the uncertainty


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """With L = m (r'^2 + r^2 nu'^2) / 2 + C theta'^2 / 2 + gm m / r + gm (tr J - 3 I) / (2 r^3),
    I = A cos^2(theta - nu) + B sin^2(theta - nu); lengths in the first radius, times in 1 / n there.
    """
    body: Any = scene.bodies[1]
    load = next(x for x in scene.loads if isinstance(x, GravityGradient))
    a, b, c = (np.longdouble(x) for x in body.inertia[:3])
    radius, gm, mass = (np.longdouble(x) for x in (body.position[0], load.gm, body.mass))
    rate = np.sqrt(gm / radius**3)  # 1/s
    a, b, c = (x / (mass * radius**2) for x in (a, b, c))

    def slope(_t, y: np.ndarray) -> np.ndarray:
        r, climb, nu, sweep, theta, spin = y
        cosine, sine = np.cos(theta - nu), np.sin(theta - nu)
        along = a * cosine**2 + b * sine**2
        turning = 3 * (b - a) * sine * cosine / r**3  # torque on the orbit, its negative on the attitude
        pull = r * sweep**2 - 1 / r**2 - 3 * (a + b + c - 3 * along) / (2 * r**4)
        return np.array([climb, pull, sweep, (turning - 2 * r * climb * sweep) / r**2, spin, -turning / c])

    angle = 2 * np.arctan2(np.longdouble(body.orientation[3]), np.longdouble(body.orientation[0]))
    first = np.longdouble(body.velocity[1]) / (radius * rate)
    start = np.array([1, 0, 0, first, angle, np.longdouble(body.angular_velocity[2]) / rate], dtype=np.longdouble)
    grid = times.astype(np.longdouble) * rate
    fine, coarse = (_poses(extrapolate(slope, start, grid, x), radius, rate) for x in (FINE, COARSE))
    size = float(radius)
    apart = max(float(np.linalg.norm(x - y, axis=-1).max()) for x, y in zip(fine[:2], coarse[:2], strict=True))
    position, theta, velocity, omega = fine
    return Truth(
        position, theta, apart + 2.3e-16 * size, "converged",
        "Lagrange's equations in the orbit's plane by extrapolation in extended precision, at two tolerances",
        velocity=velocity, angular_velocity=omega,
        rate_uncertainty=np.full(len(times), (apart + 2.3e-16 * size) * float(rate)),
    )  # fmt: skip


def _poses(states: np.ndarray, radius, rate) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return places, Euler parameters, velocities and angular velocities of Earth and satellite."""
    r, climb, nu, sweep, theta, spin = states.T
    count = len(states)
    position, velocity, omega = (np.zeros((count, 2, 3)) for _ in range(3))
    turned = np.zeros((count, 2, 4))
    turned[:, 0, 0] = 1.0
    turned[:, 1] = from_axis_angle((0.0, 0.0, 1.0), theta.astype(float))
    position[:, 1, :2] = np.column_stack((radius * r * np.cos(nu), radius * r * np.sin(nu)))
    out, across = climb * radius * rate, r * sweep * radius * rate
    velocity[:, 1, :2] = np.column_stack(
        (out * np.cos(nu) - across * np.sin(nu), out * np.sin(nu) + across * np.cos(nu))
    )
    omega[:, 1, 2] = spin * rate
    return position, turned, velocity, omega
