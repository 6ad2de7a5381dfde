"""Loop closures in the plane (mbs_ref.kernels.rigid.closures)."""

from __future__ import annotations

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.model import RATES, bodies_of, closures_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.planar.tree import solve_tree
from mbs_ref.kernels.rigid.closures import factor_schur, fill_schur, leave_out, load_row


@jit
def _row_mobility(model, work, slot, row):
    """Return G M^-1 G^T of one row, the bodies taken as free."""
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    n = bodies.mass.shape[0]
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < n:
            g = rows.jacobian[slot, side, row]
            total += (g[0] * g[0] + g[1] * g[1]) / bodies.mass[body] + g[2] * g[2] / bodies.inertia[body]
    return total


@jit
def factor_closures(model, work, zero_gamma):
    """Form T G^T column by column, then the Schur complement and its pivoted factor."""
    slots, jacobian, tree, closures = slots_of(model), rows_of(work).jacobian, tree_of(work), closures_of(work)
    for r in range(slots.closure_slot.shape[0]):
        slot, row = slots.closure_slot[r], slots.closure_row[r]
        closures.scale[r] = _row_mobility(model, work, slot, row)
        if closures.scale[r] == 0.0:  # the empty row of an open contact: its multiplier is zero
            leave_out(closures, r)
            continue
        load_row(RATES, slots.body, jacobian, slot, row, tree.load)
        solve_tree(model, work, zero_gamma, closures.columns[r], closures.column_multiplier[r])
        fill_schur(RATES, slots, jacobian, closures, r)
    factor_schur(closures, closures.scale.shape[0])
