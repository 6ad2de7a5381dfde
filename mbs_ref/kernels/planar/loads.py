"""Applied forces in the plane."""

from mbs_ref.kernels.jit import bare, jit


@bare
def apply_gravity(model, work):
    weigh(model.bodies, model.world.gravity, work.kinematics)


@bare
def weigh(bodies, gravity, kin):
    """Set the forces in `kin`, of floats or of lanes, to the weights."""
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


@bare
def apply_own_loads(model, work):
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
