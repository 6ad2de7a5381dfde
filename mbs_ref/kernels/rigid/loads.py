"""Applied forces in the plane and in space: gravity, forces, springs, contacts, a core's own loads and a user's."""

from __future__ import annotations

from mbs_ref.kernels.border.calls import call_user
from mbs_ref.kernels.border.questions import apply_contacts
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME, bodies_of, forces_of, kinematics_of, signals_of, world_of
from mbs_ref.kernels.rigid.springs import apply_springs
from mbs_ref.kernels.signals import evaluate


@jit
def _apply_forces(model, work, t):
    load, signals, mode_time = forces_of(model), signals_of(model), world_of(model).control[CONTROL_MODE_TIME]
    for k in range(load.body.shape[0]):
        scale, _, _ = evaluate(signals, load.signal[k], t, mode_time)
        body, force = load.body[k], core.times(work, scale, load.force[k])
        if load.follows[k] == 1:
            force = core.turned(work, body, force)
        core.push(work, body, core.turned(work, body, load.point[k]), force)
        core.apply_torque(model, work, k, scale)


@jit
def _apply_user_force(model, work, t):
    """Call the user's law in scene order; it adds forces and torques about the centres of mass."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    n = bodies.mass.shape[0]
    for i in range(n):
        core.put_state(work, i, bodies.scene_index[i])
        for c in range(kin.user.shape[2]):
            kin.user[2, i, c] = 0.0
    call_user(world_of(model).user_force[0], t, kin.user.ctypes.data)  # pyright: ignore[reportCallIssue]
    for i in range(n):
        for c in range(len(core.block(model))):
            kin.force[i, c] += kin.user[2, bodies.scene_index[i], c]


@jit
def rigid_apply_loads(model, work, t):
    """Evaluate every applied force at the pose and motion in `work`."""
    core.apply_gravity(model, work)
    _apply_forces(model, work, t)
    apply_springs(model, work)
    core.apply_own_loads(model, work)
    apply_contacts(model, work)
    if world_of(model).user_force[0] != 0:
        _apply_user_force(model, work, t)
