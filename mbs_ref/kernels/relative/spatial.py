"""A spatial tree in relative coordinates, by the articulated-body algorithm of `planar`, in linear time.

State y = [q, u]: R, theta0..theta3 and R', omega of a free body; an angle a revolute, a length a prismatic joint; a
ball carries its body's orientation, theta0..theta3 and omega. omega is in body axes, as in the redundant core.
"""

import numpy as np

from mbs_ref.kernels.algebra.dense import factor6, ldl3, ldl3_solve, solve6
from mbs_ref.kernels.algebra.lanes import cos_sin, either, larger
from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.jit import inlined, jit
from mbs_ref.kernels.relative.model import FREE, HELD, PRISMATIC, REVOLUTE, SPHERICAL, WELD
from mbs_ref.kernels.spatial.dynamics import SpatialModel, SpatialModelInLanes, SpatialWork, SpatialWorkInLanes
from mbs_ref.kernels.spatial.marks import add, cross, dot, minus, negative, plus, put, times, triple, turn, turn_back
from mbs_ref.kernels.spatial.model import RATES
from mbs_ref.kernels.spatial.orientation import (
    composed,
    parameters,
    put_parameters,
    rotation,
    scale_theta,
    theta_rate,
    world_inertia,
)

NOTHING = (0.0, 0.0, 0.0)


_redundant_model = either(
    "_redundant_model(model)", jit(lambda model: SpatialModel(model.redundant.address[0])),
    jit(lambda model: SpatialModelInLanes(model.redundant.address[0])),
)  # fmt: skip
_redundant_work = either(
    "_redundant_work(model)", jit(lambda model: SpatialWork(model.redundant.address[1])),
    jit(lambda model: SpatialWorkInLanes(model.redundant.address[1])),
)  # fmt: skip


@jit
def place_spatial(model, work, y):
    """Write every body's pose and motion to the redundant system's scratch, and the joints' links."""
    joints, links = model.joints, work.links
    bodies, kin = _redundant_model(model).bodies, _redundant_work(model).kinematics
    for i in range(joints.kind.shape[0]):
        own = links.velocity[i]
        if bodies.rigid[i] == 1:
            _orient(joints, kin, y, i)
            kin.norm[i] = rotation(parameters(kin.theta[i], 0), kin.turned[i]) - 1.0
            world_inertia(kin.turned[i], bodies.inertia[i], kin.inertia[i])
        if joints.kind[i] == FREE:
            put(kin.position[i], 0, triple(y, joints.q[i]))
            put(own, 0, triple(y, joints.v[i]))
            if bodies.rigid[i] == 1:
                put(own, 3, turn(kin.turned[i], triple(y, joints.v[i] + 3)))
        else:
            _put_joined(joints, links, kin, y, i)
        put(kin.velocity[i], 0, own)
        put(kin.omega[i], 0, triple(own, 3))


@inlined
def _orient(joints, kin, y, i):
    """Write the Euler parameters of a rigid body."""
    kind, parent, q = joints.kind[i], joints.parent[i], joints.q[i]
    if kind == FREE:
        put_parameters(kin.theta[i], 0, parameters(y, q + 3))
        return
    if kind == SPHERICAL:
        put_parameters(kin.theta[i], 0, parameters(y, q))
        return
    own = parameters(joints.offset[i], 0)
    if kind == REVOLUTE:
        (c, s), axis = cos_sin(0.5 * y[q]), joints.axis[i]
        own = composed(own, (c, s * axis[0], s * axis[1], s * axis[2]))
    if parent < joints.kind.shape[0]:
        own = composed(parameters(kin.theta[parent], 0), own)
    put_parameters(kin.theta[i], 0, own)


# Return the way from a joint's point to its body's centre of mass.
_away = jit(lambda joints, kin, i: negative(turn(kin.turned[i], joints.arm[i])))


