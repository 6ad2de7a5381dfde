"""Joint rows in the plane: C, C_dot, the Jacobian blocks and gamma = -C_tt - (C_q v)_q v - 2 C_qt v.

r = R + A u (Fox 1999 eq 2), rho = A u, perp(rho) = d(rho)/d(theta) = (-rho_y, rho_x). Each filler writes
its rows of every slot; lambda of a row is the force or torque that the row exerts along its Jacobian.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.controls import CONTROL_MODE_TIME
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.model import (
    distance_of,
    drives_of,
    kinematics_of,
    prismatic_of,
    revolute_of,
    rows_of,
    signals_of,
    slots_of,
    weld_of,
    world_of,
)
from mbs_ref.kernels.signals import evaluate


@jit
def arm(pose, body, point):
    """Return rho = A u."""
    c = pose[body, 2]
    s = pose[body, 3]
    return c * point[0] - s * point[1], s * point[0] + c * point[1]


@jit
def _separation(slots, kin, joint, k):
    """Return bodies, arms, d = r_b - r_a, its rate and the centripetal part of gamma."""
    slot = joint.slot[k]
    side = joint.side_a[k]
    a = slots.body[slot, side]
    b = slots.body[slot, 1 - side]
    ax, ay = arm(kin.pose, a, joint.point_a[k])
    bx, by = arm(kin.pose, b, joint.point_b[k])
    wa = kin.motion[a, 2]
    wb = kin.motion[b, 2]
    dx = kin.pose[b, 0] + bx - kin.pose[a, 0] - ax
    dy = kin.pose[b, 1] + by - kin.pose[a, 1] - ay
    ux = kin.motion[b, 0] - by * wb - kin.motion[a, 0] + ay * wa
    uy = kin.motion[b, 1] + bx * wb - kin.motion[a, 1] - ax * wa
    gx = bx * wb * wb - ax * wa * wa
    gy = by * wb * wb - ay * wa * wa
    return a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy


@jit
def _fill_point(rows, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy):
    """Write the two rows r_b - r_a = 0."""
    slot = joint.slot[k]
    row = joint.row[k]
    side = joint.side_a[k]
    on_a = rows.jacobian[slot, side]
    on_b = rows.jacobian[slot, 1 - side]
    on_a[row, 0] = -1.0
    on_a[row, 1] = 0.0
    on_a[row, 2] = ay
    on_a[row + 1, 0] = 0.0
    on_a[row + 1, 1] = -1.0
    on_a[row + 1, 2] = -ax
    on_b[row, 0] = 1.0
    on_b[row, 1] = 0.0
    on_b[row, 2] = -by
    on_b[row + 1, 0] = 0.0
    on_b[row + 1, 1] = 1.0
    on_b[row + 1, 2] = bx
    rows.residual[slot, row] = dx
    rows.residual[slot, row + 1] = dy
    rows.rate[slot, row] = ux
    rows.rate[slot, row + 1] = uy
    rows.gamma[slot, row] = gx
    rows.gamma[slot, row + 1] = gy


@jit
def _fill_angle(kin, rows, joint, k, row, a, b):
    """Write the row theta_b - theta_a = value."""
    slot = joint.slot[k]
    side = joint.side_a[k]
    rows.jacobian[slot, side, row, 0] = 0.0
    rows.jacobian[slot, side, row, 1] = 0.0
    rows.jacobian[slot, side, row, 2] = -1.0
    rows.jacobian[slot, 1 - side, row, 0] = 0.0
    rows.jacobian[slot, 1 - side, row, 1] = 0.0
    rows.jacobian[slot, 1 - side, row, 2] = 1.0
    rows.residual[slot, row] = kin.motion[b, 3] - kin.motion[a, 3] - joint.value[k]
    rows.rate[slot, row] = kin.motion[b, 2] - kin.motion[a, 2]
    rows.gamma[slot, row] = 0.0


@jit
def _fill_line(rows, joint, k, ex, ey, ax, ay, bx, by, extra, residual, rate, gamma):
    """Write one row whose Jacobian is e on r_b, -e on r_a, plus `extra` on theta_a."""
    slot = joint.slot[k]
    row = joint.row[k]
    side = joint.side_a[k]
    rows.jacobian[slot, side, row, 0] = -ex
    rows.jacobian[slot, side, row, 1] = -ey
    rows.jacobian[slot, side, row, 2] = ex * ay - ey * ax + extra
    rows.jacobian[slot, 1 - side, row, 0] = ex
    rows.jacobian[slot, 1 - side, row, 1] = ey
    rows.jacobian[slot, 1 - side, row, 2] = ey * bx - ex * by
    rows.residual[slot, row] = residual
    rows.rate[slot, row] = rate
    rows.gamma[slot, row] = gamma


@jit
def fill_revolute(model, work):
    joint, slots, kin, rows = revolute_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        _, _, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(slots, kin, joint, k)
        _fill_point(rows, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy)


@jit
def fill_weld(model, work):
    joint, slots, kin, rows = weld_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(slots, kin, joint, k)
        _fill_point(rows, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy)
        _fill_angle(kin, rows, joint, k, joint.row[k] + 2, a, b)


@jit
def fill_prismatic(model, work):
    """n . d = 0 with n fixed in body a, and no relative turn."""
    joint, slots, kin, rows = prismatic_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(slots, kin, joint, k)
        nx, ny = arm(kin.pose, a, joint.normal[k])
        wa = kin.motion[a, 2]
        extra = nx * dy - ny * dx  # perp(n) . d
        sweep = nx * uy - ny * ux  # perp(n) . d_dot
        gap = nx * dx + ny * dy
        rate = nx * ux + ny * uy + wa * extra
        gamma = nx * gx + ny * gy - 2.0 * wa * sweep + wa * wa * gap
        _fill_line(rows, joint, k, nx, ny, ax, ay, bx, by, extra, gap, rate, gamma)
        _fill_angle(kin, rows, joint, k, joint.row[k] + 1, a, b)


@jit
def fill_distance(model, work):
    """|d| = length."""
    joint, slots, kin, rows = distance_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        _, _, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(slots, kin, joint, k)
        length = np.sqrt(dx * dx + dy * dy)
        ex = dx / length
        ey = dy / length
        along = ex * ux + ey * uy
        gamma = ex * gx + ey * gy - (ux * ux + uy * uy - along * along) / length
        _fill_line(rows, joint, k, ex, ey, ax, ay, bx, by, 0.0, length - joint.value[k], along, gamma)


@jit
def fill_drives(model, work, t):
    """Prescribed rows; ground is the other side, whose block stays zero."""
    drive, slots, kin, rows = drives_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    signals = signals_of(model)
    mode_time = world_of(model).control[CONTROL_MODE_TIME]
    for k in range(drive.slot.shape[0]):
        slot = drive.slot[k]
        row = drive.row[k]
        body = slots.body[slot, drive.side[k]]
        value, rate, curvature = evaluate(signals, drive.signal[k], t, mode_time)
        rx, ry = arm(kin.pose, body, drive.point[k])
        ex = drive.direction[k, 0]
        ey = drive.direction[k, 1]
        turn = drive.turn[k]
        lever = ey * rx - ex * ry + turn
        w = kin.motion[body, 2]
        place = ex * (kin.pose[body, 0] + rx) + ey * (kin.pose[body, 1] + ry) + turn * kin.motion[body, 3]
        block = rows.jacobian[slot, drive.side[k]]
        block[row, 0] = ex
        block[row, 1] = ey
        block[row, 2] = lever
        rows.residual[slot, row] = place - drive.start[k] - value
        rows.rate[slot, row] = ex * kin.motion[body, 0] + ey * kin.motion[body, 1] + lever * w - rate
        rows.gamma[slot, row] = (ex * rx + ey * ry) * w * w + curvature


@jit
def fill_joints(model, work, t):
    """Evaluate every constraint row at the pose and motion in `work`."""
    fill_revolute(model, work)
    fill_prismatic(model, work)
    fill_weld(model, work)
    fill_distance(model, work)
    fill_drives(model, work, t)
