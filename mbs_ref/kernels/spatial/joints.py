"""Joint rows in space: C, C_dot, the Jacobian blocks and gamma = -C_tt - (C_q v)_q v - 2 C_qt v.

r = R + rho, rho = A u (Fox 1999 eq 2), r' = R' + omega x rho. Every joint is made of these rows (Haug,
Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989, sec. 9.4): shared points, products of
directions, points on planes, distances and prescribed turns. Jacobian blocks multiply (R', omega).
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.controls import CONTROL_MODE_TIME
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.signals import evaluate
from mbs_ref.kernels.spatial.model import (
    distances_of,
    drives_of,
    kinematics_of,
    planes_of,
    points_of,
    products_of,
    rows_of,
    signals_of,
    slots_of,
    turns_of,
    world_of,
)
from mbs_ref.kernels.spatial.vectors import cross, dot, turn


@jit
def mark(kin, body, point):
    """Return rho and omega x rho of a point of a body."""
    r0, r1, r2 = turn(kin.turned[body], point)
    c0, c1, c2 = cross(kin.omega[body, 0], kin.omega[body, 1], kin.omega[body, 2], r0, r1, r2)
    return r0, r1, r2, c0, c1, c2


@jit
def _place(block, row, f0, f1, f2, t0, t1, t2):
    block[row, 0] = f0
    block[row, 1] = f1
    block[row, 2] = f2
    block[row, 3] = t0
    block[row, 4] = t1
    block[row, 5] = t2


@jit
def _separation(kin, a, b, point_a, point_b):
    """Return rho_a, rho_b, d = r_b - r_a, its rate, and the centripetal part of its acceleration."""
    a0, a1, a2, ta0, ta1, ta2 = mark(kin, a, point_a)
    b0, b1, b2, tb0, tb1, tb2 = mark(kin, b, point_b)
    wa, wb = kin.omega[a], kin.omega[b]
    ca0, ca1, ca2 = cross(wa[0], wa[1], wa[2], ta0, ta1, ta2)
    cb0, cb1, cb2 = cross(wb[0], wb[1], wb[2], tb0, tb1, tb2)
    return (
        a0, a1, a2, b0, b1, b2,
        kin.position[b, 0] + b0 - kin.position[a, 0] - a0,
        kin.position[b, 1] + b1 - kin.position[a, 1] - a1,
        kin.position[b, 2] + b2 - kin.position[a, 2] - a2,
        kin.velocity[b, 0] + tb0 - kin.velocity[a, 0] - ta0,
        kin.velocity[b, 1] + tb1 - kin.velocity[a, 1] - ta1,
        kin.velocity[b, 2] + tb2 - kin.velocity[a, 2] - ta2,
        cb0 - ca0, cb1 - ca1, cb2 - ca2,
    )  # fmt: skip


@jit
def fill_points(model, work):
    joint, slots, kin, rows = points_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
        a, b = slots.body[slot, side], slots.body[slot, 1 - side]
        a0, a1, a2, b0, b1, b2, d0, d1, d2, u0, u1, u2, g0, g1, g2 = _separation(
            kin, a, b, joint.point_a[k], joint.point_b[k]
        )
        on_a, on_b = rows.jacobian[slot, side], rows.jacobian[slot, 1 - side]
        _place(on_a, row, -1.0, 0.0, 0.0, 0.0, -a2, a1)
        _place(on_a, row + 1, 0.0, -1.0, 0.0, a2, 0.0, -a0)
        _place(on_a, row + 2, 0.0, 0.0, -1.0, -a1, a0, 0.0)
        _place(on_b, row, 1.0, 0.0, 0.0, 0.0, b2, -b1)
        _place(on_b, row + 1, 0.0, 1.0, 0.0, -b2, 0.0, b0)
        _place(on_b, row + 2, 0.0, 0.0, 1.0, b1, -b0, 0.0)
        rows.residual[slot, row] = d0
        rows.residual[slot, row + 1] = d1
        rows.residual[slot, row + 2] = d2
        rows.rate[slot, row] = u0
        rows.rate[slot, row + 1] = u1
        rows.rate[slot, row + 2] = u2
        rows.gamma[slot, row] = -g0
        rows.gamma[slot, row + 1] = -g1
        rows.gamma[slot, row + 2] = -g2


@jit
def _product(kin, a, b, e, f):
    """Return e x f, d(e . f)/dt and -(its second derivative without angular accelerations)."""
    e0, e1, e2 = e
    f0, f1, f2 = f
    wa, wb = kin.omega[a], kin.omega[b]
    n0, n1, n2 = cross(e0, e1, e2, f0, f1, f2)
    p0, p1, p2 = cross(wa[0], wa[1], wa[2], e0, e1, e2)
    s0, s1, s2 = cross(wb[0], wb[1], wb[2], f0, f1, f2)
    pp0, pp1, pp2 = cross(wa[0], wa[1], wa[2], p0, p1, p2)
    ss0, ss1, ss2 = cross(wb[0], wb[1], wb[2], s0, s1, s2)
    rate = dot(p0, p1, p2, f0, f1, f2) + dot(e0, e1, e2, s0, s1, s2)
    second = dot(pp0, pp1, pp2, f0, f1, f2) + 2.0 * dot(p0, p1, p2, s0, s1, s2) + dot(e0, e1, e2, ss0, ss1, ss2)
    return n0, n1, n2, rate, -second


@jit
def fill_products(model, work):
    joint, slots, kin, rows = products_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
        a, b = slots.body[slot, side], slots.body[slot, 1 - side]
        e = turn(kin.turned[a], joint.along_a[k])
        f = turn(kin.turned[b], joint.along_b[k])
        n0, n1, n2, rate, gamma = _product(kin, a, b, e, f)
        _place(rows.jacobian[slot, side], row, 0.0, 0.0, 0.0, n0, n1, n2)
        _place(rows.jacobian[slot, 1 - side], row, 0.0, 0.0, 0.0, -n0, -n1, -n2)
        rows.residual[slot, row] = dot(e[0], e[1], e[2], f[0], f[1], f[2]) - joint.value[k]
        rows.rate[slot, row] = rate
        rows.gamma[slot, row] = gamma


@jit
def fill_planes(model, work):
    """n . d = 0: d(n . d)/dt = (omega_a x n) . d + n . d_dot."""
    joint, slots, kin, rows = planes_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
        a, b = slots.body[slot, side], slots.body[slot, 1 - side]
        a0, a1, a2, b0, b1, b2, d0, d1, d2, u0, u1, u2, g0, g1, g2 = _separation(
            kin, a, b, joint.point_a[k], joint.point_b[k]
        )
        n0, n1, n2, m0, m1, m2 = mark(kin, a, joint.normal[k])
        wa = kin.omega[a]
        c0, c1, c2 = cross(wa[0], wa[1], wa[2], m0, m1, m2)
        t0, t1, t2 = cross(n0, n1, n2, d0 + a0, d1 + a1, d2 + a2)
        s0, s1, s2 = cross(b0, b1, b2, n0, n1, n2)
        _place(rows.jacobian[slot, side], row, -n0, -n1, -n2, t0, t1, t2)
        _place(rows.jacobian[slot, 1 - side], row, n0, n1, n2, s0, s1, s2)
        rows.residual[slot, row] = dot(n0, n1, n2, d0, d1, d2)
        rows.rate[slot, row] = dot(m0, m1, m2, d0, d1, d2) + dot(n0, n1, n2, u0, u1, u2)
        rows.gamma[slot, row] = -(
            dot(c0, c1, c2, d0, d1, d2) + 2.0 * dot(m0, m1, m2, u0, u1, u2) + dot(n0, n1, n2, g0, g1, g2)
        )


@jit
def fill_distances(model, work):
    """|d| = length."""
    joint, slots, kin, rows = distances_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
        a, b = slots.body[slot, side], slots.body[slot, 1 - side]
        a0, a1, a2, b0, b1, b2, d0, d1, d2, u0, u1, u2, g0, g1, g2 = _separation(
            kin, a, b, joint.point_a[k], joint.point_b[k]
        )
        length = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        e0, e1, e2 = d0 / length, d1 / length, d2 / length
        along = dot(e0, e1, e2, u0, u1, u2)
        t0, t1, t2 = cross(a0, a1, a2, e0, e1, e2)
        s0, s1, s2 = cross(b0, b1, b2, e0, e1, e2)
        _place(rows.jacobian[slot, side], row, -e0, -e1, -e2, -t0, -t1, -t2)
        _place(rows.jacobian[slot, 1 - side], row, e0, e1, e2, s0, s1, s2)
        rows.residual[slot, row] = length - joint.length[k]
        rows.rate[slot, row] = along
        across = u0 * u0 + u1 * u1 + u2 * u2 - along * along
        rows.gamma[slot, row] = -dot(e0, e1, e2, g0, g1, g2) - across / length


@jit
def fill_turns(model, work, t):
    """m(phi) . b = 0 with m = cos(phi) quarter - sin(phi) zero: b follows the angle phi about the axis."""
    joint, slots, kin, rows = turns_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    signals = signals_of(model)
    mode_time = world_of(model).control[CONTROL_MODE_TIME]
    for k in range(joint.slot.shape[0]):
        slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
        a, b = slots.body[slot, side], slots.body[slot, 1 - side]
        phi, speed, surge = evaluate(signals, joint.signal[k], t, mode_time)
        c, s = np.cos(phi), np.sin(phi)
        z0, z1, z2 = turn(kin.turned[a], joint.zero[k])
        q0, q1, q2 = turn(kin.turned[a], joint.quarter[k])
        m = (c * q0 - s * z0, c * q1 - s * z1, c * q2 - s * z2)
        along = (c * z0 + s * q0, c * z1 + s * q1, c * z2 + s * q2)  # dm/dphi = -along
        f = turn(kin.turned[b], joint.mark[k])
        n0, n1, n2, rate, gamma = _product(kin, a, b, m, f)
        _, _, _, turning, _ = _product(kin, a, b, along, f)
        kf = dot(along[0], along[1], along[2], f[0], f[1], f[2])
        mf = dot(m[0], m[1], m[2], f[0], f[1], f[2])
        _place(rows.jacobian[slot, side], row, 0.0, 0.0, 0.0, n0, n1, n2)
        _place(rows.jacobian[slot, 1 - side], row, 0.0, 0.0, 0.0, -n0, -n1, -n2)
        rows.residual[slot, row] = mf
        rows.rate[slot, row] = rate - speed * kf
        rows.gamma[slot, row] = gamma + 2.0 * speed * turning + surge * kf + speed * speed * mf


@jit
def fill_drives(model, work, t):
    """Prescribed rows; ground is the other side, whose block stays zero."""
    drive, slots, kin, rows = drives_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    signals = signals_of(model)
    mode_time = world_of(model).control[CONTROL_MODE_TIME]
    for k in range(drive.slot.shape[0]):
        slot, row = drive.slot[k], drive.row[k]
        body = slots.body[slot, drive.side[k]]
        value, rate, curvature = evaluate(signals, drive.signal[k], t, mode_time)
        r0, r1, r2, c0, c1, c2 = mark(kin, body, drive.point[k])
        e0, e1, e2 = drive.direction[k, 0], drive.direction[k, 1], drive.direction[k, 2]
        t0, t1, t2 = cross(r0, r1, r2, e0, e1, e2)
        w, p, v = kin.omega[body], kin.position[body], kin.velocity[body]
        g0, g1, g2 = cross(w[0], w[1], w[2], c0, c1, c2)
        _place(rows.jacobian[slot, drive.side[k]], row, e0, e1, e2, t0, t1, t2)
        rows.residual[slot, row] = dot(e0, e1, e2, p[0] + r0, p[1] + r1, p[2] + r2) - drive.start[k] - value
        rows.rate[slot, row] = dot(e0, e1, e2, v[0] + c0, v[1] + c1, v[2] + c2) - rate
        rows.gamma[slot, row] = curvature - dot(e0, e1, e2, g0, g1, g2)


@jit
def spatial_fill_rows(model, work, t):
    """Evaluate every constraint row at the pose and motion in `work`."""
    fill_points(model, work)
    fill_products(model, work)
    fill_planes(model, work)
    fill_distances(model, work)
    fill_turns(model, work, t)
    fill_drives(model, work, t)
