"""Marks: points fixed in bodies, how far and fast two of them are apart, and forces that act at them.

r = R + rho, rho = A u (Fox 1999 eq 2), d(rho)/d(theta) = (-rho_y, rho_x). Vectors are pairs along world axes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.vectors import cross, minus, plus, turn


class Separation(NamedTuple):
    """From a mark of body a to one of body b."""

    arm_a: Any  # m, rho_a
    arm_b: Any  # m
    gap: Any  # m, d = r_b - r_a
    rate: Any  # m/s, d'
    centripetal: Any  # m/s^2, omega_b^2 rho_b - omega_a^2 rho_a: -d'' without the bodies' accelerations


@jit
def arm(pose, body, point):
    """Return rho = A u."""
    return turn(pose[body, 2], pose[body, 3], point)


@jit
def gap_between(kin, a, b, arm_a, arm_b):
    """Return r_b - r_a (m) of two marks given by their arms."""
    return minus(minus(plus(kin.pose[b], arm_b), kin.pose[a]), arm_a)


@jit
def rate_between(kin, a, b, arm_a, arm_b):
    """Return r_b' - r_a' (m/s) of two marks given by their arms."""
    va, vb = kin.motion[a], kin.motion[b]
    return (
        vb[0] - arm_b[1] * vb[2] - va[0] + arm_a[1] * va[2],
        vb[1] + arm_b[0] * vb[2] - va[1] - arm_a[0] * va[2],
    )


@jit
def separation(kin, a, b, point_a, point_b):
    """Return the Separation of two marks."""
    arm_a, arm_b = arm(kin.pose, a, point_a), arm(kin.pose, b, point_b)
    wa, wb = kin.motion[a, 2], kin.motion[b, 2]
    return Separation(
        arm_a,
        arm_b,
        gap_between(kin, a, b, arm_a, arm_b),
        rate_between(kin, a, b, arm_a, arm_b),
        (arm_b[0] * wb * wb - arm_a[0] * wa * wa, arm_b[1] * wb * wb - arm_a[1] * wa * wa),
    )


@jit
def push(kin, body, arm, force):
    """Add a force (N) at rho."""
    kin.force[body, 0] += force[0]
    kin.force[body, 1] += force[1]
    kin.force[body, 2] += cross(arm, force)


@jit
def push_back(kin, body, arm, force):
    """Subtract a force (N) at rho."""
    kin.force[body, 0] -= force[0]
    kin.force[body, 1] -= force[1]
    kin.force[body, 2] -= cross(arm, force)
