"""Marks: points fixed in bodies, how far and fast two of them are apart, and forces that act at them.

r = R + rho, rho = A u (Fox 1999 eq 2), r' = R' + omega x rho. Vectors are tuples along world axes.
"""

import math
from typing import Any, NamedTuple

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid import geometry as core


class Separation(NamedTuple):
    """From a mark of body a to one of body b."""

    arm_a: Any  # m, rho_a
    arm_b: Any  # m
    gap: Any  # m, d = r_b - r_a
    rate: Any  # m/s, d'
    swing_a: Any  # m/s, omega_a x rho_a
    swing_b: Any  # m/s


# Return the place (m) of a point of body i.
place_of_mark = bare(lambda work, i, point: core.plus(work, core.centre(work, i), core.turned(work, i, point)))
# Return the length of a vector.
magnitude = bare(lambda work, a: math.sqrt(core.dot(work, a, a)))
# Return how fast the centres of mass of two bodies move against each other, m/s.
speed_between = bare(lambda work, a, b: magnitude(work, core.minus(work, core.speed(work, b), core.speed(work, a))))


@bare
def gap_between(work, a, b, arm_a, arm_b):
    """Return r_b - r_a (m) of two marks given by their arms."""
    there = core.plus(work, core.centre(work, b), arm_b)
    return core.minus(work, core.minus(work, there, core.centre(work, a)), arm_a)


@bare
def _rate_between(work, a, b, swing_a, swing_b):
    there = core.plus(work, core.speed(work, b), swing_b)
    return core.minus(work, core.minus(work, there, core.speed(work, a)), swing_a)


@bare
def rate_between(work, a, b, arm_a, arm_b):
    """Return r_b' - r_a' (m/s) of two marks given by their arms."""
    return _rate_between(work, a, b, core.swing(work, a, arm_a), core.swing(work, b, arm_b))


@bare
def separation(work, a, b, point_a, point_b):
    """Return the Separation of a point of body b from one of body a."""
    arm_a, arm_b = core.turned(work, a, point_a), core.turned(work, b, point_b)
    swing_a, swing_b = core.swing(work, a, arm_a), core.swing(work, b, arm_b)
    gap, rate = gap_between(work, a, b, arm_a, arm_b), _rate_between(work, a, b, swing_a, swing_b)
    return Separation(arm_a, arm_b, gap, rate, swing_a, swing_b)


@bare
def inward(work, a, b, apart):
    """Return the second rate (m/s^2) of the gap of a separation without the bodies' accelerations, negative."""
    return core.minus(work, core.swing(work, a, apart.swing_a), core.swing(work, b, apart.swing_b))


# Return the rate (m/s) of a gap as body a sees it.
rate_seen = bare(lambda work, a, gap, rate: core.minus(work, rate, core.swing(work, a, gap)))


@bare
def exchange(work, a, arm_a, b, arm_b, force):
    """Add a force (N) at an arm of body a, and its opposite at an arm of body b."""
    core.push(work, a, arm_a, force)
    core.push(work, b, arm_b, core.times(work, -1.0, force))