@inlined
def _put_joined(joints, links, kin, y, i):
    kind, parent, q, v = joints.kind[i], joints.parent[i], joints.q[i], joints.v[i]
    free, bias, spin = links.freedom[i], links.bias[i], triple(links.velocity[parent], 3)
    reach = turn(kin.turned[parent], joints.arm_of_parent[i])
    away = _away(joints, kin, i)
    own, apart, slide, bent = spin, reach, NOTHING, NOTHING
    if kind == SPHERICAL:
        own = turn(kin.turned[i], triple(y, v))
    elif kind == REVOLUTE:
        axis = turn(kin.turned[i], joints.axis[i])
        put(free, 0, cross(axis, away))
        put(free, 3, axis)
        turning = times(y[v], axis)
        own, bent, apart = plus(spin, turning), cross(spin, turning), plus(reach, away)
    elif kind == PRISMATIC:
        e = turn(kin.turned[parent], joints.axis[i])
        put(free, 0, e)
        reach, slide = plus(reach, times(y[q], e)), times(y[v], e)
        apart = plus(reach, away)
    elif kind == WELD:
        apart = plus(reach, away)
    put(links.apart[i], 0, apart)
    put(kin.position[i], 0, plus(triple(kin.position[parent], 0), plus(reach, away)))
    carried = plus(triple(links.velocity[parent], 0), cross(spin, reach))
    put(links.velocity[i], 0, plus(plus(carried, slide), cross(own, away)))
    put(links.velocity[i], 3, NOTHING if kind == HELD else own)
    whirl = plus(cross(spin, plus(cross(spin, reach), times(2.0, slide))), cross(own, cross(own, away)))
    put(bias, 0, plus(whirl, cross(bent, away)))
    put(bias, 3, bent)


@jit
def relative_spatial_expand(model, work, y):
    place_spatial(model, work, y)
    full, bodies, kin = work.full, _redundant_model(model).bodies, _redundant_work(model).kinematics
    for i in range(bodies.mass.shape[0]):
        put(full.state, bodies.q[i], kin.position[i])
        put(full.state, bodies.v[i], kin.velocity[i])
        if bodies.rigid[i] == 1:
            put_parameters(full.state, bodies.q[i] + 3, parameters(kin.theta[i], 0))
            put(full.state, bodies.v[i] + 3, turn_back(kin.turned[i], triple(kin.omega[i], 0)))


@jit
def _symmetric_times(a, u, out):
    """out = I u with the lower triangle of I."""
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    a10, a20, a21, a30, a31, a32 = a[1, 0], a[2, 0], a[2, 1], a[3, 0], a[3, 1], a[3, 2]
    a40, a41, a42, a43 = a[4, 0], a[4, 1], a[4, 2], a[4, 3]
    a50, a51, a52, a53, a54 = a[5, 0], a[5, 1], a[5, 2], a[5, 3], a[5, 4]
    out[0] = a[0, 0] * u0 + a10 * u1 + a20 * u2 + a30 * u3 + a40 * u4 + a50 * u5
    out[1] = a[1, 1] * u1 + a10 * u0 + a21 * u2 + a31 * u3 + a41 * u4 + a51 * u5
    out[2] = a[2, 2] * u2 + a20 * u0 + a21 * u1 + a32 * u3 + a42 * u4 + a52 * u5
    out[3] = a[3, 3] * u3 + a30 * u0 + a31 * u1 + a32 * u2 + a43 * u4 + a53 * u5
    out[4] = a[4, 4] * u4 + a40 * u0 + a41 * u1 + a42 * u2 + a43 * u3 + a54 * u5
    out[5] = a[5, 5] * u5 + a50 * u0 + a51 * u1 + a52 * u2 + a53 * u3 + a54 * u4


@jit
def _times(first, second):
    total = 0.0
    for r in RATES:
        total += first[r] * second[r]
    return total


@inlined
def _free_one(links, rec, i):
    """Take out one freedom: I - I S D^-1 S^T I and f - I S D^-1 S^T f."""
    a, f, u, s = rec.articulated[i], rec.force[i], rec.answer[i, 0], links.freedom[i]
    _symmetric_times(a, s, u)
    inverse, load = 1.0 / _times(s, u), _times(s, f)
    rec.pivot[i, 0], rec.drive[i, 0] = inverse, load
    for r in RATES:
        share = inverse * u[r]
        f[r] -= load * share
        for c in range(r + 1):
            a[r, c] -= share * u[c]


