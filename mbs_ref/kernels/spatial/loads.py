"""Applied forces in space: gravity, gyroscopic torques, forces, torques, springs, bushings, a user's own law.

Forces act at the centre of mass along world axes, with their torque about it: N and N m.
"""

# An intrinsic takes one argument fewer than its definition.
# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.callback import call_user_force
from mbs_ref.kernels.controls import CONTROL_MODE_TIME
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.signals import evaluate
from mbs_ref.kernels.spatial.joints import mark
from mbs_ref.kernels.spatial.model import (
    attraction_of,
    bodies_of,
    bushings_of,
    forces_of,
    kinematics_of,
    signals_of,
    springs_of,
    torsion_springs_of,
    world_of,
)
from mbs_ref.kernels.spatial.vectors import cross, dot, symmetric_times, turn, turn_back

LARGEST_TWIST = 3.0  # rad: beyond, a spring cannot know its turns, and its torque is NaN, which stops the run
SMALL_ANGLE = 1e-4  # rad: below, the rotation vector's functions use their series


@jit
def apply_gravity(model, work):
    """Set every force to the weight and -omega x J omega (Q_v); every other load adds to it."""
    bodies, kin, gravity = bodies_of(model), kinematics_of(work), world_of(model).gravity
    for i in range(bodies.mass.shape[0]):
        mass = bodies.mass[i]
        force = kin.force[i]
        force[0] = mass * gravity[0]
        force[1] = mass * gravity[1]
        force[2] = mass * gravity[2]
        w0, w1, w2 = kin.omega[i, 0], kin.omega[i, 1], kin.omega[i, 2]
        h0, h1, h2 = symmetric_times(kin.inertia[i], w0, w1, w2)
        force[3], force[4], force[5] = cross(h0, h1, h2, w0, w1, w2)


@jit
def push(kin, body, r0, r1, r2, f0, f1, f2):
    """Add a force at rho."""
    t0, t1, t2 = cross(r0, r1, r2, f0, f1, f2)
    force = kin.force[body]
    force[0] += f0
    force[1] += f1
    force[2] += f2
    force[3] += t0
    force[4] += t1
    force[5] += t2


@jit
def twist(kin, body, t0, t1, t2):
    """Add a torque."""
    kin.force[body, 3] += t0
    kin.force[body, 4] += t1
    kin.force[body, 5] += t2


@jit
def apply_forces(model, work, t):
    load, kin, signals = forces_of(model), kinematics_of(work), signals_of(model)
    mode_time = world_of(model).control[CONTROL_MODE_TIME]
    for k in range(load.body.shape[0]):
        body = load.body[k]
        scale, _, _ = evaluate(signals, load.signal[k], t, mode_time)
        f0, f1, f2 = load.force[k, 0], load.force[k, 1], load.force[k, 2]
        t0, t1, t2 = load.torque[k, 0], load.torque[k, 1], load.torque[k, 2]
        if load.follows[k] == 1:
            f0, f1, f2 = turn(kin.turned[body], load.force[k])
            t0, t1, t2 = turn(kin.turned[body], load.torque[k])
        r0, r1, r2 = turn(kin.turned[body], load.point[k])
        push(kin, body, r0, r1, r2, scale * f0, scale * f1, scale * f2)
        twist(kin, body, scale * t0, scale * t1, scale * t2)


@jit
def _gap(kin, a, b, point_a, point_b):
    """Return rho_a, rho_b, d = r_b - r_a and its rate."""
    a0, a1, a2, ta0, ta1, ta2 = mark(kin, a, point_a)
    b0, b1, b2, tb0, tb1, tb2 = mark(kin, b, point_b)
    return (
        a0, a1, a2, b0, b1, b2,
        kin.position[b, 0] + b0 - kin.position[a, 0] - a0,
        kin.position[b, 1] + b1 - kin.position[a, 1] - a1,
        kin.position[b, 2] + b2 - kin.position[a, 2] - a2,
        kin.velocity[b, 0] + tb0 - kin.velocity[a, 0] - ta0,
        kin.velocity[b, 1] + tb1 - kin.velocity[a, 1] - ta1,
        kin.velocity[b, 2] + tb2 - kin.velocity[a, 2] - ta2,
    )  # fmt: skip


