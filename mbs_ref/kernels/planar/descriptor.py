"""A planar scene as methods on the DAE itself see it: balances, masses and rows, all in the state's order."""

from __future__ import annotations

from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.dynamics import load_state
from mbs_ref.kernels.planar.model import bodies_of, kinematics_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.rows import take_reactions


@jit
def planar_position_count(model):
    """Return 3 n: positions come first in the state."""
    return 3 * bodies_of(model).mass.shape[0]


@jit
def planar_force_balance(model, work, t, y, lam, out):
    """Write f - C_q^T lambda (3 n,) and leave C, C_dot and C_q in `work`."""
    bodies, slots, rows, kin = bodies_of(model), slots_of(model), rows_of(work), kinematics_of(work)
    load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    n = bodies.mass.shape[0]
    take_reactions(kin.force, slots.body, rows.jacobian, lam)
    kin.force[n] = 0.0
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            out[k + c] = kin.force[i, c]


@jit
def planar_times_mass(model, rate, out):
    """Write M rate (3 n,)."""
    bodies = bodies_of(model)
    for i in range(bodies.mass.shape[0]):
        k = 3 * bodies.scene_index[i]
        out[k] = bodies.mass[i] * rate[k]
        out[k + 1] = bodies.mass[i] * rate[k + 1]
        out[k + 2] = bodies.inertia[i] * rate[k + 2]


@jit
def planar_answer(model, work, balance, out):
    """Solve the augmented system for balance (3 n,) and the gamma in `work`; write the accelerations to out."""
    bodies, tree = bodies_of(model), tree_of(work)
    factor(model, work)
    for i in range(bodies.mass.shape[0]):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            tree.load[i, c] = balance[k + c]
    solve(model, work, rows_of(work).gamma)
    for i in range(bodies.mass.shape[0]):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            out[k + c] = tree.acceleration[i, c]


@jit
def planar_row_times(model, work, slot, row, rate):
    """Return one constraint row applied to rates (3 n,)."""
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < bodies.mass.shape[0]:
            k = 3 * bodies.scene_index[body]
            for c in range(3):
                total += rows.jacobian[slot, side, row, c] * rate[k + c]
    return total


@jit
def planar_add_row(model, work, slot, row, factor, out):
    """Add factor times one constraint row to out (3 n,)."""
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    for side in range(2):
        body = slots.body[slot, side]
        if body < bodies.mass.shape[0]:
            k = 3 * bodies.scene_index[body]
            for c in range(3):
                out[k + c] += factor * rows.jacobian[slot, side, row, c]


@jit
def planar_displace(model, y, move, out):
    """Write y's positions moved by `move` (3 n,) to out."""
    for k in range(move.shape[0]):
        out[k] = y[k] + move[k]


@jit
def planar_position_rate(model, y, rate, out):
    """Write the rates of the positions at rates (3 n,)."""
    for k in range(rate.shape[0]):
        out[k] = rate[k]


@jit
def planar_defect_of(work, velocity_level):
    """Return C or C_dot (n_slots, 3)."""
    rows = rows_of(work)
    return rows.rate if velocity_level else rows.residual


@jit
def planar_gamma_of(work):
    """Return gamma (n_slots, 3)."""
    return rows_of(work).gamma
