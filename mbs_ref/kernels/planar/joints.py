"""Joint rows in the plane: C, C_dot, the Jacobian blocks and gamma = -C_tt - (C_q v)_q v - 2 C_qt v.

r = R + A u (Fox 1999 eq 2), rho = A u, perp(rho) = d(rho)/d(theta) = (-rho_y, rho_x). Each filler writes
its rows of every slot; lambda of a row is the force or torque that the row exerts along its Jacobian.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.signals import evaluate


@jit
def _arm(pose, body, point):
    """Return rho = A u."""
    c = pose[body, 2]
    s = pose[body, 3]
    return c * point[0] - s * point[1], s * point[0] + c * point[1]


@jit
def _separation(model, work, joint, k):
    """Return bodies, arms, d = r_b - r_a, its rate and the centripetal part of gamma."""
    slot = joint.slot[k]
    side = joint.side_a[k]
    a = model.slots.body[slot, side]
    b = model.slots.body[slot, 1 - side]
    ax, ay = _arm(work.pose, a, joint.point_a[k])
    bx, by = _arm(work.pose, b, joint.point_b[k])
    wa = work.motion[a, 2]
    wb = work.motion[b, 2]
    dx = work.pose[b, 0] + bx - work.pose[a, 0] - ax
    dy = work.pose[b, 1] + by - work.pose[a, 1] - ay
    ux = work.motion[b, 0] - by * wb - work.motion[a, 0] + ay * wa
    uy = work.motion[b, 1] + bx * wb - work.motion[a, 1] - ax * wa
    gx = bx * wb * wb - ax * wa * wa
    gy = by * wb * wb - ay * wa * wa
    return a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy


@jit
def _fill_point(work, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy):
    """Write the two rows r_b - r_a = 0."""
    slot = joint.slot[k]
    row = joint.row[k]
    side = joint.side_a[k]
    on_a = work.jacobian[slot, side]
    on_b = work.jacobian[slot, 1 - side]
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
    work.residual[slot, row] = dx
    work.residual[slot, row + 1] = dy
    work.rate[slot, row] = ux
    work.rate[slot, row + 1] = uy
    work.gamma[slot, row] = gx
    work.gamma[slot, row + 1] = gy


@jit
def _fill_angle(work, joint, k, row, a, b):
    """Write the row theta_b - theta_a = value."""
    slot = joint.slot[k]
    side = joint.side_a[k]
    work.jacobian[slot, side, row, 0] = 0.0
    work.jacobian[slot, side, row, 1] = 0.0
    work.jacobian[slot, side, row, 2] = -1.0
    work.jacobian[slot, 1 - side, row, 0] = 0.0
    work.jacobian[slot, 1 - side, row, 1] = 0.0
    work.jacobian[slot, 1 - side, row, 2] = 1.0
    work.residual[slot, row] = work.motion[b, 3] - work.motion[a, 3] - joint.value[k]
    work.rate[slot, row] = work.motion[b, 2] - work.motion[a, 2]
    work.gamma[slot, row] = 0.0


@jit
def _fill_line(work, joint, k, ex, ey, ax, ay, bx, by, extra, residual, rate, gamma):
    """Write one row whose Jacobian is e on r_b, -e on r_a, plus `extra` on theta_a."""
    slot = joint.slot[k]
    row = joint.row[k]
    side = joint.side_a[k]
    work.jacobian[slot, side, row, 0] = -ex
    work.jacobian[slot, side, row, 1] = -ey
    work.jacobian[slot, side, row, 2] = ex * ay - ey * ax + extra
    work.jacobian[slot, 1 - side, row, 0] = ex
    work.jacobian[slot, 1 - side, row, 1] = ey
    work.jacobian[slot, 1 - side, row, 2] = ey * bx - ex * by
    work.residual[slot, row] = residual
    work.rate[slot, row] = rate
    work.gamma[slot, row] = gamma


@jit
def fill_revolute(model, work):
    joint = model.revolute
    for k in range(joint.slot.shape[0]):
        _, _, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(model, work, joint, k)
        _fill_point(work, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy)


@jit
def fill_weld(model, work):
    joint = model.weld
    for k in range(joint.slot.shape[0]):
        a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(model, work, joint, k)
        _fill_point(work, joint, k, ax, ay, bx, by, dx, dy, ux, uy, gx, gy)
        _fill_angle(work, joint, k, joint.row[k] + 2, a, b)


@jit
def fill_prismatic(model, work):
    """n . d = 0 with n fixed in body a, and no relative turn."""
    joint = model.prismatic
    for k in range(joint.slot.shape[0]):
        a, b, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(model, work, joint, k)
        nx, ny = _arm(work.pose, a, joint.normal[k])
        wa = work.motion[a, 2]
        extra = nx * dy - ny * dx  # perp(n) . d
        sweep = nx * uy - ny * ux  # perp(n) . d_dot
        gap = nx * dx + ny * dy
        rate = nx * ux + ny * uy + wa * extra
        gamma = nx * gx + ny * gy - 2.0 * wa * sweep + wa * wa * gap
        _fill_line(work, joint, k, nx, ny, ax, ay, bx, by, extra, gap, rate, gamma)
        _fill_angle(work, joint, k, joint.row[k] + 1, a, b)


@jit
def fill_distance(model, work):
    """|d| = length."""
    joint = model.distance
    for k in range(joint.slot.shape[0]):
        _, _, ax, ay, bx, by, dx, dy, ux, uy, gx, gy = _separation(model, work, joint, k)
        length = np.sqrt(dx * dx + dy * dy)
        ex = dx / length
        ey = dy / length
        along = ex * ux + ey * uy
        gamma = ex * gx + ey * gy - (ux * ux + uy * uy - along * along) / length
        _fill_line(work, joint, k, ex, ey, ax, ay, bx, by, 0.0, length - joint.value[k], along, gamma)


@jit
def fill_drives(model, work, t):
    """Prescribed rows; ground is the other side, whose block stays zero."""
    drive = model.drives
    mode_time = model.control[0]
    for k in range(drive.slot.shape[0]):
        slot = drive.slot[k]
        row = drive.row[k]
        body = model.slots.body[slot, drive.side[k]]
        value, rate, curvature = evaluate(model.signals, drive.signal[k], t, mode_time)
        rx, ry = _arm(work.pose, body, drive.point[k])
        ex = drive.direction[k, 0]
        ey = drive.direction[k, 1]
        turn = drive.turn[k]
        lever = ey * rx - ex * ry + turn
        w = work.motion[body, 2]
        place = ex * (work.pose[body, 0] + rx) + ey * (work.pose[body, 1] + ry) + turn * work.motion[body, 3]
        block = work.jacobian[slot, drive.side[k]]
        block[row, 0] = ex
        block[row, 1] = ey
        block[row, 2] = lever
        work.residual[slot, row] = place - drive.start[k] - value
        work.rate[slot, row] = ex * work.motion[body, 0] + ey * work.motion[body, 1] + lever * w - rate
        work.gamma[slot, row] = (ex * rx + ey * ry) * w * w + curvature


@jit
def fill_joints(model, work, t):
    """Evaluate every constraint row at the pose and motion in `work`."""
    fill_revolute(model, work)
    fill_prismatic(model, work)
    fill_weld(model, work)
    fill_distance(model, work)
    fill_drives(model, work, t)
