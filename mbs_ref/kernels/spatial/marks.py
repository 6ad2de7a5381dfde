"""Places and rates of spatial bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

Vectors are triples along world axes.
"""

import math

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.spatial.vectors import add, cross, dot, times, triple, turn

centre = bare(lambda work, i: triple(work.kinematics.position[i], 0))


@bare
def spin(work, i):
    w = work.kinematics.omega[i]
    return math.sqrt(dot(w, w))


speed = bare(lambda work, i: triple(work.kinematics.velocity[i], 0))
turned = bare(lambda work, i, u: turn(work.kinematics.turned[i], u))
swing = bare(lambda work, i, arm: cross(work.kinematics.omega[i], arm))


@bare
def push(work, i, arm, force):
    add(work.kinematics.force[i], 0, force)
    twist(work, i, cross(arm, force))


@bare
def twist(work, i, torque):
    """Add a torque (N m)."""
    add(work.kinematics.force[i], 3, torque)


pull = bare(lambda tension, gap, length: times(tension / length, gap))


@bare
def coordinate(work, i, component):
    kin = work.kinematics
    return kin.position[i, component], kin.velocity[i, component]
