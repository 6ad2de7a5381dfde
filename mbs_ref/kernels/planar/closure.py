"""Loop closures: a small Schur complement over the tree solution, rank-revealing.

With T the tree's response operator and G the closure rows, (G T G^T) mu = G a_tree - gamma and
a = a_tree - T G^T mu. Dependent rows get the minimum-norm mu.
"""

from __future__ import annotations

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.ldl import minimum_norm_solve, pivoted_cholesky
from mbs_ref.kernels.planar.tree import solve_tree

RANK_TOLERANCE = 1e-13  # of a closure pivot against the row's mobility without joints


@jit
def row_times(model, work, slot, row, acceleration):
    """Return one constraint row applied to accelerations."""
    total = 0.0
    for side in range(2):
        body = model.slots.body[slot, side]
        for c in range(3):
            total += work.jacobian[slot, side, row, c] * acceleration[body, c]
    return total


@jit
def _row_mobility(model, work, slot, row):
    """Return G M^-1 G^T of one row, the bodies taken as free."""
    n = model.bodies.mass.shape[0]
    total = 0.0
    for side in range(2):
        body = model.slots.body[slot, side]
        if body < n:
            g = work.jacobian[slot, side, row]
            total += (g[0] * g[0] + g[1] * g[1]) / model.bodies.mass[body] + g[2] * g[2] / model.bodies.inertia[body]
    return total


@jit
def factor_closures(model, work, zero_gamma):
    """Form T G^T column by column, then the Schur complement and its pivoted factor."""
    slots = model.slots
    n = model.bodies.mass.shape[0]
    rows = slots.closure_slot.shape[0]
    for r in range(rows):
        slot = slots.closure_slot[r]
        row = slots.closure_row[r]
        for i in range(n + 1):
            for c in range(3):
                work.load[i, c] = 0.0
        for side in range(2):
            body = slots.body[slot, side]
            for c in range(3):
                work.load[body, c] += work.jacobian[slot, side, row, c]
        solve_tree(model, work, zero_gamma, work.columns[r], work.column_multiplier[r])
        work.schur_scale[r] = _row_mobility(model, work, slot, row)
        for other in range(r + 1):
            value = row_times(model, work, slots.closure_slot[other], slots.closure_row[other], work.columns[r])
            work.schur[r, other] = value
            work.schur[other, r] = value
    work.rank[0], work.regularity[0] = pivoted_cholesky(
        work.schur, work.schur_scale, RANK_TOLERANCE, work.schur_lower, work.schur_order
    )


@jit
def correct_for_closures(model, work, gamma, acceleration, multiplier):
    """Turn the tree solution into the solution with closed loops."""
    slots = model.slots
    n = model.bodies.mass.shape[0]
    rows = slots.closure_slot.shape[0]
    for r in range(rows):
        slot = slots.closure_slot[r]
        row = slots.closure_row[r]
        work.closure_rhs[r] = row_times(model, work, slot, row, acceleration) - gamma[slot, row]
    minimum_norm_solve(
        work.schur_lower, work.schur_order, work.rank[0], work.schur_gram, work.closure_rhs, work.closure_mu
    )
    for r in range(rows):
        mu = work.closure_mu[r]
        multiplier[slots.closure_slot[r], slots.closure_row[r]] = mu
        for i in range(n):
            for c in range(3):
                acceleration[i, c] -= mu * work.columns[r, i, c]
                multiplier[i, c] -= mu * work.column_multiplier[r, i, c]
