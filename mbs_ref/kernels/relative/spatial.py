"""A spatial tree in relative coordinates, by the articulated-body algorithm of `planar`, in linear time.

State y = [q, u]: R, theta0..theta3 and R', omega of a free body; an angle a revolute, a length a prismatic joint; a
ball carries its body's orientation, theta0..theta3 and omega. omega is in body axes, as in the redundant core.
"""

import numpy as np

from mbs_ref.kernels.algebra.dense import factor_ldl, ldl3, ldl3_solve, solve_ldl
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


@jit
def _put_freedom(freedom, axis, away):
    """Write the freedom to turn about an axis that `away` starts from."""
    put(freedom, 0, cross(axis, away))
    put(freedom, 3, axis)


_column = jit(lambda a, k: (a[0, k], a[1, k], a[2, k]))


@inlined
def _put_joined(joints, links, kin, y, i):
    kind, parent, q, v = joints.kind[i], joints.parent[i], joints.q[i], joints.v[i]
    free, bias, spin = links.freedom[i], links.bias[i], triple(links.velocity[parent], 3)
    reach = turn(kin.turned[parent], joints.arm_of_parent[i])
    away = negative(turn(kin.turned[i], joints.arm[i]))  # from the joint's point to the centre of mass
    own, apart, slide, bent = spin, reach, NOTHING, NOTHING
    if kind == SPHERICAL:
        for k in range(3):
            _put_freedom(free[k], _column(kin.turned[i], k), away)
        own = turn(kin.turned[i], triple(y, v))
    elif kind == REVOLUTE:
        axis = turn(kin.turned[i], joints.axis[i])
        _put_freedom(free[0], axis, away)
        turning = times(y[v], axis)
        own, bent, apart = plus(spin, turning), cross(spin, turning), plus(reach, away)
    elif kind == PRISMATIC:
        e = turn(kin.turned[parent], joints.axis[i])
        put(free[0], 0, e)
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
    for r in RATES:
        out[r] = 0.0
    for r in RATES:
        out[r] += a[r, r] * u[r]
        for c in range(r):
            out[r] += a[r, c] * u[c]
            out[c] += a[r, c] * u[r]


@jit
def _times(first, second):
    total = 0.0
    for r in RATES:
        total += first[r] * second[r]
    return total


@inlined
def _free_one(links, rec, i):
    """Take out one freedom: I - I S D^-1 S^T I and f - I S D^-1 S^T f."""
    a, f, u, s = rec.articulated[i], rec.force[i], rec.answer[i, 0], links.freedom[i, 0]
    _symmetric_times(a, s, u)
    inverse, load = 1.0 / _times(s, u), _times(s, f)
    rec.pivot[i, 0], rec.drive[i, 0] = inverse, load
    for r in RATES:
        share = inverse * u[r]
        f[r] -= load * share
        for c in range(r + 1):
            a[r, c] -= share * u[c]


@inlined
def _free_three(links, rec, i):
    """Take out the three freedoms of a ball."""
    a, f, u, s = rec.articulated[i], rec.force[i], rec.answer[i], links.freedom[i]
    for k in range(3):
        _symmetric_times(a, s[k], u[k])
        rec.drive[i, k] = _times(s[k], f)
    d = ldl3(
        _times(s[0], u[0]), _times(s[1], u[0]), _times(s[1], u[1]), _times(s[2], u[0]), _times(s[2], u[1]),
        _times(s[2], u[2]),
    )  # fmt: skip
    for k in range(6):
        rec.pivot[i, k] = d[k]
    w0, w1, w2 = _ball_solve(d, rec.drive[i])
    for r in RATES:
        f[r] -= u[0, r] * w0 + u[1, r] * w1 + u[2, r] * w2
        z0, z1, z2 = _ball_solve(d, (u[0, r], u[1, r], u[2, r]))
        for c in range(r + 1):
            a[r, c] -= z0 * u[0, c] + z1 * u[1, c] + z2 * u[2, c]


_ball_solve = jit(lambda d, b: ldl3_solve(d[0], d[1], d[2], d[3], d[4], d[5], b[0], b[1], b[2]))


