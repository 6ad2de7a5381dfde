"""Joint rows in the plane: C, C_dot, the Jacobian blocks and gamma = -C_tt - (C_q v)_q v - 2 C_qt v.

Each filler writes its rows of every slot; lambda of a row is the force or torque that the row exerts along its
Jacobian.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.callback import call_user
from mbs_ref.kernels.border.questions import fill_contact_rows
from mbs_ref.kernels.controls import CONTROL_MODE_TIME
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.marks import arm, separation
from mbs_ref.kernels.planar.model import distance_of, prismatic_of, revolute_of, weld_of
from mbs_ref.kernels.planar.vectors import cross, dot, over, plus
from mbs_ref.kernels.rigid.model import drives_of, kinematics_of, rows_of, signals_of, slots_of, world_of
from mbs_ref.kernels.signals import evaluate


@jit
def _place(block, row, force, torque):
    """Write one row of a Jacobian block: what multiplies R' and what multiplies omega."""
    block[row, 0] = force[0]
    block[row, 1] = force[1]
    block[row, 2] = torque


@jit
def _bodies(slots, joint, k):
    """Return the bodies a and b of a joint."""
    slot, side = joint.slot[k], joint.side_a[k]
    return slots.body[slot, side], slots.body[slot, 1 - side]


@jit
def _fill_point(rows, joint, k, apart):
    """Write the two rows r_b - r_a = 0."""
    slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
    on_a, on_b = rows.jacobian[slot, side], rows.jacobian[slot, 1 - side]
    _place(on_a, row, (-1.0, 0.0), apart.arm_a[1])
    _place(on_a, row + 1, (0.0, -1.0), -apart.arm_a[0])
    _place(on_b, row, (1.0, 0.0), -apart.arm_b[1])
    _place(on_b, row + 1, (0.0, 1.0), apart.arm_b[0])
    for c in range(2):
        rows.residual[slot, row + c] = apart.gap[c]
        rows.rate[slot, row + c] = apart.rate[c]
        rows.gamma[slot, row + c] = apart.centripetal[c]


@jit
def _fill_angle(kin, rows, joint, k, row, a, b):
    """Write the row theta_b - theta_a = value."""
    slot, side = joint.slot[k], joint.side_a[k]
    _place(rows.jacobian[slot, side], row, (0.0, 0.0), -1.0)
    _place(rows.jacobian[slot, 1 - side], row, (0.0, 0.0), 1.0)
    rows.residual[slot, row] = kin.motion[b, 3] - kin.motion[a, 3] - joint.value[k]
    rows.rate[slot, row] = kin.motion[b, 2] - kin.motion[a, 2]
    rows.gamma[slot, row] = 0.0


@jit
def _fill_line(rows, joint, k, e, apart, extra):
    """Write the Jacobian of one row: e on r_b, -e on r_a, and `extra` more on theta_a."""
    slot, row, side = joint.slot[k], joint.row[k], joint.side_a[k]
    _place(rows.jacobian[slot, side], row, (-e[0], -e[1]), cross(e, apart.arm_a) + extra)
    _place(rows.jacobian[slot, 1 - side], row, e, e[1] * apart.arm_b[0] - e[0] * apart.arm_b[1])


@jit
def fill_revolute(model, work):
    joint, slots, kin, rows = revolute_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b = _bodies(slots, joint, k)
        _fill_point(rows, joint, k, separation(kin, a, b, joint.point_a[k], joint.point_b[k]))


@jit
def fill_weld(model, work):
    joint, slots, kin, rows = weld_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b = _bodies(slots, joint, k)
        _fill_point(rows, joint, k, separation(kin, a, b, joint.point_a[k], joint.point_b[k]))
        _fill_angle(kin, rows, joint, k, joint.row[k] + 2, a, b)


@jit
def fill_prismatic(model, work):
    """n . d = 0 with n fixed in body a, and no relative turn."""
    joint, slots, kin, rows = prismatic_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b = _bodies(slots, joint, k)
        slot, row = joint.slot[k], joint.row[k]
        apart = separation(kin, a, b, joint.point_a[k], joint.point_b[k])
        n, wa = arm(kin.pose, a, joint.normal[k]), kin.motion[a, 2]
        turning, sweep = cross(n, apart.gap), cross(n, apart.rate)  # d(n)/d(theta_a) . d, and . d_dot
        gap = dot(n, apart.gap)
        _fill_line(rows, joint, k, n, apart, turning)
        rows.residual[slot, row] = gap
        rows.rate[slot, row] = dot(n, apart.rate) + wa * turning
        rows.gamma[slot, row] = dot(n, apart.centripetal) - 2.0 * wa * sweep + wa * wa * gap
        _fill_angle(kin, rows, joint, k, row + 1, a, b)


@jit
def fill_distance(model, work):
    """|d| = length."""
    joint, slots, kin, rows = distance_of(model), slots_of(model), kinematics_of(work), rows_of(work)
    for k in range(joint.slot.shape[0]):
        a, b = _bodies(slots, joint, k)
        slot, row = joint.slot[k], joint.row[k]
        apart = separation(kin, a, b, joint.point_a[k], joint.point_b[k])
        length = np.sqrt(dot(apart.gap, apart.gap))
        e = over(apart.gap, length)
        along = dot(e, apart.rate)
        _fill_line(rows, joint, k, e, apart, 0.0)
        rows.residual[slot, row] = length - joint.value[k]
        rows.rate[slot, row] = along
        across = dot(apart.rate, apart.rate) - along * along
        rows.gamma[slot, row] = dot(e, apart.centripetal) - across / length


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
        rho, e, turn = arm(kin.pose, body, drive.point[k]), drive.direction[k], drive.turn[k]
        lever = e[1] * rho[0] - e[0] * rho[1] + turn
        w = kin.motion[body, 2]
        place = dot(e, plus(kin.pose[body], rho)) + turn * kin.motion[body, 3]
        _place(rows.jacobian[slot, drive.side[k]], row, e, lever)
        rows.residual[slot, row] = place - drive.start[k] - value
        rows.rate[slot, row] = dot(e, kin.motion[body]) + lever * w - rate
        rows.gamma[slot, row] = dot(e, rho) * w * w + curvature


@jit
def planar_fill_rows(model, work, t):
    """Evaluate every constraint row at the pose and motion in `work`."""
    fill_revolute(model, work)
    fill_prismatic(model, work)
    fill_weld(model, work)
    fill_distance(model, work)
    fill_drives(model, work, t)
    if world_of(model).user_rows[0] != 0:
        call_user(world_of(model).user_rows[0], t, 0)  # pyright: ignore[reportCallIssue]
    fill_contact_rows(model, work)