@jit
def apply_springs(model, work):
    """F = k (l - l0) + c l_dot along the line of the two points (Fox 1999 eq 18 with the points' distance)."""
    spring, kin = springs_of(model), kinematics_of(work)
    for k in range(spring.a.shape[0]):
        a, b = spring.a[k], spring.b[k]
        a0, a1, a2, b0, b1, b2, d0, d1, d2, u0, u1, u2 = _gap(kin, a, b, spring.point_a[k], spring.point_b[k])
        length = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        stretch = length - spring.rest_length[k]
        if length == 0.0:  # no line of action: only the isotropic limit of the damper
            c = spring.damping[k]
            f0, f1, f2 = c * u0, c * u1, c * u2
        else:
            tension = spring.stiffness[k] * stretch + spring.damping[k] * dot(d0, d1, d2, u0, u1, u2) / length
            if spring.tension_only[k] == 1 and (stretch <= 0.0 or tension < 0.0):
                tension = 0.0
            share = tension / length
            f0, f1, f2 = share * d0, share * d1, share * d2
        push(kin, a, a0, a1, a2, f0, f1, f2)
        push(kin, b, b0, b1, b2, -f0, -f1, -f2)


@jit
def apply_torsion_springs(model, work):
    """Torque about an axis of body a on the angle of a mark of body b, counted from t = 0."""
    spring, kin = torsion_springs_of(model), kinematics_of(work)
    for k in range(spring.a.shape[0]):
        a, b = spring.a[k], spring.b[k]
        z0, z1, z2 = turn(kin.turned[a], spring.zero[k])
        q0, q1, q2 = turn(kin.turned[a], spring.quarter[k])
        m0, m1, m2 = turn(kin.turned[b], spring.mark[k])
        x0, x1, x2 = cross(z0, z1, z2, q0, q1, q2)  # the axis
        angle = np.arctan2(dot(q0, q1, q2, m0, m1, m2), dot(z0, z1, z2, m0, m1, m2))
        if abs(angle) > LARGEST_TWIST:
            angle = np.nan
        wa, wb = kin.omega[a], kin.omega[b]
        rate = dot(x0, x1, x2, wb[0] - wa[0], wb[1] - wa[1], wb[2] - wa[2])
        torque = spring.stiffness[k] * (angle - spring.rest_angle[k]) + spring.damping[k] * rate
        twist(kin, a, torque * x0, torque * x1, torque * x2)
        twist(kin, b, -torque * x0, -torque * x1, -torque * x2)


@jit
def rotation_vector(m):
    """Return the rotation vector of a matrix, of length below pi, and its length."""
    s0 = 0.5 * (m[2, 1] - m[1, 2])
    s1 = 0.5 * (m[0, 2] - m[2, 0])
    s2 = 0.5 * (m[1, 0] - m[0, 1])
    sine = np.sqrt(s0 * s0 + s1 * s1 + s2 * s2)
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    scale = 1.0 + angle * angle / 6.0 if sine < SMALL_ANGLE and cosine > 0.0 else angle / sine
    return scale * s0, scale * s1, scale * s2, angle


