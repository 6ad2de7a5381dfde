"""Generalized applied forces in the plane: gravity, forces, torques, springs, and a user's own law."""

from __future__ import annotations

from mbs_ref.kernels.border.calls import call_user
from mbs_ref.kernels.border.questions import apply_contacts
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.planar.marks import arm
from mbs_ref.kernels.planar.vectors import cross, times
from mbs_ref.kernels.rigid.model import (
    CONTROL_MODE_TIME,
    bodies_of,
    forces_of,
    kinematics_of,
    signals_of,
    torsion_springs_of,
    world_of,
)
from mbs_ref.kernels.rigid.springs import apply_springs
from mbs_ref.kernels.signals import evaluate


@jit
def apply_gravity(model, work):
    """Set every force to the weight; every other load adds to it."""
    weigh(bodies_of(model), world_of(model).gravity, kinematics_of(work))


@bare
def weigh(bodies, gravity, kin):
    """Set the forces in `kin`, of floats or of lanes, to the weights."""
    gx = gravity[0]
    gy = gravity[1]
    for i in range(bodies.mass.shape[0]):
        kin.force[i, 0] = bodies.mass[i] * gx
        kin.force[i, 1] = bodies.mass[i] * gy
        kin.force[i, 2] = 0.0


@jit
def apply_forces(model, work, t):
    load, kin, signals = forces_of(model), kinematics_of(work), signals_of(model)
    mode_time = world_of(model).control[CONTROL_MODE_TIME]
    for k in range(load.body.shape[0]):
        body = load.body[k]
        scale, _, _ = evaluate(signals, load.signal[k], t, mode_time)
        force = times(scale, load.vector[k])
        if load.follows[k] == 1:
            force = arm(kin.pose, body, force)
        torque = cross(arm(kin.pose, body, load.point[k]), force) + scale * load.torque[k]
        kin.force[body, 0] += force[0]
        kin.force[body, 1] += force[1]
        kin.force[body, 2] += torque


@jit
def apply_torsion_springs(model, work):
    spring, kin = torsion_springs_of(model), kinematics_of(work)
    for k in range(spring.a.shape[0]):
        a = spring.a[k]
        b = spring.b[k]
        turn = kin.motion[b, 3] - kin.motion[a, 3] - spring.rest_angle[k]
        torque = spring.stiffness[k] * turn + spring.damping[k] * (kin.motion[b, 2] - kin.motion[a, 2])
        kin.force[a, 2] += torque
        kin.force[b, 2] -= torque


@jit
def apply_user_force(model, work, t):
    """Call the user's law in scene order; it adds generalized forces."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    n = bodies.mass.shape[0]
    for i in range(n):
        k = bodies.scene_index[i]
        kin.user[0, k, 0] = kin.pose[i, 0]
        kin.user[0, k, 1] = kin.pose[i, 1]
        kin.user[0, k, 2] = kin.motion[i, 3]
        for c in range(3):
            kin.user[1, k, c] = kin.motion[i, c]
            kin.user[2, k, c] = 0.0
    call_user(world_of(model).user_force[0], t, kin.user.ctypes.data)  # pyright: ignore[reportCallIssue]
    for i in range(n):
        for c in range(3):
            kin.force[i, c] += kin.user[2, bodies.scene_index[i], c]


@jit
def planar_apply_loads(model, work, t):
    """Evaluate every applied force at the pose and motion in `work`."""
    apply_gravity(model, work)
    apply_forces(model, work, t)
    apply_springs(model, work)
    apply_torsion_springs(model, work)
    apply_contacts(model, work)
    if world_of(model).user_force[0] != 0:
        apply_user_force(model, work, t)
