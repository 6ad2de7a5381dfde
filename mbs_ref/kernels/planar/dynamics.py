"""The state of a planar scene, y = [q, v] in scene order with q_i = [Rx, Ry, theta], its rates, and its joints' rows.

`rigid.dynamics` and `rigid.descriptor` say what is done with them.
"""

import sys

import numpy as np

from mbs_ref.kernels.algebra.lanes import cos_sin, take_lane
from mbs_ref.kernels.border.handles import handle_class, handle_in_lanes
from mbs_ref.kernels.border.questions import accelerate
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.planar import contacts, marks, tree
from mbs_ref.kernels.planar.marks import cross, dot
from mbs_ref.kernels.planar.model import RATES, PlanarGroups, PlanarScratch
from mbs_ref.kernels.rigid import geometry
from mbs_ref.kernels.rigid.dynamics import is_solved, respond
from mbs_ref.kernels.rigid.elimination import rows_times
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
def fill_own_rows(model, work):
    joint, slots, kin, rows = model.angles, model.slots, work.kinematics, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        put_row(rows.jacobian[slot, side, row], (0.0, 0.0), (-1.0,))
        put_row(rows.jacobian[slot, 1 - side, row], (0.0, 0.0), (1.0,))
        rows.residual[slot, row] = kin.motion[b, 3] - kin.motion[a, 3] - joint.value[k]
        rows.rate[slot, row] = kin.motion[b, 2] - kin.motion[a, 2]
        rows.gamma[slot, row] = 0.0


@bare
def fill_own_drives(model, work, t):
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


@jit
def load_state(model, work, y):
    """Copy the state into elimination order and turn angles into cosines and sines."""
    bodies, kin = model.bodies, work.kinematics
    work.solved.time[0] = np.nan
    n = bodies.mass.shape[0]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        angle = y[k + 2]
        kin.pose[i, 0] = y[k]
        kin.pose[i, 1] = y[k + 1]
        kin.pose[i, 2], kin.pose[i, 3] = cos_sin(angle)
        kin.motion[i, 0] = y[3 * n + k]
        kin.motion[i, 1] = y[3 * n + k + 1]
        kin.motion[i, 2] = y[3 * n + k + 2]
        kin.motion[i, 3] = angle


@bare
def take_kinematics(work, w, its):
    its.solved.time[0] = np.nan
    take_lane(work.kinematics.pose, w, its.kinematics.pose)
    take_lane(work.kinematics.motion, w, its.kinematics.motion)


block = jit(lambda model: RATES)
normalize = jit(lambda model, y: None)
largest_norm_defect = jit(lambda model, work: 0.0)


@jit
def subtract_inertia(model, work, acceleration, load):
    """load -= M a."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        load[i, 0] -= bodies.mass[i] * acceleration[i, 0]
        load[i, 1] -= bodies.mass[i] * acceleration[i, 1]
        load[i, 2] -= bodies.inertia[i, 0] * acceleration[i, 2]


@jit
def planar_derivative(model, work, t, y, dy):
    """Write dy/dt = [v, a]."""
    if not is_solved(work, t, y):
        accelerate(model, work, t, y)
    bodies, acceleration = model.bodies, work.tree.acceleration
    n = bodies.mass.shape[0]
    for k in range(3 * n):
        dy[k] = y[3 * n + k]
    for i in range(n):
        k = 3 * (n + bodies.scene_index[i])
        dy[k] = acceleration[i, 0]
        dy[k + 1] = acceleration[i, 1]
        dy[k + 2] = acceleration[i, 2]


@jit
def add_rates(model, work, i, factor, rates, out, k):
    for c in range(3):
        out[k + c] += factor * rates[c]


world_rates = jit(lambda model, work, i, values, k: (values[k], values[k + 1], values[k + 2]))


@jit
def plus_product(model, work, total, i, row, values, k):
    for c in range(3):
        total += row[c] * values[k + c]
    return total


@jit
def _add_correction(model, work, y, offset):
    bodies, tree = model.bodies, work.tree
    for i in range(bodies.mass.shape[0]):
        add_rates(model, work, i, 1.0, tree.acceleration[i], y, offset + bodies.q[i])


correct_places = jit(lambda model, work, y: _add_correction(model, work, y, 0))


@jit
def planar_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints."""
    bodies, slots, rows, tree = model.bodies, model.slots, work.rows, work.tree
    n = bodies.mass.shape[0]
    for offset in (0, 3 * n):
        for i in range(n):
            k = offset + 3 * bodies.scene_index[i]
            for c in range(3):
                tree.acceleration[i, c] = x[k + c]
        rows_times(RATES, slots.body, rows.jacobian, tree.acceleration, rows.rate)
        respond(model, work, rows.rate)
        _add_correction(model, work, x, offset)


@jit
def planar_times_mass(model, rate, out):
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        k = 3 * bodies.scene_index[i]
        out[k] = bodies.mass[i] * rate[k]
        out[k + 1] = bodies.mass[i] * rate[k + 1]
        out[k + 2] = bodies.inertia[i, 0] * rate[k + 2]


@jit
def planar_displace(model, y, move, out):
    for k in range(move.shape[0]):
        out[k] = y[k] + move[k]


@jit
def planar_position_rate(model, y, rate, out):
    for k in range(rate.shape[0]):
        out[k] = rate[k]


planar_rate_from = planar_position_rate

PlanarModel = handle_class(__name__, "PlanarModel", PlanarGroups, dimension=2, tangents=1, axes=0, turns=1, moments=1)
PlanarWork = handle_class(__name__, "PlanarWork", PlanarScratch, rates=3)
PlanarModelInLanes, PlanarWorkInLanes = handle_in_lanes(PlanarModel), handle_in_lanes(PlanarWork)


_MODULES = (sys.modules[__name__], contacts, marks, tree)
supply((PlanarModel, PlanarWork, PlanarModelInLanes, PlanarWorkInLanes), geometry, _MODULES)
