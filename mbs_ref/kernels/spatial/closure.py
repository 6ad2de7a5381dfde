"""Loop closures: a small Schur complement over the tree solution, rank-revealing.

With T the tree's response operator and G the closure rows, (G T G^T) mu = G a_tree - gamma and
a = a_tree - T G^T mu. Dependent rows get the minimum-norm mu. The rank never exceeds the mechanism's own
(`closure_rank`): off the constraints, where an integrator's stages are, the redundant rows of an
overconstrained loop such as Bricard's look independent by the square of the distance.
"""

from __future__ import annotations

from mbs_ref.kernels.algebra.ldl import minimum_norm_solve, pivoted_cholesky
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.spatial.model import bodies_of, closures_of, kinematics_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.spatial.tree import solve_tree

RANK_TOLERANCE = 1e-13  # of a closure pivot against the row's mobility without joints


@jit
def row_times(model, work, slot, row, acceleration):
    """Return one constraint row applied to accelerations."""
    slots, rows = slots_of(model), rows_of(work)
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        for c in range(6):
            total += rows.jacobian[slot, side, row, c] * acceleration[body, c]
    return total


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
    slots, rows, tree, closures = slots_of(model), rows_of(work), tree_of(work), closures_of(work)
    n = tree.free.shape[0]
    for r in range(slots.closure_slot.shape[0]):
        slot = slots.closure_slot[r]
        row = slots.closure_row[r]
        for i in range(n + 1):
            for c in range(6):
                tree.load[i, c] = 0.0
        for side in range(2):
            body = slots.body[slot, side]
            for c in range(6):
                tree.load[body, c] += rows.jacobian[slot, side, row, c]
        solve_tree(model, work, zero_gamma, closures.columns[r], closures.column_multiplier[r])
        closures.scale[r] = _row_mobility(model, work, slot, row)
        for other in range(r + 1):
            value = row_times(model, work, slots.closure_slot[other], slots.closure_row[other], closures.columns[r])
            closures.schur[r, other] = value
            closures.schur[other, r] = value
    closures.rank[0], closures.regularity[0] = pivoted_cholesky(
        closures.schur, closures.scale, RANK_TOLERANCE, closures.lower, closures.order, slots.closure_rank[0]
    )


@jit
def correct_for_closures(model, work, gamma, acceleration, multiplier):
    """Turn the tree solution into the solution with closed loops."""
    slots, closures = slots_of(model), closures_of(work)
    n = acceleration.shape[0] - 1
    for r in range(slots.closure_slot.shape[0]):
        slot = slots.closure_slot[r]
        row = slots.closure_row[r]
        closures.rhs[r] = row_times(model, work, slot, row, acceleration) - gamma[slot, row]
    minimum_norm_solve(closures.lower, closures.order, closures.rank[0], closures.gram, closures.rhs, closures.mu)
    for r in range(slots.closure_slot.shape[0]):
        mu = closures.mu[r]
        multiplier[slots.closure_slot[r], slots.closure_row[r]] = mu
        for i in range(n):
            for c in range(6):
                acceleration[i, c] -= mu * closures.columns[r, i, c]
                multiplier[i, c] -= mu * closures.column_multiplier[r, i, c]
