"""Loop closures in space (mbs_ref.kernels.rigid.closures).

The rank never exceeds the mechanism's own (`closure_rank`): off the constraints, where an integrator's stages are,
the redundant rows of an overconstrained loop such as Bricard's look independent by the square of the distance.
"""

from __future__ import annotations

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.closures import factor_schur, fill_schur, load_row
from mbs_ref.kernels.spatial.model import RATES, bodies_of, closures_of, kinematics_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.spatial.tree import solve_tree


@jit
def _row_mobility(model, work, slot, row):
    """Return a scale of G M^-1 G^T of one row, the bodies taken as free and as spheres."""
    bodies, slots, rows, kin = bodies_of(model), slots_of(model), rows_of(work), kinematics_of(work)
    n = bodies.mass.shape[0]
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < n:
            g = rows.jacobian[slot, side, row]
            j = kin.inertia[body]
            total += (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]) / bodies.mass[body]
            total += 3.0 * (g[3] * g[3] + g[4] * g[4] + g[5] * g[5]) / (j[0] + j[1] + j[2])
    return total


@jit
def factor_closures(model, work, zero_gamma):
    """Form T G^T column by column, then the Schur complement and its pivoted factor."""
    slots, jacobian, tree, closures = slots_of(model), rows_of(work).jacobian, tree_of(work), closures_of(work)
    for r in range(slots.closure_slot.shape[0]):
        slot, row = slots.closure_slot[r], slots.closure_row[r]
        load_row(RATES, slots.body, jacobian, slot, row, tree.load)
        solve_tree(model, work, zero_gamma, closures.columns[r], closures.column_multiplier[r])
        closures.scale[r] = _row_mobility(model, work, slot, row)
        fill_schur(RATES, slots, jacobian, closures, r)
    factor_schur(closures, slots.closure_rank[0])
