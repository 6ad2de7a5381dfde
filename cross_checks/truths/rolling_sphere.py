"""A sphere that slides, then rolls: uniform acceleration against the slip velocity u, then none (Coriolis 1835)."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.numerics.extrapolation import extrapolate
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import from_axis_angle, parameter_matrix, product
from mbs_ref.scenes.rolling import RADIUS

UP = np.array([0.0, 0.0, 1.0])
UNCERTAINTY = 1e-13  # m, of elementary functions and of the extrapolated orientation


def stop_of_slip(scene: Scene) -> tuple[float, np.ndarray, np.ndarray]:
    """Return when sliding ends (s), how far the centre has come (m) and its velocity from then on (m/s).

    u' = -7/2 mu g u/|u|, so it ends at 2 |u0| / (7 mu g) with v = v0 - 2/7 u0; without spin 12 v0^2 / (49 mu g) on.
    """
    ball: Any = scene.bodies[0]
    speed, direction, pull = _slip(scene)
    end = 2.0 * speed / (7.0 * pull)
    start = np.array(ball.velocity)
    return end, start * end - 0.5 * pull * direction * end**2, start - 2.0 / 7.0 * speed * direction


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Positions by closed form; the orientation turns about a fixed axis, or with spin by extrapolation."""
    ball: Any = scene.bodies[0]
    _, direction, pull = _slip(scene)
    end, path, final = stop_of_slip(scene)
    since = np.minimum(times, end)[:, None]
    sliding = np.array(ball.velocity) * since - 0.5 * pull * direction * since**2
    rolling = final * np.maximum(times - end, 0.0)[:, None]
    position = np.array(ball.position) + np.where(times[:, None] <= end, sliding, path + rolling)
    return Truth(position[:, None], _orientation(scene, times, end)[:, None], UNCERTAINTY, "exact",
                 "uniform acceleration against the slip velocity, then uniform motion")  # fmt: skip


def _slip(scene: Scene) -> tuple[float, np.ndarray, float]:
    """Return the first slip speed (m/s), its direction (3,), and mu g (m/s^2)."""
    ball: Any = scene.bodies[0]
    contact: Any = scene.contacts[0]
    slip = np.array(ball.velocity) - RADIUS * np.cross(ball.angular_velocity, UP)
    speed = float(np.linalg.norm(slip))
    return speed, slip / speed, contact.friction.coefficient * -scene.gravity[2]


def _orientation(scene: Scene, times: np.ndarray, end: float) -> np.ndarray:
    """Return theta (n_t, 4): omega' = 5 mu g / (2 r) n x u/|u| while it slides."""
    ball: Any = scene.bodies[0]
    _, direction, pull = _slip(scene)
    spin, gain = np.array(ball.angular_velocity), 2.5 * pull / RADIUS * np.cross(UP, direction)
    grid = np.unique(np.concatenate(([0.0, end], times[times < end])))

    def rate(t: float, theta: np.ndarray) -> np.ndarray:
        return 0.5 * parameter_matrix(theta).T @ (spin + gain * t)

    slid = extrapolate(rate, np.array([1.0, 0.0, 0.0, 0.0]), grid, 1e-15)
    final = spin + gain * end
    rolled = product(from_axis_angle(final, np.linalg.norm(final) * np.maximum(times - end, 0.0)), slid[-1])
    return np.where(times[:, None] < end, slid[np.searchsorted(grid, np.minimum(times, end))], rolled)
