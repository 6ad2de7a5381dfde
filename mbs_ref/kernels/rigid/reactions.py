"""What each joint's rows do to one of its bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import loop_jit, strict_jit
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME


class JointRows(NamedTuple):
    """Where each joint's rows are, and of which side the force is asked."""

    slot: np.ndarray  # (n_joints,) int
    side: np.ndarray  # (n_joints,) int
    first: np.ndarray  # (n_joints,) int, row in the slot
    count: np.ndarray  # (n_joints,) int


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
def forces_of_tree(model, work, control, joints, multiplier, jacobian, times, states, own, axes, out):
    """Write forces as `forces_at_joints` at each time and state into out (n_t, n_joints, rates), and `own` into axes.

    `multiplier`, `jacobian` and `own` lie in the scratch, which dy/dt fills.
    """
    dy = np.empty(states.shape[1])
    for k in range(times.shape[0]):
        control[CONTROL_MODE_TIME] = times[k]
        derivative(model, work, times[k], states[k], dy)
        forces_at_joints(joints, multiplier, jacobian, out[k])
        axes[k] = own
