"""Where runs of fixed steps lead, on made-up runs whose limit is known."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge.convergence.prediction import extrapolated
from mbs_ref.scene.euler_parameters import product
from mbs_ref.trajectory import Trajectory

TIMES = np.linspace(0.0, 1.0, 5)


def plane(h: float, order: int) -> Trajectory:
    """A body on a circle, off by h^order in everything."""
    off = h**order * np.sin(3.0 * TIMES)[:, None]
    circle, around = np.stack([np.cos(TIMES), np.sin(TIMES)], 1), np.stack([-np.sin(TIMES), np.cos(TIMES)], 1)
    return Trajectory(TIMES, (circle + off)[:, None], TIMES[:, None] + off, (around + off)[:, None], 1.0 + off)


def space(h: float, order: int) -> Trajectory:
    """A body that turns about z, its Euler parameters of norm 1 and off by h^order about x."""
    flat = plane(h, order)
    half = [0.5 * h**order * np.sin(3.0 * t) for t in TIMES]
    turns = [
        product(np.array([np.cos(t / 2), 0.0, 0.0, np.sin(t / 2)]), np.array([np.cos(a), np.sin(a), 0.0, 0.0]))
        for t, a in zip(TIMES, half, strict=True)
    ]
    three = np.zeros((len(TIMES), 1, 3))
    return Trajectory(TIMES, np.pad(flat.position, ((0, 0), (0, 0), (0, 1))), np.array(turns)[:, None], three, three)


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("ratio", [2.0, 2.5])
def test_the_leading_term_is_taken_away(order, ratio):
    found = extrapolated(plane(ratio * 0.1, order), plane(0.1, order), ratio, order)
    limit = plane(0.0, order)
    for name in ("position", "orientation", "velocity", "angular_velocity"):
        assert np.allclose(getattr(found, name), getattr(limit, name), rtol=0.0, atol=1e-14), name


def test_whole_turns_do_not_count():
    coarse, fine = plane(0.2, 2), plane(0.1, 2)
    wound = Trajectory(
        TIMES, coarse.position, coarse.orientation + 4.0 * np.pi, coarse.velocity, coarse.angular_velocity
    )
    assert np.allclose(extrapolated(wound, fine, 2.0, 2).orientation, TIMES[:, None], rtol=0.0, atol=1e-14)


def test_euler_parameters_keep_norm_1_whatever_their_sign():
    coarse, fine, limit = space(0.02, 2), space(0.01, 2), space(0.0, 2)
    other = Trajectory(TIMES, coarse.position, -coarse.orientation, coarse.velocity, coarse.angular_velocity)
    for one in (coarse, other):
        turns = extrapolated(one, fine, 2.0, 2).orientation
        assert np.allclose(np.linalg.norm(turns, axis=2), 1.0, rtol=0.0, atol=1e-15)
        assert np.allclose(turns, limit.orientation, rtol=0.0, atol=1e-8)  # the square of 1e-4 is left
