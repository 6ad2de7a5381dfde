"""Places and rates of spatial bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

Vectors are triples along world axes.
"""

import math

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.spatial.vectors import add, cross, dot, times, triple, turn


@bare
def centre(work, i):
    return triple(work.kinematics.position[i], 0)


@bare
def spin(work, i):
    w = work.kinematics.omega[i]
    return math.sqrt(dot(w, w))


@bare
def speed(work, i):
    return triple(work.kinematics.velocity[i], 0)


@bare
def turned(work, i, u):
    return turn(work.kinematics.turned[i], u)


@bare
def swing(work, i, arm):
    return cross(work.kinematics.omega[i], arm)


@bare
def push(work, i, arm, force):
    add(work.kinematics.force[i], 0, force)
    twist(work, i, cross(arm, force))


@bare
def twist(work, i, torque):
    """Add a torque (N m)."""
    add(work.kinematics.force[i], 3, torque)


@bare
def pull(tension, gap, length):
    return times(tension / length, gap)


@bare
def coordinate(work, i, component):
    kin = work.kinematics
    return kin.position[i, component], kin.velocity[i, component]
