"""Places and rates of planar bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

d(rho)/d(theta) = (-rho_y, rho_x). Vectors are pairs along world axes.
"""

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.vectors import cross, over, pair, rotated, times


@bare
def centre(work, i):
    return pair(work.kinematics.pose[i], 0)


@bare
def spin(work, i):
    return abs(work.kinematics.motion[i, 2])


@bare
def speed(work, i):
    return pair(work.kinematics.motion[i], 0)


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


@bare
def pull(tension, gap, length):
    return over(times(tension, gap), length)


@bare
def coordinate(work, i, component):
    kin = work.kinematics
    return kin.motion[i, 3] if component == 2 else kin.pose[i, component], kin.motion[i, component]
