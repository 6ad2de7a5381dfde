"""Marks: points fixed in bodies, how far and fast two of them are apart, and forces that act at them.

r = R + rho, rho = A u (Fox 1999 eq 2), r' = R' + omega x rho. Vectors are triples along world axes.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid.model import kinematics_of
from mbs_ref.kernels.spatial.vectors import add, cross, dot, minus, negative, plus, times, triple, turn


class Mark(NamedTuple):
    arm: Any  # m, rho
    rate: Any  # m/s, omega x rho


class Separation(NamedTuple):
    """From a mark of body a to one of body b."""

    arm_a: Any  # m, rho_a
    arm_b: Any  # m
    gap: Any  # m, d = r_b - r_a
    rate: Any  # m/s, d'
    arm_rate_a: Any  # m/s, omega_a x rho_a
    arm_rate_b: Any  # m/s


@bare
def mark(kin, body, point):
    """Return rho and omega x rho of a point of a body."""
    arm = turn(kin.turned[body], point)
    return Mark(arm, cross(kin.omega[body], arm))


@bare
def separation(work, a, b, point_a, point_b):
    kin = kinematics_of(work)
    on_a, on_b = mark(kin, a, point_a), mark(kin, b, point_b)
    gap = minus(minus(plus(kin.position[b], on_b.arm), kin.position[a]), on_a.arm)
    rate = minus(minus(plus(kin.velocity[b], on_b.rate), kin.velocity[a]), on_a.rate)
    return Separation(on_a.arm, on_b.arm, gap, rate, on_a.rate, on_b.rate)


@bare
def inward(work, a, b, apart):
    kin = kinematics_of(work)
    return minus(cross(kin.omega[a], apart.arm_rate_a), cross(kin.omega[b], apart.arm_rate_b))


@bare
def rate_along(work, i, point, e):
    kin = kinematics_of(work)
    return dot(e, plus(kin.velocity[i], mark(kin, i, point).rate))


@bare
def acceleration_along(work, i, point, e):
    kin = kinematics_of(work)
    return dot(e, cross(kin.omega[i], mark(kin, i, point).rate))


@bare
def push(kin, body, arm, force):
    """Add a force at rho."""
    add(kin.force[body], 0, force)
    twist(kin, body, cross(arm, force))


@bare
def twist(kin, body, torque):
    """Add a torque."""
    add(kin.force[body], 3, torque)


@bare
def rate_seen(work, a, gap, rate):
    return minus(rate, cross(kinematics_of(work).omega[a], gap))


@bare
def pull(tension, gap, length):
    return times(tension / length, gap)


@bare
def exchange(work, a, arm_a, b, arm_b, force):
    kin = kinematics_of(work)
    push(kin, a, arm_a, force)
    push(kin, b, arm_b, negative(force))


@bare
def centre(work, i):
    return triple(kinematics_of(work).position[i], 0)


@bare
def speed(work, i):
    v = kinematics_of(work).velocity[i]
    return math.sqrt(dot(v, v))


@bare
def spin(work, i):
    w = kinematics_of(work).omega[i]
    return math.sqrt(dot(w, w))


@bare
def speed_between(work, a, b):
    velocity = kinematics_of(work).velocity
    v = minus(velocity[a], velocity[b])
    return math.sqrt(dot(v, v))


@bare
def place_of_mark(work, i, point):
    kin = kinematics_of(work)
    return plus(kin.position[i], turn(kin.turned[i], point))


@bare
def coordinate(work, i, component):
    kin = kinematics_of(work)
    return kin.position[i, component], kin.velocity[i, component]