# Return a column of H, and the upper left block of I as rows.
_column_from = jit(lambda a, k: (a[3, k], a[4, k], a[5, k]))
_mass = jit(lambda a: ((a[0, 0], a[1, 0], a[2, 0]), (a[1, 0], a[1, 1], a[2, 1]), (a[2, 0], a[2, 1], a[2, 2])))
_row = jit(lambda columns, r: (columns[0][r], columns[1][r], columns[2][r]))


@jit
def _shifted(a, d, t):
    """Return the columns of H' and the rows of J', of X^T I X = (M, H'^T; H', J').

    With I = (M, H^T; H, J) and X (v, w) = (v + w x d, t w): H' = d x M + t H, J' = d x H'^T + t (d x H^T + t J).
    """
    m, k = _mass(a), (cross(d, triple(a[3], 0)), cross(d, triple(a[4], 0)), cross(d, triple(a[5], 0)))
    h = (
        plus(cross(d, m[0]), times(t, _column_from(a, 0))), plus(cross(d, m[1]), times(t, _column_from(a, 1))),
        plus(cross(d, m[2]), times(t, _column_from(a, 2))),
    )  # fmt: skip
    x, y, z = cross(d, _row(h, 0)), cross(d, _row(h, 1)), cross(d, _row(h, 2))
    s = t * t
    return h, (
        x[0] + t * k[0][0] + s * a[3, 3], y[0] + t * k[0][1] + s * a[4, 3], y[1] + t * k[1][1] + s * a[4, 4],
        z[0] + t * k[0][2] + s * a[5, 3], z[1] + t * k[1][2] + s * a[5, 4], z[2] + t * k[2][2] + s * a[5, 5],
    )  # fmt: skip


@jit
def _receive(onto, push, m, h, j, force, torque):
    """I += (M, H^T; H, J) and f += (force, torque), by the rows of M, the columns of H and the lower triangle of J."""
    for r in range(3):
        for c in range(3):
            onto[3 + r, c] += h[c][r]
        for c in range(r + 1):
            onto[r, c] += m[r][c]
    onto[3, 3] += j[0]
    onto[4, 3] += j[1]
    onto[4, 4] += j[2]
    onto[5, 3] += j[3]
    onto[5, 4] += j[4]
    onto[5, 5] += j[5]
    add(push, 0, force)
    add(push, 3, torque)


@inlined
def _pass_ball(joints, links, kin, rec, i):
    """Add to the parent what a ball leaves: a mass M - H^T J^-1 H at its point, about which H and J are here."""
    a, f, away, parent = rec.articulated[i], rec.force[i], _away(joints, kin, i), joints.parent[i]
    w, d, m = triple(links.bias[i], 0), triple(links.apart[i], 0), _mass(a)
    h, j = _shifted(a, away, 1.0)
    force = minus(triple(f, 0), (dot(m[0], w), dot(m[1], w), dot(m[2], w)))
    torque = minus(triple(f, 3), (dot(triple(a[3], 0), w), dot(triple(a[4], 0), w), dot(triple(a[5], 0), w)))
    torque = plus(torque, cross(away, force))
    factors = ldl3(j[0], j[1], j[2], j[3], j[4], j[5])
    for k in range(3):
        put(rec.answer[i, k], 0, h[k])
    for k in range(6):
        rec.pivot[i, k] = factors[k]
    put(rec.drive[i], 0, torque)
    if parent == joints.kind.shape[0]:
        return
    turning = ldl3_solve(factors, torque)
    force = minus(force, (dot(h[0], turning), dot(h[1], turning), dot(h[2], turning)))
    x, y, z = ldl3_solve(factors, h[0]), ldl3_solve(factors, h[1]), ldl3_solve(factors, h[2])
    m10, m20, m21 = m[1][0] - dot(h[1], x), m[2][0] - dot(h[2], x), m[2][1] - dot(h[2], y)
    left = (m[0][0] - dot(h[0], x), m10, m20), (m10, m[1][1] - dot(h[1], y), m21), (m20, m21, m[2][2] - dot(h[2], z))
    h = cross(d, left[0]), cross(d, left[1]), cross(d, left[2])
    x, y, z = cross(d, _row(h, 0)), cross(d, _row(h, 1)), cross(d, _row(h, 2))
    onto = (x[0], y[0], y[1], z[0], z[1], z[2])
    _receive(rec.articulated[parent], rec.force[parent], left, h, onto, force, cross(d, force))


