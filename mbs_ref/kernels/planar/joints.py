"""Joint rows in the plane: Jacobian blocks, which multiply (R', omega), and the rows on angles."""

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.marks import cross, dot
from mbs_ref.kernels.rigid.joints import bodies_of_row, put_row
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME
from mbs_ref.kernels.signals import evaluate

moment = bare(lambda arm, force: (cross(arm, force),))


@bare
def put_point(work, slot, side, row, apart):
    on_a, on_b = work.rows.jacobian[slot, side], work.rows.jacobian[slot, 1 - side]
    put_row(on_a[row], (-1.0, 0.0), (apart.arm_a[1],))
    put_row(on_a[row + 1], (0.0, -1.0), (-apart.arm_a[0],))
    put_row(on_b[row], (1.0, 0.0), (-apart.arm_b[1],))
    put_row(on_b[row + 1], (0.0, 1.0), (apart.arm_b[0],))


rate_of_turning = bare(lambda work, i, n, gap: work.kinematics.motion[i, 2] * cross(n, gap))


@bare
def surplus_of_turning(work, i, n, apart, surplus):
    omega = work.kinematics.motion[i, 2]
    return surplus - 2.0 * omega * cross(n, apart.rate) + omega * omega * dot(n, apart.gap)


@bare
def fill_own_rows(model, work, t):
    _fill_angles(model, work)
    _fill_angle_drives(model, work, t)


@bare
def _fill_angles(model, work):
    joint, slots, kin, rows = model.angles, model.slots, work.kinematics, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        put_row(rows.jacobian[slot, side, row], (0.0, 0.0), (-1.0,))
        put_row(rows.jacobian[slot, 1 - side, row], (0.0, 0.0), (1.0,))
        rows.residual[slot, row] = kin.motion[b, 3] - kin.motion[a, 3] - joint.value[k]
        rows.rate[slot, row] = kin.motion[b, 2] - kin.motion[a, 2]
        rows.gamma[slot, row] = 0.0


@bare
def _fill_angle_drives(model, work, t):
    drive, slots, kin, rows = model.angle_drives, model.slots, work.kinematics, work.rows
    mode_time = model.world.control[CONTROL_MODE_TIME]
    for k in range(drive.slot.shape[0]):
        slot, row, side = drive.slot[k], drive.row[k], drive.side[k]
        i = slots.body[slot, side]
        value, rate, curvature = evaluate(model.signals, drive.signal[k], t, mode_time)
        put_row(rows.jacobian[slot, side, row], (0.0, 0.0), (1.0,))
        rows.residual[slot, row] = kin.motion[i, 3] - drive.start[k] - value
        rows.rate[slot, row] = kin.motion[i, 2] - rate
        rows.gamma[slot, row] = curvature
