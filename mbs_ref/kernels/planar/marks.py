"""Places and rates of planar bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

d(rho)/d(theta) = (-rho_y, rho_x). Vectors are pairs along world axes; rows of arrays are taken as well as pairs.
"""

from mbs_ref.kernels.jit import bare, jit

# Return row[k : k + 2].
pair = bare(lambda row, k: (row[k], row[k + 1]))
plus = bare(lambda a, b: (a[0] + b[0], a[1] + b[1]))
minus = bare(lambda a, b: (a[0] - b[0], a[1] - b[1]))
times = bare(lambda factor, a: (factor * a[0], factor * a[1]))
over = bare(lambda a, divisor: (a[0] / divisor, a[1] / divisor))
dot = bare(lambda a, b: a[0] * b[0] + a[1] * b[1])
# Return the third component of a x b.
cross = bare(lambda a, b: a[0] * b[1] - a[1] * b[0])
# Return a turned by 90 degrees: d(a)/d(theta).
perpendicular = bare(lambda a: (-a[1], a[0]))
# Return u turned by an angle of this cosine and sine.
rotated = bare(lambda c, s, u: (c * u[0] - s * u[1], s * u[0] + c * u[1]))

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


@bare
def apply_gravity(model, work):
    bodies, kin, gravity = model.bodies, work.kinematics, model.world.gravity
    gx = gravity[0]
    gy = gravity[1]
    for i in range(bodies.mass.shape[0]):
        kin.force[i, 0] = bodies.mass[i] * gx
        kin.force[i, 1] = bodies.mass[i] * gy
        kin.force[i, 2] = 0.0


@bare
def apply_torque(model, work, k, scale):
    load = model.forces
    work.kinematics.force[load.body[k], 2] += scale * load.torque[k, 0]


apply_own_loads = bare(lambda model, work: None)


@bare
def apply_torsion_springs(model, work):
    spring, kin = model.torsion_springs, work.kinematics
    for k in range(spring.a.shape[0]):
        a = spring.a[k]
        b = spring.b[k]
        turn = kin.motion[b, 3] - kin.motion[a, 3] - spring.rest_angle[k]
        torque = spring.stiffness[k] * turn + spring.damping[k] * (kin.motion[b, 2] - kin.motion[a, 2])
        kin.force[a, 2] += torque
        kin.force[b, 2] -= torque


@jit
def put_state(work, i, k):
    kin = work.kinematics
    kin.user[0, k, 0], kin.user[0, k, 1], kin.user[0, k, 2] = kin.pose[i, 0], kin.pose[i, 1], kin.motion[i, 3]
    for c in range(3):
        kin.user[1, k, c] = kin.motion[i, c]
