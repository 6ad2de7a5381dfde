"""Numbers of runs side by side: their arithmetic, their cosine and sine, and a tree's equations made of them."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.in_lanes import figures_of
from mbs_ref.cores.relative import RelativePlanarSystem
from mbs_ref.kernels.algebra.lanes import (
    WIDTH,
    chosen_in_lanes,
    cos_sin,
    in_lanes,
    larger,
    nearest_in_lanes,
    room_for_lanes,
)
from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rows import largest_entry
from tests.mbs_ref.cores.test_relative import planar_tree

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
LAST_DIGIT = 2.0**-52  # of numbers from 1 on: libm's are within half of that of numbers below
REACH = 1e5  # rad, up to which cosine and sine are as good as libm's
ROUNDOFF = 1e-12  # relative, of accelerations by two formulations
DIFFERENCED = 1e-6  # relative, of central differences


@bare
def _arithmetic(a, b, out):
    a, b, out = in_lanes(a), in_lanes(b), in_lanes(out)
    for k in range(a.shape[0]):
        out[k, 0] = a[k] + b[k] - 2.0
        out[k, 1] = 3 * a[k]
        out[k, 2] = 1.0 / b[k]
        out[k, 3] = -a[k]
        out[k, 4] = larger(a[k], abs(b[k]))
        out[k, 5] = nearest_in_lanes(a[k])
        out[k, 6] = chosen_in_lanes(b[k], a[k], 7.0)
        out[k, 6] += 1.0


@bare
def _turns(angle, out):
    angle, out = in_lanes(angle), in_lanes(out)
    for k in range(angle.shape[0]):
        out[k, 0], out[k, 1] = cos_sin(angle[k])


@bare
def _slopes(model, work, y, dy):
    derivative(model, work, 0.0, in_lanes(y), in_lanes(dy))


def random_lanes(*shape, scale=1.0):
    numbers = room_for_lanes(*shape)
    numbers[:] = np.random.default_rng(3).uniform(-scale, scale, numbers.shape)
    return numbers


def slopes_of(system, states):
    """Return dy/dt (n_state, WIDTH) of as many states."""
    y, dy = room_for_lanes(len(states)), room_for_lanes(len(states))
    y[:] = states
    room = system.room
    room.figures[:] = figures_of(system)[:, None]
    _slopes(room.model, room.work, y, dy)
    return dy


def decimal_cos_sin(angle):
    """Return cosine and sine by their series, to some 40 digits."""
    with localcontext(prec=50):
        x = Decimal(angle)
        x -= 2 * PI * (x / (2 * PI)).to_integral_value()
        sums, term = [Decimal(0), Decimal(0)], Decimal(1)
        for k in range(44):
            sums[k % 2] += term * (-1) ** (k // 2)
            term *= x / (k + 1)
        return sums[0], sums[1]


def test_arithmetic_is_that_of_floats():
    a, b, out = random_lanes(5, scale=9.0), random_lanes(5), room_for_lanes(5, 7)
    b[2, 1], b[3] = 0.0, 0.0
    a[4, 2], b[4, 3] = np.nan, np.nan
    with np.errstate(divide="ignore"):
        _arithmetic(a, b, out)
        wanted = a + b - 2.0, 3 * a, 1.0 / b, -a, np.maximum(a, np.abs(b)), np.rint(a), np.where(b, a, 7.0) + 1.0
    assert np.array_equal(out, np.stack(wanted, axis=1), equal_nan=True)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_largest_entry_is_none_where_one_is_no_number(place):
    values = np.array([[1.0, -3.0, 2.0]])
    assert largest_entry(values) == 3.0
    values[0, place] = np.nan
    assert np.isnan(largest_entry(values))


def test_cosine_and_sine_are_right_to_the_last_digit():
    """Against 40 digits, also where one of them almost vanishes: near multiples of pi/2."""
    angles = random_lanes(160, scale=REACH)
    angles[:40] = random_lanes(40, scale=4.0)
    angles[40:80] = np.pi / 2 * np.rint(angles[40:80])
    found = room_for_lanes(160, 2)
    _turns(angles, found)
    worst = 0.0
    for angle, pair in zip(angles.ravel().tolist(), found.transpose(0, 2, 1).reshape(-1, 2).tolist(), strict=True):
        truths = decimal_cos_sin(angle)
        worst = max(worst, *(float(abs(Decimal(one) - truth)) for one, truth in zip(pair, truths, strict=True)))
    assert worst < LAST_DIGIT


def test_no_angle_gives_a_number_where_there_is_none():
    angles, found = room_for_lanes(1), room_for_lanes(1, 2)
    angles[0, :3] = np.nan, np.inf, -np.inf
    _turns(angles, found)
    assert np.isnan(found[0, :, :3]).all()
    assert np.array_equal(found[0, :, 3:], np.repeat([[1.0], [0.0]], WIDTH - 3, axis=1))


def test_a_double_pendulum_obeys_its_lagrangian_equations():
    """Two uniform rods of 1 m and 1 kg, by the angles of both from the horizontal."""
    system = compile_scene(scenes.make("pendulum_chain", links=2), "relative")
    y, g = random_lanes(4, scale=3.0), 9.81
    first, second, w1, w2 = y[0], y[0] + y[1], y[2], y[2] + y[3]
    slopes = slopes_of(system, y)
    a1, a2 = slopes[2], slopes[2] + slopes[3]
    c, s = np.cos(first - second), np.sin(first - second)
    upper = 4.0 / 3.0 * a1 + 0.5 * c * a2 + 0.5 * s * w2**2 + 1.5 * g * np.cos(first)
    lower = 0.5 * c * a1 + a2 / 3.0 - 0.5 * s * w1**2 + 0.5 * g * np.cos(second)
    assert np.array_equal(slopes[:2], y[2:])
    assert np.max(np.abs([upper, lower])) < ROUNDOFF * np.max(np.abs(slopes))


def test_every_joint_accelerates_its_bodies_as_the_redundant_core_says():
    """Velocities of all bodies, differenced along the slopes, against constraint rows and multipliers."""
    system = compile_scene(planar_tree().model_copy(update={"loads": ()}), "relative")
    assert isinstance(system, RelativePlanarSystem)
    system.set_mode_time(0.0)
    y, n = random_lanes(len(system.initial_state()), scale=2.0), len(system.scene.bodies)
    slopes, h = slopes_of(system, y), 1e-5
    for state, slope in zip(y.T, slopes.T, strict=True):
        ahead, behind = system.full(state + h * slope), system.full(state - h * slope)
        found = ((ahead - behind) / (2.0 * h))[3 * n :].reshape(n, 3)
        wanted = system.redundant.accelerations(0.0, system.full(state))
        assert np.max(np.abs(found - wanted)) < DIFFERENCED * np.max(np.abs(wanted))


@pytest.mark.parametrize("shape", [(3,), (2, 5)])
def test_lanes_lie_where_packed_instructions_may_load_them(shape):
    room = room_for_lanes(*shape)
    assert room.shape == (*shape, WIDTH)
    assert room.ctypes.data % (8 * WIDTH) == 0
    assert not room.any()
