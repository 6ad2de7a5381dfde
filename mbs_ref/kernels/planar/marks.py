"""Places and rates of planar bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

d(rho)/d(theta) = (-rho_y, rho_x). Vectors are pairs along world axes.
"""

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.vectors import cross, over, pair, rotated, times

centre = bare(lambda work, i: pair(work.kinematics.pose[i], 0))
spin = bare(lambda work, i: abs(work.kinematics.motion[i, 2]))
speed = bare(lambda work, i: pair(work.kinematics.motion[i], 0))


@bare
def turned(work, i, u):
    pose = work.kinematics.pose[i]
    return rotated(pose[2], pose[3], u)


@bare
def swing(work, i, arm):
    omega = work.kinematics.motion[i, 2]
    return -arm[1] * omega, arm[0] * omega


@bare
def push(work, i, arm, force):
    on = work.kinematics.force[i]
    on[0] += force[0]
    on[1] += force[1]
    on[2] += cross(arm, force)


pull = bare(lambda tension, gap, length: over(times(tension, gap), length))


@bare
def coordinate(work, i, component):
    kin = work.kinematics
    return kin.motion[i, 3] if component == 2 else kin.pose[i, component], kin.motion[i, component]
