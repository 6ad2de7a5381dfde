"""Joint rows: C, C_dot, the Jacobian blocks and gamma = -C_tt - (C_q v)_q v - 2 C_qt v.

Every joint consists of elementary rows (Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989,
sec. 9.4). lambda of a row is the force or torque that the row exerts along its Jacobian.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH, lane_of, put_lane
from mbs_ref.kernels.border.calls import call_user
from mbs_ref.kernels.border.handles import alone
from mbs_ref.kernels.border.questions import fill_contact_rows, fill_further_rows, fill_rows
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.marks import inward, separation
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME
from mbs_ref.kernels.signals import evaluate


@bare
def bodies_of_row(slots, joint, k):
    """Return slot, row, the side of body a, and the bodies a and b."""
    slot, side = joint.slot[k], joint.side_a[k]
    return slot, joint.row[k], side, slots.body[slot, side], slots.body[slot, 1 - side]


@bare
def put_row(row, force, torque):
    """Write one row of a Jacobian block: what multiplies R' and what multiplies omega, both tuples."""
    for c in range(len(force)):
        row[c] = force[c]
    for c in range(len(torque)):
        row[len(force) + c] = torque[c]


@bare
def _put_along(work, slot, side, row, e, arm):
    """Write the row that gives the velocity along e of a point at an arm of its body."""
    put_row(work.rows.jacobian[slot, side, row], e, core.moment(work, arm, e))


@bare
def _put_line(work, slot, side, row, e, arm_a, arm_b):
    """Write the row that gives the velocity along e of a point of b from one of a, which is on this side."""
    _put_along(work, slot, side, row, core.times(work, -1.0, e), arm_a)
    _put_along(work, slot, 1 - side, row, e, arm_b)


@bare
def _fill_points(model, work):
    joint, slots, rows = model.points, model.slots, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        apart = separation(work, a, b, joint.point_a[k], joint.point_b[k])
        core.put_point(work, slot, side, row, apart)
        surplus = inward(work, a, b, apart)
        for c in range(len(surplus)):
            rows.residual[slot, row + c] = apart.gap[c]
            rows.rate[slot, row + c] = apart.rate[c]
            rows.gamma[slot, row + c] = surplus[c]


@bare
def _fill_planes(model, work):
    joint, slots, rows = model.planes, model.slots, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        apart = separation(work, a, b, joint.point_a[k], joint.point_b[k])
        n = core.turned(work, a, joint.normal[k])
        _put_line(work, slot, side, row, n, core.plus(work, apart.gap, apart.arm_a), apart.arm_b)
        rows.residual[slot, row] = core.dot(work, n, apart.gap)
        rows.rate[slot, row] = core.dot(work, n, apart.rate) + core.rate_of_turning(work, a, n, apart.gap)
        surplus = core.dot(work, n, inward(work, a, b, apart))
        rows.gamma[slot, row] = core.surplus_of_turning(work, a, n, apart, surplus)


@bare
def _fill_distances(model, work):
    joint, slots, rows = model.distances, model.slots, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        apart = separation(work, a, b, joint.point_a[k], joint.point_b[k])
        length = np.sqrt(core.dot(work, apart.gap, apart.gap))
        e = core.over(work, apart.gap, length)
        along = core.dot(work, e, apart.rate)
        _put_line(work, slot, side, row, e, apart.arm_a, apart.arm_b)
        rows.residual[slot, row] = length - joint.length[k]
        rows.rate[slot, row] = along
        across = core.dot(work, apart.rate, apart.rate) - along * along
        rows.gamma[slot, row] = core.dot(work, e, inward(work, a, b, apart)) - across / length


@bare
def _fill_drives(model, work, t):
    """Prescribed rows; ground is the other side, whose block stays zero."""
    drive, slots, rows, signals = model.drives, model.slots, work.rows, model.signals
    mode_time = model.world.control[CONTROL_MODE_TIME]
    for k in range(drive.slot.shape[0]):
        slot, row, side, e = drive.slot[k], drive.row[k], drive.side[k], drive.direction[k]
        i = slots.body[slot, side]
        value, rate, curvature = evaluate(signals, drive.signal[k], t, mode_time)
        arm = core.turned(work, i, drive.point[k])
        swing = core.swing(work, i, arm)
        _put_along(work, slot, side, row, core.times(work, 1.0, e), arm)
        place = core.plus(work, core.centre(work, i), arm)
        rows.residual[slot, row] = core.dot(work, e, place) - drive.start[k] - value
        rows.rate[slot, row] = core.dot(work, e, core.plus(work, core.speed(work, i), swing)) - rate
        rows.gamma[slot, row] = curvature - core.dot(work, e, core.swing(work, i, swing))


@jit
def lanes_fill_rows(model, work, t):
    """Evaluate the rows that depend neither on the time nor on modes."""
    _fill_points(model, work)
    _fill_distances(model, work)
    _fill_planes(model, work)
    core.fill_own_rows(model, work)


@jit
def lanes_fill_rows_alone(model, work, t):
    """Let the system of each lane evaluate its rows, which depend on the time or on modes of its own."""
    beside, rows = work.beside, work.rows
    for w in range(WIDTH):
        if beside.model[w] != 0:
            its = alone(work, beside.work[w])
            core.take_kinematics(work, w, its)
            fill_rows(alone(model, beside.model[w]), its, lane_of(t, w))
            put_lane(its.rows.residual, w, rows.residual)
            put_lane(its.rows.rate, w, rows.rate)
            put_lane(its.rows.gamma, w, rows.gamma)
            for slot in range(rows.jacobian.shape[0]):
                for side in range(2):
                    put_lane(its.rows.jacobian[slot, side], w, rows.jacobian[slot, side])


@jit
def rigid_fill_rows(model, work, t):
    _fill_points(model, work)
    _fill_distances(model, work)
    fill_further_rows(model, work, t)
    fill_contact_rows(model, work)


@jit
def rigid_fill_further_rows(model, work, t):
    _fill_planes(model, work)
    core.fill_own_rows(model, work)
    _fill_drives(model, work, t)
    core.fill_own_drives(model, work, t)
    if model.world.user_rows[0] != 0:
        call_user(model.world.user_rows[0], t, 0)