@jit
def apply_bushings(model, work):
    """Six springs and dampers along the bushing's axes in body a.

    Force K d on the offset d seen from a; torque J^-T K phi on the rotation vector phi of b seen from a,
    J^-T = I + [phi~] / 2 + c [phi~]^2, which is the gradient of phi^T K phi / 2.
    """
    load, kin = bushings_of(model), kinematics_of(work)
    here = np.empty((3, 3))
    there = np.empty((3, 3))
    relative = np.empty((3, 3))
    for k in range(load.a.shape[0]):
        a, b = load.a[k], load.b[k]
        _, _, _, b0, b1, b2, d0, d1, d2, u0, u1, u2 = _gap(kin, a, b, load.point_a[k], load.point_b[k])
        for r in range(3):
            for c in range(3):
                here[r, c] = 0.0
                there[r, c] = 0.0
                for s in range(3):
                    here[r, c] += kin.turned[a, r, s] * load.axes_a[k, s, c]
                    there[r, c] += kin.turned[b, r, s] * load.axes_b[k, s, c]
        for r in range(3):
            for c in range(3):
                relative[r, c] = here[0, r] * there[0, c] + here[1, r] * there[1, c] + here[2, r] * there[2, c]
        wa, wb = kin.omega[a], kin.omega[b]
        s0, s1, s2 = cross(wa[0], wa[1], wa[2], d0, d1, d2)
        x = turn_back(here, d0, d1, d2)
        xd = turn_back(here, u0 - s0, u1 - s1, u2 - s2)
        w = turn_back(here, wb[0] - wa[0], wb[1] - wa[1], wb[2] - wa[2])
        p0, p1, p2, angle = rotation_vector(relative)
        if angle > LARGEST_TWIST:
            p0 = np.nan
        stiff, damp = load.stiffness[k], load.damping[k]
        m0, m1, m2 = stiff[3] * p0, stiff[4] * p1, stiff[5] * p2
        c0, c1, c2 = cross(p0, p1, p2, m0, m1, m2)
        e0, e1, e2 = cross(p0, p1, p2, c0, c1, c2)
        if angle < SMALL_ANGLE:
            share = 1.0 / 12.0
        else:
            share = 1.0 / (angle * angle) - (1.0 + np.cos(angle)) / (2.0 * angle * np.sin(angle))
        force = (
            stiff[0] * x[0] + damp[0] * xd[0],
            stiff[1] * x[1] + damp[1] * xd[1],
            stiff[2] * x[2] + damp[2] * xd[2],
        )
        torque = (
            m0 + 0.5 * c0 + share * e0 + damp[3] * w[0],
            m1 + 0.5 * c1 + share * e1 + damp[4] * w[1],
            m2 + 0.5 * c2 + share * e2 + damp[5] * w[2],
        )
        f0, f1, f2 = turn(here, force)
        t0, t1, t2 = turn(here, torque)
        push(kin, b, b0, b1, b2, -f0, -f1, -f2)
        twist(kin, b, -t0, -t1, -t2)
        # the reaction acts on a where b's point is
        pb, pa = kin.position[b], kin.position[a]
        push(kin, a, pb[0] + b0 - pa[0], pb[1] + b1 - pa[1], pb[2] + b2 - pa[2], f0, f1, f2)
        twist(kin, a, t0, t1, t2)


@jit
def apply_attraction(model, work):
    """Add m_i gm_j d / r^3 over all pairs; a body of gm 0 is attracted and attracts nothing."""
    gm, mass, kin = attraction_of(model).gm, bodies_of(model).mass, kinematics_of(work)
    for i in range(gm.shape[0]):
        for j in range(i + 1, gm.shape[0]):
            d0 = kin.position[j, 0] - kin.position[i, 0]
            d1 = kin.position[j, 1] - kin.position[i, 1]
            d2 = kin.position[j, 2] - kin.position[i, 2]
            r2 = d0 * d0 + d1 * d1 + d2 * d2
            cube = 1.0 / (r2 * np.sqrt(r2))
            on_i, on_j = mass[i] * gm[j] * cube, -mass[j] * gm[i] * cube
            push(kin, i, 0.0, 0.0, 0.0, on_i * d0, on_i * d1, on_i * d2)
            push(kin, j, 0.0, 0.0, 0.0, on_j * d0, on_j * d1, on_j * d2)


@jit
def apply_user_force(model, work, t):
    """Call the user's law in scene order; it adds forces and torques about the centres of mass."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    n = bodies.mass.shape[0]
    for i in range(n):
        k = bodies.scene_index[i]
        for c in range(3):
            kin.user[0, k, c] = kin.position[i, c]
            kin.user[1, k, c] = kin.velocity[i, c]
            kin.user[1, k, 3 + c] = kin.omega[i, c]
        for c in range(4):
            kin.user[0, k, 3 + c] = kin.theta[i, c]
        for c in range(7):
            kin.user[2, k, c] = 0.0
    call_user_force(world_of(model).user_force[0], t, kin.user.ctypes.data)
    for i in range(n):
        for c in range(6):
            kin.force[i, c] += kin.user[2, bodies.scene_index[i], c]


@jit
def spatial_apply_loads(model, work, t):
    """Evaluate every applied force at the pose and motion in `work`."""
    apply_gravity(model, work)
    apply_forces(model, work, t)
    apply_springs(model, work)
    apply_torsion_springs(model, work)
    if bushings_of(model).a.shape[0] > 0:
        apply_bushings(model, work)
    if attraction_of(model).gm.shape[0] > 0:
        apply_attraction(model, work)
    if world_of(model).user_force[0] != 0:
        apply_user_force(model, work, t)