@inlined
def _condense(joints, links, kin, rec, i):
    """Add I' = X^T I X and X^T f of a body to its parent's; what its joint needs is stored."""
    if joints.kind[i] == SPHERICAL:
        _pass_ball(joints, links, kin, rec, i)
        return
    a, f, parent, t, d = rec.articulated[i], rec.force[i], joints.parent[i], links.turns[i], triple(links.apart[i], 0)
    own = rec.acceleration[i]  # not in use yet
    _symmetric_times(a, links.bias[i], own)
    for r in RATES:
        f[r] -= own[r]
    if joints.freedoms[i] == 1:
        _free_one(links, rec, i)
    if parent < joints.kind.shape[0]:
        h, j = _shifted(a, d, t)
        torque = plus(cross(d, triple(f, 0)), times(t, triple(f, 3)))
        _receive(rec.articulated[parent], rec.force[parent], _mass(a), h, j, triple(f, 0), torque)


@inlined
def _release(joints, links, kin, rec, i):
    """Solve for q'' of a body's joint and its acceleration, its parent's being known."""
    own, of_parent, drive, u = rec.acceleration[i], rec.acceleration[joints.parent[i]], rec.drive[i], rec.answer[i]
    if joints.kind[i] == FREE:
        factor6(rec.articulated[i])
        straight, turning = solve6(rec.articulated[i], triple(rec.force[i], 0), triple(rec.force[i], 3))
        put(own, 0, straight)
        put(own, 3, turning)
        put(drive, 0, straight)
        put(drive, 3, turn_back(kin.turned[i], turning))
        return
    alpha = triple(of_parent, 3)
    point = plus(triple(of_parent, 0), cross(alpha, links.apart[i]))
    if joints.kind[i] == SPHERICAL:
        carried = plus(plus(times(point[0], u[0]), times(point[1], u[1])), times(point[2], u[2]))
        alpha = ldl3_solve(rec.pivot[i], minus(triple(drive, 0), carried))
        put(own, 0, plus(plus(point, cross(alpha, _away(joints, kin, i))), triple(links.bias[i], 0)))
        put(own, 3, alpha)
        put(drive, 0, turn_back(kin.turned[i], alpha))
        return
    put(own, 0, point)
    put(own, 3, times(links.turns[i], alpha))
    if joints.freedoms[i] == 1:
        drive[0] = rec.pivot[i, 0] * (drive[0] - _times(u[0], own))
        for r in RATES:
            own[r] += links.freedom[i, r] * drive[0]
    for r in RATES:
        own[r] += links.bias[i, r]


@jit
def _load_blocks(model, work):
    bodies, kin, rec = _redundant_model(model).bodies, _redundant_work(model).kinematics, work.recursion
    for i in range(bodies.mass.shape[0]):
        a, j = rec.articulated[i], kin.inertia[i]
        for r in RATES:
            rec.force[i, r] = kin.force[i, r]
            for c in range(r):
                a[r, c] = 0.0
        for r in range(3):
            a[r, r] = bodies.mass[i]
            a[3 + r, 3 + r] = j[r]
        a[4, 3], a[5, 3], a[5, 4] = j[3], j[4], j[5]


@jit
def relative_spatial_derivative(model, work, t, y, dy):
    """Write dy/dt: lengths, angles and theta' = E^T omega / 2, then u'."""
    place_spatial(model, work, y)
    ask.apply_loads(_redundant_model(model), _redundant_work(model), t)
    joints, links, rec = model.joints, work.links, work.recursion
    kin = _redundant_work(model).kinematics
    n = joints.kind.shape[0]
    _load_blocks(model, work)
    for i in range(n - 1, -1, -1):
        if joints.kind[i] != FREE:
            _condense(joints, links, kin, rec, i)
    for i in range(n):
        _release(joints, links, kin, rec, i)
        q, v, count = joints.q[i], joints.v[i], joints.freedoms[i]
        for k in range(count):
            dy[v + k] = rec.drive[i, k]
        if joints.kind[i] == SPHERICAL:
            put_parameters(dy, q, theta_rate(parameters(y, q), triple(kin.omega[i], 0)))
            continue
        for k in range(min(count, 3)):
            dy[q + k] = y[v + k]
        if count == 6:
            put_parameters(dy, q + 3, theta_rate(parameters(y, q + 3), triple(kin.omega[i], 0)))


