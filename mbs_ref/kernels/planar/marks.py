"""Marks: points fixed in bodies, how far and fast two of them are apart, and forces that act at them.

r = R + rho, rho = A u (Fox 1999 eq 2), d(rho)/d(theta) = (-rho_y, rho_x). Vectors are pairs along world axes.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.vectors import cross, dot, left, minus, over, pair, plus, times, turn
from mbs_ref.kernels.rigid.model import kinematics_of


class Separation(NamedTuple):
    """From a mark of body a to one of body b."""

    arm_a: Any  # m, rho_a
    arm_b: Any  # m
    gap: Any  # m, d = r_b - r_a
    rate: Any  # m/s, d'
    centripetal: Any  # m/s^2, omega_b^2 rho_b - omega_a^2 rho_a: -d'' without the bodies' accelerations


@bare
def arm(pose, body, point):
    """Return rho = A u."""
    return turn(pose[body, 2], pose[body, 3], point)


@bare
def gap_between(kin, a, b, arm_a, arm_b):
    """Return r_b - r_a (m) of two marks given by their arms."""
    return minus(minus(plus(kin.pose[b], arm_b), kin.pose[a]), arm_a)


@bare
def rate_between(kin, a, b, arm_a, arm_b):
    """Return r_b' - r_a' (m/s) of two marks given by their arms."""
    va, vb = kin.motion[a], kin.motion[b]
    return (vb[0] - arm_b[1] * vb[2] - va[0] + arm_a[1] * va[2], vb[1] + arm_b[0] * vb[2] - va[1] - arm_a[0] * va[2])


@bare
def separation(work, a, b, point_a, point_b):
    kin = kinematics_of(work)
    arm_a, arm_b = arm(kin.pose, a, point_a), arm(kin.pose, b, point_b)
    wa, wb = kin.motion[a, 2], kin.motion[b, 2]
    return Separation(
        arm_a,
        arm_b,
        gap_between(kin, a, b, arm_a, arm_b),
        rate_between(kin, a, b, arm_a, arm_b),
        (arm_b[0] * wb * wb - arm_a[0] * wa * wa, arm_b[1] * wb * wb - arm_a[1] * wa * wa),
    )


@bare
def inward(work, a, b, apart):
    return apart.centripetal


@bare
def rate_along(work, i, point, e):
    kin = kinematics_of(work)
    return dot(e, kin.motion[i]) + cross(arm(kin.pose, i, point), e) * kin.motion[i, 2]


@bare
def acceleration_along(work, i, point, e):
    kin = kinematics_of(work)
    w = kin.motion[i, 2]
    return -(dot(e, arm(kin.pose, i, point)) * w * w)


@bare
def rate_seen(work, a, gap, rate):
    return minus(rate, times(kinematics_of(work).motion[a, 2], left(gap)))


@bare
def pull(tension, gap, length):
    return over(times(tension, gap), length)


@bare
def exchange(work, a, arm_a, b, arm_b, force):
    on_a, on_b = kinematics_of(work).force[a], kinematics_of(work).force[b]
    on_a[0] += force[0]
    on_a[1] += force[1]
    on_a[2] += cross(arm_a, force)
    on_b[0] -= force[0]
    on_b[1] -= force[1]
    on_b[2] -= cross(arm_b, force)


@bare
def centre(work, i):
    return pair(kinematics_of(work).pose[i], 0)


@bare
def speed(work, i):
    motion = kinematics_of(work).motion[i]
    return math.hypot(motion[0], motion[1])


@bare
def spin(work, i):
    return abs(kinematics_of(work).motion[i, 2])


@bare
def speed_between(work, a, b):
    motion = kinematics_of(work).motion
    return math.hypot(motion[a, 0] - motion[b, 0], motion[a, 1] - motion[b, 1])


@bare
def place_of_mark(work, i, point):
    pose = kinematics_of(work).pose
    return plus(pose[i], arm(pose, i, point))


@bare
def coordinate(work, i, component):
    kin = kinematics_of(work)
    return kin.motion[i, 3] if component == 2 else kin.pose[i, component], kin.motion[i, component]
