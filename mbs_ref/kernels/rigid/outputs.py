"""Forces at the outputs of a run, in the contact modes that held at each: of joints and of contacts."""

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH, in_every_lane, in_lanes
from mbs_ref.kernels.border.questions import contact_forces, derivative, regularity
from mbs_ref.kernels.contact.laws import ContactModes
from mbs_ref.kernels.jit import bare_loop, jit, loop_jit, strict_jit
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME
from mbs_ref.kernels.rows import copy_rows


class JointRows(NamedTuple):
    """Where each joint's rows are, and on which side the force is reported."""

    slot: np.ndarray  # (n_joints,) int
    side: np.ndarray  # (n_joints,) int
    first: np.ndarray  # (n_joints,) int, row in the slot
    count: np.ndarray  # (n_joints,) int


class Record(NamedTuple):
    """The modes at the start of a run, and its log, from which the modes at each time follow."""

    modes: ContactModes
    mode: np.ndarray  # (k,) int, at the start, as are the next three
    grip: np.ndarray  # (k,) int
    anchor: np.ndarray  # (k, tangents)
    dashpot: np.ndarray  # (k,)
    stale: np.ndarray  # (1,) int, of the list of near pairs
    recalled: np.ndarray  # (1,) int, events of the log that the modes reflect; -1 before the first recall
    control: np.ndarray  # (3,) of the scene's World


@jit
def _recall_start(record):
    modes = record.modes
    for k in range(modes.mode.shape[0]):
        modes.mode[k], modes.grip[k], modes.dashpot[k] = record.mode[k], record.grip[k], record.dashpot[k]
    copy_rows(record.anchor, modes.anchor)
    record.recalled[0] = 0


@jit
def recall(record, t):
    """Set the signals' segments, and every contact's mode to the one that held at t (s); fast in the order of time."""
    record.control[CONTROL_MODE_TIME] = t
    modes, log, done = record.modes, record.modes.log, record.recalled
    if modes.roots[0] == 0:
        return
    if done[0] < 0 or (done[0] > 0 and log[done[0] - 1, 0] > t):
        _recall_start(record)
    while done[0] < min(modes.logged[0], log.shape[0]) and log[done[0], 0] <= t:
        row, tangents = log[done[0]], modes.anchor.shape[1]
        k = int(row[1])
        modes.mode[k], modes.grip[k], modes.dashpot[k] = int(row[2]), int(row[3]), row[4 + tangents]
        for c in range(tangents):
            modes.anchor[k, c] = row[4 + c]
        done[0] += 1
    record.stale[0] = 1


@strict_jit
def forces_at_joints(joints, multiplier, jacobian, out):
    """Write C_q^T lambda of each joint's rows on the chosen side's body (n_joints, rates)."""
    for j in range(out.shape[0]):
        slot, side, first = joints.slot[j], joints.side[j], joints.first[j]
        for c in range(out.shape[1]):
            total = 0.0
            for row in range(first, first + joints.count[j]):
                total += multiplier[slot, row] * jacobian[slot, side, row, c]
            out[j, c] = total


@loop_jit
def forces_over(model, work, record, joints, rows, rank, times, states, out, pivots, ranks):
    """Write forces as `forces_at_joints` at each time and state into out (n_t, n_joints, rates).

    pivots and ranks (n_t,) receive the smallest relative pivot of the closures and the number of all. `rows` and `rank`
    lie in the scratch, which dy/dt fills.
    """
    dy = np.empty(states.shape[1])
    for k in range(times.shape[0]):
        recall(record, times[k])
        derivative(model, work, times[k], states[k], dy)
        forces_at_joints(joints, rows.multiplier, rows.jacobian, out[k])
        pivots[k], ranks[k] = regularity(work), 0
        for count in rank:
            ranks[k] += count


@bare_loop
def forces_in_lanes(model, work, joints, multiplier, jacobian, y, dy, states, out):
    """Write forces as `forces_over` into out, WIDTH states at a time, where these alone determine them.

    multiplier and jacobian are the rows of lanes, y and dy (n_state, WIDTH) room for states and their rates.
    """
    count, now, rate = states.shape[0], in_lanes(y), in_lanes(dy)
    for k in range(0, count, WIDTH):
        for w in range(WIDTH):
            for c in range(states.shape[1]):
                y[c, w] = states[min(k + w, count - 1), c]
        derivative(model, work, in_every_lane(0.0), now, rate)
        for w in range(min(WIDTH, count - k)):
            for j in range(out.shape[1]):
                slot, side, first = joints.slot[j], joints.side[j], joints.first[j]
                for c in range(out.shape[2]):
                    total = 0.0
                    for row in range(first, first + joints.count[j]):
                        total += multiplier[slot, row, w] * jacobian[slot, side, row, c, w]
                    out[k + w, j, c] = total


@loop_jit
def contact_forces_over(model, work, record, times, states, out):
    """Write the forces of contacts at each time and state into out (n_t, n_contacts, 1 + 2 dimension)."""
    for k in range(times.shape[0]):
        recall(record, times[k])
        contact_forces(model, work, times[k], states[k], out[k])