@jit
def relative_spatial_position_rate(model, y, rate, out):
    """Write the rates of lengths, angles and Euler parameters at `rate`: theta' = theta (0, omega) / 2."""
    joints = model.joints
    start = np.min(joints.v)
    for i in range(joints.kind.shape[0]):
        q, v, count = joints.q[i], joints.v[i] - start, joints.freedoms[i]
        k = _theta_of(joints, i)
        if k >= 0:
            half = times(0.5, triple(rate, v + k - q))
            put_parameters(out, k, composed(parameters(y, k), (0.0, half[0], half[1], half[2])))
        if joints.kind[i] != SPHERICAL:
            for c in range(min(count, 3)):
                out[q + c] = rate[v + c]


@jit
def relative_spatial_rate_from(model, y, moved, out):
    """Write the rates, turns in body axes, that rates of lengths, angles and Euler parameters mean."""
    joints = model.joints
    start = np.min(joints.v)
    for i in range(joints.kind.shape[0]):
        q, v = joints.q[i], joints.v[i] - start
        k = _theta_of(joints, i)
        if k >= 0:
            e0, e1, e2, e3 = parameters(y, k)
            put(out, v + k - q, times(2.0, composed((e0, -e1, -e2, -e3), parameters(moved, k))[1:]))
        if joints.kind[i] != SPHERICAL:
            for c in range(min(joints.freedoms[i], 3)):
                out[v + c] = moved[q + c]


@jit
def _theta_of(joints, i):
    """Return the place of a joint's Euler parameters in the state, -1 where it has none."""
    if joints.kind[i] == SPHERICAL:
        return joints.q[i]
    return joints.q[i] + 3 if joints.freedoms[i] == 6 else -1


@jit
def relative_spatial_compliance(model, work, t, y):
    """Return the largest |theta . theta - 1|: no other constraint is left."""
    joints, largest = model.joints, 0.0
    for i in range(joints.kind.shape[0]):
        k = _theta_of(joints, i)
        if k >= 0:
            e0, e1, e2, e3 = parameters(y, k)
            largest = larger(largest, abs(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3 - 1.0))
    return largest, 0.0


@jit
def relative_spatial_project(model, work, t, y, tolerance, most):
    """Bring Euler parameters to norm one."""
    joints = model.joints
    for i in range(joints.kind.shape[0]):
        k = _theta_of(joints, i)
        if k >= 0:
            scale_theta(y, k, 1.0)
    return relative_spatial_compliance(model, work, t, y)[0]


@jit
def relative_spatial_take_velocities(model, work, y):
    joints, links, full, bodies = model.joints, work.links, work.full, _redundant_model(model).bodies
    kin = _redundant_work(model).kinematics
    for i in range(bodies.mass.shape[0]):
        own, of_parent, v = links.velocity[i], links.velocity[joints.parent[i]], joints.v[i]
        put(own, 0, triple(full.state, bodies.v[i]))
        if bodies.rigid[i] == 1:
            put(own, 3, turn(kin.turned[i], triple(full.state, bodies.v[i] + 3)))
        kind, spin = joints.kind[i], triple(of_parent, 3)
        if kind == REVOLUTE:
            y[v] = dot(minus(triple(own, 3), spin), triple(links.freedom[i], 3))
        elif kind == PRISMATIC:
            carried = plus(triple(of_parent, 0), cross(spin, links.apart[i]))
            y[v] = dot(minus(triple(own, 0), carried), triple(links.freedom[i], 0))
        elif kind == SPHERICAL:
            put(y, v, turn_back(kin.turned[i], triple(own, 3)))
        elif kind == FREE:
            put(y, v, own)
            if bodies.rigid[i] == 1:
                put(y, v + 3, turn_back(kin.turned[i], triple(own, 3)))
