"""The car axis in its two freedoms, against the four coordinates of the source with multipliers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cross_checks.certify.agreement import Formulation, agree, converged
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scenes.car_axis import AMPLITUDE, HEIGHT, LENGTH, MASS, OMEGA


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's law along the slide and across the axis; index one with both constraints differentiated by hand."""
    found = agree(_with_multipliers(), _minimal(), times, extended=True)
    return converged(
        found, "the source's coordinates with multipliers by DOP853",
        "Newton's law along the slide and across the axis by extrapolation in extended precision", is_costly=True,
    )  # fmt: skip


class Road(NamedTuple):
    """The right wheel and its first two derivatives, (2,) m."""

    place: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def _road(t) -> Road:
    """The wheel stays LENGTH from the origin while its height is AMPLITUDE sin(OMEGA t)."""
    y, dy = AMPLITUDE * np.sin(OMEGA * t), AMPLITUDE * OMEGA * np.cos(OMEGA * t)
    ddy = -(OMEGA**2) * y
    x = np.sqrt(LENGTH**2 - y * y)
    dx = -y * dy / x
    ddx = -(dy * dy + y * ddy + dx * dx) / x
    return Road(np.array([x, y]), np.array([dx, dy]), np.array([ddx, ddy]))


def _across(v: np.ndarray) -> np.ndarray:
    return np.array([-v[1], v[0]])


def _forces(left: np.ndarray, right: np.ndarray, wheel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return springs and weight on both ends, N."""
    reach = right - wheel
    weight = np.array([0.0, -MASS])
    pulls = [(HEIGHT / np.sqrt(arm @ arm) - 1.0) * arm for arm in (left, reach)]
    return pulls[0] + weight, pulls[1] + weight


def _minimal() -> Formulation:
    """s: how far up the slide the left end is, in units of LENGTH; alpha: the axis' angle."""

    def ends(t, y):
        road, along = _road(t), np.array([np.cos(y[1]), np.sin(y[1])])
        left = y[0] * _across(road.place)
        return road, along, left, left + LENGTH * along

    def derivative(t, y):
        road, along, left, right = ends(t, y)
        up, over = _across(road.place), _across(along)
        known = 2.0 * y[2] * _across(road.velocity) + y[0] * _across(road.acceleration)  # of both accelerations
        swing = -LENGTH * y[3] ** 2 * along
        first, second = _forces(left, right, road.place)
        total, end = (first + second) / MASS - 2.0 * known - swing, second / MASS - known - swing
        a, b, c, d = 2.0 * (up @ up), LENGTH * (up @ over), up @ over, LENGTH
        e, f = up @ total, over @ end
        det = a * d - b * c
        return np.array([y[2], y[3], (e * d - b * f) / det, (a * f - e * c) / det])

    def poses(t, y):
        road, _, left, right = ends(t, y)
        tilt = np.arctan2(road.place[1], road.place[0])
        return np.stack([road.place, left, right]), np.array([tilt, tilt, 0.0 * tilt])

    return Formulation(derivative, np.array([HEIGHT / LENGTH, 0.0, 0.0, 0.0]), poses)


def _with_multipliers() -> Formulation:
    """Left and right end, four coordinates and their rates; 0 = left . wheel and |left - right| = LENGTH."""

    def derivative(t, y):
        road, left, right, v_left, v_right = _road(t), y[:2], y[2:4], y[4:6], y[6:]
        first, second = _forces(left, right, road.place)
        between, closing = left - right, v_left - v_right
        rows = np.array([np.concatenate([road.place, np.zeros(2)]), np.concatenate([between, -between])])
        due = -np.array([2.0 * v_left @ road.velocity + left @ road.acceleration, closing @ closing])
        free = np.concatenate([first, second]) / MASS
        pull = np.linalg.solve((rows @ rows.T).astype(float), (due - rows @ free).astype(float))
        return np.concatenate([v_left, v_right, free + rows.T @ pull])

    def poses(t, y):
        road = _road(t)
        tilt = np.arctan2(road.place[1], road.place[0])
        return np.stack([road.place, y[:2], y[2:4]]), np.array([tilt, tilt, 0.0 * tilt])

    lean = -HEIGHT * AMPLITUDE * OMEGA / LENGTH
    return Formulation(derivative, np.array([0.0, HEIGHT, LENGTH, HEIGHT, lean, 0.0, lean, 0.0]), poses)