@inlined
def _pass_on(joints, links, rec, i):
    """I_p += X^T I X and f_p += X^T f.

    With I = (M, H^T; H, J) and X (v, w) = (v + w x d, t w): M, H' = d x M + t H, J' = d x H'^T + t (d x H^T + t J).
    """
    a, f, t, d = rec.articulated[i], rec.force[i], links.turns[i], triple(links.apart[i], 0)
    onto, push = rec.articulated[joints.parent[i]], rec.force[joints.parent[i]]
    m = ((a[0, 0], a[1, 0], a[2, 0]), (a[1, 0], a[1, 1], a[2, 1]), (a[2, 0], a[2, 1], a[2, 2]))
    h0 = plus(cross(d, m[0]), times(t, _column_from(a, 0)))  # columns of d x M + t H
    h1 = plus(cross(d, m[1]), times(t, _column_from(a, 1)))
    h2 = plus(cross(d, m[2]), times(t, _column_from(a, 2)))
    k = (cross(d, triple(a[3], 0)), cross(d, triple(a[4], 0)), cross(d, triple(a[5], 0)))  # columns of d x H^T
    for r in range(3):
        g = cross(d, (h0[r], h1[r], h2[r]))
        onto[3 + r, 0] += h0[r]
        onto[3 + r, 1] += h1[r]
        onto[3 + r, 2] += h2[r]
        for c in range(r + 1):
            onto[r, c] += a[r, c]
            onto[3 + r, 3 + c] += g[c] + t * k[c][r] + t * t * a[3 + r, 3 + c]
    add(push, 0, triple(f, 0))
    add(push, 3, plus(cross(d, triple(f, 0)), times(t, triple(f, 3))))


# Return a column of H.
_column_from = jit(lambda a, k: (a[3, k], a[4, k], a[5, k]))


@inlined
def _condense(joints, links, rec, i):
    """Add I' and f' of a body to its parent's (see above); what its joint needs is stored."""
    a, f = rec.articulated[i], rec.force[i]
    own = rec.acceleration[i]  # not in use yet
    _symmetric_times(a, links.bias[i], own)
    for r in RATES:
        f[r] -= own[r]
    if joints.freedoms[i] == 1:
        _free_one(links, rec, i)
    elif joints.freedoms[i] == 3:
        _free_three(links, rec, i)
    if joints.parent[i] < joints.kind.shape[0]:
        _pass_on(joints, links, rec, i)


@inlined
def _release(joints, links, kin, rec, i):
    """Solve for q'' of a body's joint and its acceleration, its parent's being known."""
    own, of_parent, drive, u = rec.acceleration[i], rec.acceleration[joints.parent[i]], rec.drive[i], rec.answer[i]
    count, free = joints.freedoms[i], links.freedom[i]
    if joints.kind[i] == FREE:
        for r in RATES:
            own[r] = rec.force[i, r]
        factor_ldl(rec.articulated[i], 6)
        solve_ldl(rec.articulated[i], 6, own)
        put(drive, 0, own)
        put(drive, 3, turn_back(kin.turned[i], triple(own, 3)))
        return
    alpha = triple(of_parent, 3)
    put(own, 0, plus(triple(of_parent, 0), cross(alpha, links.apart[i])))
    put(own, 3, times(links.turns[i], alpha))
    if count == 1:
        drive[0] = rec.pivot[i, 0] * (drive[0] - _times(u[0], own))
    elif count == 3:
        rest = (drive[0] - _times(u[0], own), drive[1] - _times(u[1], own), drive[2] - _times(u[2], own))
        put(drive, 0, _ball_solve(rec.pivot[i], rest))
    for r in RATES:
        own[r] += links.bias[i, r]
        for k in range(count):
            own[r] += free[k, r] * drive[k]


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
            _condense(joints, links, rec, i)
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
            y[v] = dot(minus(triple(own, 3), spin), triple(links.freedom[i, 0], 3))
        elif kind == PRISMATIC:
            carried = plus(triple(of_parent, 0), cross(spin, links.apart[i]))
            y[v] = dot(minus(triple(own, 0), carried), triple(links.freedom[i, 0], 0))
        elif kind == SPHERICAL:
            put(y, v, turn_back(kin.turned[i], triple(own, 3)))
        elif kind == FREE:
            put(y, v, own)
            if bodies.rigid[i] == 1:
                put(y, v + 3, turn_back(kin.turned[i], triple(own, 3)))
