"""Applied forces in space: gravity, gyroscopic torques, forces, torques, springs, bushings, a user's own law.

Forces act at the centre of mass along world axes, with their torque about it: N and N m.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import lane_by_lane
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid.marks import rate_seen, separation
from mbs_ref.kernels.spatial.marks import (
    add,
    cross,
    dot,
    minus,
    negative,
    plus,
    push,
    put,
    symmetric_times,
    times,
    triple,
    turn,
    turn_back,
    turned,
    twist,
)

LARGEST_TWIST = 3.0  # rad: beyond, a spring cannot know its turns, and its torque is NaN, which stops the run
SMALL_ANGLE = 1e-4  # rad: below, the rotation vector's functions use their series


@bare
def apply_gravity(model, work):
    """The torque is -omega x J omega (Q_v)."""
    bodies, kin, gravity = model.bodies, work.kinematics, model.world.gravity
    for i in range(bodies.mass.shape[0]):
        force, omega = kin.force[i], kin.omega[i]
        put(force, 0, times(bodies.mass[i], gravity))
        put(force, 3, cross(symmetric_times(kin.inertia[i], omega), omega))


@bare
def apply_torque(model, work, k, scale):
    load = model.forces
    body, torque = load.body[k], triple(load.torque[k], 0)
    twist(work, body, times(scale, turned(work, body, torque) if load.follows[k] == 1 else torque))


@bare
def _angle_within(stiffness, sine, cosine):
    angle = np.arctan2(sine, cosine)
    # a mere damper need not count turns
    return np.nan if stiffness > 0.0 and abs(angle) > LARGEST_TWIST else angle


_known_angle = lane_by_lane("_known_angle(stiffness, sine, cosine)", _angle_within)


@bare
def apply_torsion_springs(model, work):
    """Torque about an axis of body a on the angle of a mark of body b, counted from t = 0."""
    spring, kin = model.torsion_springs, work.kinematics
    for k in range(spring.a.shape[0]):
        a, b = spring.a[k], spring.b[k]
        zero, quarter = turned(work, a, spring.zero[k]), turned(work, a, spring.quarter[k])
        mark = turned(work, b, spring.mark[k])
        axis = cross(zero, quarter)
        angle = _known_angle(spring.stiffness[k], dot(quarter, mark), dot(zero, mark))
        rate = dot(axis, minus(kin.omega[b], kin.omega[a]))
        torque = spring.stiffness[k] * (angle - spring.rest_angle[k]) + spring.damping[k] * rate
        twist(work, a, times(torque, axis))
        twist(work, b, times(-torque, axis))


@jit
def rotation_vector(m):
    """Return the rotation vector of a matrix, of length below pi, and its length."""
    s = (0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1]))
    sine = np.sqrt(dot(s, s))
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    scale = 1.0 + angle * angle / 6.0 if sine < SMALL_ANGLE and cosine > 0.0 else angle / sine
    return times(scale, s), angle


@jit
def _product(m, n, out):
    """out = M N."""
    for r in range(3):
        for c in range(3):
            out[r, c] = 0.0
            for s in range(3):
                out[r, c] += m[r, s] * n[s, c]


@jit
def _relative(m, n, out):
    """out = M^T N."""
    for r in range(3):
        for c in range(3):
            out[r, c] = m[0, r] * n[0, c] + m[1, r] * n[1, c] + m[2, r] * n[2, c]


@jit
def _turning_spring(stiffness, relative):
    """Return J^-T K phi (N m) on the rotation vector phi of a matrix."""
    phi, angle = rotation_vector(relative)
    if angle > LARGEST_TWIST:
        phi = (np.nan, phi[1], phi[2])
    moment = (stiffness[0] * phi[0], stiffness[1] * phi[1], stiffness[2] * phi[2])
    once = cross(phi, moment)
    if angle < SMALL_ANGLE:
        share = 1.0 / 12.0
    else:
        share = 1.0 / (angle * angle) - (1.0 + np.cos(angle)) / (2.0 * angle * np.sin(angle))
    return plus(plus(moment, times(0.5, once)), times(share, cross(phi, once)))


@jit
def _spring_and_damper(stiffness, damping, offset, rate):
    return (
        stiffness[0] * offset[0] + damping[0] * rate[0],
        stiffness[1] * offset[1] + damping[1] * rate[1],
        stiffness[2] * offset[2] + damping[2] * rate[2],
    )


@jit
def apply_bushings(model, work):
    """Six springs and dampers along the bushing's axes in body a.

    Force K d on the offset d seen from a; torque J^-T K phi on the rotation vector phi of b seen from a,
    J^-T = I + [phi~] / 2 + c [phi~]^2, which is the gradient of phi^T K phi / 2.
    """
    load, kin = model.bushings, work.kinematics
    here, there, relative = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for k in range(load.a.shape[0]):
        a, b = load.a[k], load.b[k]
        stiffness, damping = load.stiffness[k], load.damping[k]
        apart = separation(work, a, b, load.point_a[k], load.point_b[k])
        _product(kin.turned[a], load.axes_a[k], here)
        _product(kin.turned[b], load.axes_b[k], there)
        _relative(here, there, relative)
        offset = turn_back(here, apart.gap)
        rate = turn_back(here, rate_seen(work, a, apart.gap, apart.rate))
        turning = turn_back(here, minus(kin.omega[b], kin.omega[a]))
        force = turn(here, _spring_and_damper(stiffness, damping, offset, rate))
        damper = (damping[3] * turning[0], damping[4] * turning[1], damping[5] * turning[2])
        torque = turn(here, plus(_turning_spring(stiffness[3:], relative), damper))
        push(work, b, apart.arm_b, negative(force))
        twist(work, b, negative(torque))
        # the reaction acts on a where b's point is
        push(work, a, minus(plus(kin.position[b], apart.arm_b), kin.position[a]), force)
        twist(work, a, torque)


@jit
def apply_attraction(model, work):
    """Add m_i gm_j d / r^3 over all pairs; a body of gm 0 is attracted and attracts nothing."""
    gm, mass, kin = model.attraction.gm, model.bodies.mass, work.kinematics
    for i in range(gm.shape[0]):
        for j in range(i + 1, gm.shape[0]):
            d = minus(kin.position[j], kin.position[i])
            square = dot(d, d)
            cube = 1.0 / (square * np.sqrt(square))
            add(kin.force[i], 0, times(mass[i] * gm[j] * cube, d))
            add(kin.force[j], 0, times(-mass[j] * gm[i] * cube, d))


@jit
def apply_gradients(model, work):
    """Add MacCullagh's torque 3 gm / d^5 (d x J d) and force, with the opposite on the centre."""
    pairs, kin = model.gradients, work.kinematics
    for k in range(pairs.a.shape[0]):
        a, b, inertia = pairs.a[k], pairs.b[k], kin.inertia[pairs.b[k]]
        d = minus(kin.position[b], kin.position[a])
        square = dot(d, d)
        factor = 3.0 * pairs.gm[k] / (square * square * np.sqrt(square))
        turned = symmetric_times(inertia, d)
        trace = inertia[0] + inertia[1] + inertia[2]
        force = plus(times(0.5 * (5.0 * dot(d, turned) / square - trace), d), negative(turned))
        add(kin.force[b], 0, times(factor, force))
        add(kin.force[b], 3, times(factor, cross(d, turned)))
        add(kin.force[a], 0, times(-factor, force))


@jit
def put_state(work, i, k):
    kin = work.kinematics
    for c in range(3):
        kin.user[0, k, c] = kin.position[i, c]
        kin.user[1, k, c] = kin.velocity[i, c]
        kin.user[1, k, 3 + c] = kin.omega[i, c]
    for c in range(4):
        kin.user[0, k, 3 + c] = kin.theta[i, c]


@jit
def apply_own_loads(model, work):
    if model.bushings.a.shape[0] > 0:
        apply_bushings(model, work)
    if model.attraction.gm.shape[0] > 0:
        apply_attraction(model, work)
    if model.gradients.a.shape[0] > 0:
        apply_gradients(model, work)
