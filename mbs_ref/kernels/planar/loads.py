"""Generalized applied forces in the plane: gravity, forces, torques, springs, and a user's own law."""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.callback import call_user_force
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.joints import _arm
from mbs_ref.kernels.signals import evaluate


@jit
def apply_gravity(model, work):
    """Set every force to the weight; every other load adds to it."""
    gx = model.gravity[0]
    gy = model.gravity[1]
    for i in range(model.bodies.mass.shape[0]):
        work.force[i, 0] = model.bodies.mass[i] * gx
        work.force[i, 1] = model.bodies.mass[i] * gy
        work.force[i, 2] = 0.0


@jit
def apply_forces(model, work, t):
    load = model.forces
    for k in range(load.body.shape[0]):
        body = load.body[k]
        scale, _, _ = evaluate(model.signals, load.signal[k], t, model.control[0])
        fx = scale * load.vector[k, 0]
        fy = scale * load.vector[k, 1]
        if load.follows[k] == 1:
            c = work.pose[body, 2]
            s = work.pose[body, 3]
            fx, fy = c * fx - s * fy, s * fx + c * fy
        rx, ry = _arm(work.pose, body, load.point[k])
        work.force[body, 0] += fx
        work.force[body, 1] += fy
        work.force[body, 2] += rx * fy - ry * fx + scale * load.torque[k]


@jit
def apply_springs(model, work):
    """F = k (l - l0) + c l_dot along the line of the two points (Fox 1999 eq 18 with the points' distance)."""
    spring = model.springs
    for k in range(spring.a.shape[0]):
        a = spring.a[k]
        b = spring.b[k]
        ax, ay = _arm(work.pose, a, spring.point_a[k])
        bx, by = _arm(work.pose, b, spring.point_b[k])
        dx = work.pose[b, 0] + bx - work.pose[a, 0] - ax
        dy = work.pose[b, 1] + by - work.pose[a, 1] - ay
        ux = work.motion[b, 0] - by * work.motion[b, 2] - work.motion[a, 0] + ay * work.motion[a, 2]
        uy = work.motion[b, 1] + bx * work.motion[b, 2] - work.motion[a, 1] - ax * work.motion[a, 2]
        length = np.sqrt(dx * dx + dy * dy)
        stretch = length - spring.rest_length[k]
        if length == 0.0:
            fx = spring.damping[k] * ux  # no line of action: only the isotropic limit of the damper
            fy = spring.damping[k] * uy
        else:
            tension = spring.stiffness[k] * stretch + spring.damping[k] * (dx * ux + dy * uy) / length
            if spring.tension_only[k] == 1 and (stretch <= 0.0 or tension < 0.0):
                tension = 0.0
            fx = tension * dx / length
            fy = tension * dy / length
        work.force[a, 0] += fx
        work.force[a, 1] += fy
        work.force[a, 2] += ax * fy - ay * fx
        work.force[b, 0] -= fx
        work.force[b, 1] -= fy
        work.force[b, 2] -= bx * fy - by * fx


@jit
def apply_torsion_springs(model, work):
    spring = model.torsion_springs
    for k in range(spring.a.shape[0]):
        a = spring.a[k]
        b = spring.b[k]
        turn = work.motion[b, 3] - work.motion[a, 3] - spring.rest_angle[k]
        torque = spring.stiffness[k] * turn + spring.damping[k] * (work.motion[b, 2] - work.motion[a, 2])
        work.force[a, 2] += torque
        work.force[b, 2] -= torque


@jit
def apply_user_force(model, work, t):
    """Call the user's law in scene order; it adds generalized forces."""
    bodies = model.bodies
    n = bodies.mass.shape[0]
    for i in range(n):
        k = bodies.scene_index[i]
        work.user[0, k, 0] = work.pose[i, 0]
        work.user[0, k, 1] = work.pose[i, 1]
        work.user[0, k, 2] = work.motion[i, 3]
        for c in range(3):
            work.user[1, k, c] = work.motion[i, c]
            work.user[2, k, c] = 0.0
    call_user_force(model.user_force[0], t, work.user.ctypes.data)
    for i in range(n):
        for c in range(3):
            work.force[i, c] += work.user[2, bodies.scene_index[i], c]


@jit
def apply_loads(model, work, t):
    """Evaluate every applied force at the pose and motion in `work`."""
    apply_gravity(model, work)
    apply_forces(model, work, t)
    apply_springs(model, work)
    apply_torsion_springs(model, work)
    if model.user_force[0] != 0:
        apply_user_force(model, work, t)
