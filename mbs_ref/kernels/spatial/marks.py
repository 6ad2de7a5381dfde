"""Places and rates of spatial bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

Vectors are triples along world axes.
"""

import math

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid.model import kinematics_of
from mbs_ref.kernels.spatial.vectors import add, cross, dot, times, triple, turn


@bare
def centre(work, i):
    return triple(kinematics_of(work).position[i], 0)


@bare
def spin(work, i):
    w = kinematics_of(work).omega[i]
    return math.sqrt(dot(w, w))


@bare
def speed(work, i):
    return triple(kinematics_of(work).velocity[i], 0)


@bare
def turned(work, i, u):
    return turn(kinematics_of(work).turned[i], u)


@bare
def swing(work, i, arm):
    return cross(kinematics_of(work).omega[i], arm)


@bare
def push(work, i, arm, force):
    add(kinematics_of(work).force[i], 0, force)
    twist(work, i, cross(arm, force))


@bare
def twist(work, i, torque):
    """Add a torque (N m)."""
    add(kinematics_of(work).force[i], 3, torque)


@bare
def pull(tension, gap, length):
    return times(tension / length, gap)


@bare
def coordinate(work, i, component):
    kin = kinematics_of(work)
    return kin.position[i, component], kin.velocity[i, component]
