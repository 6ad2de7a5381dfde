"""Loop closures: a small Schur complement over the tree solution, rank-revealing.

With T the tree's response operator and G the closure rows, (G T G^T) mu = G a_tree - gamma and
a = a_tree - T G^T mu. Dependent rows get the minimum-norm mu. `block` is a tuple as long as a body has rates, 3 or
6: so a loop over them has bounds that the compiler knows.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.ldl import minimum_norm_solve, pivoted_cholesky
from mbs_ref.kernels.border.groups import Floats, Ints, empty
from mbs_ref.kernels.jit import jit

RANK_TOLERANCE = 1e-13  # of a closure pivot against the row's mobility without joints


class Closures(NamedTuple):
    """Scratch; `rates` is 3 in the plane and 6 in space."""

    columns: Annotated[Floats, "n_rows", "n + 1", "rates"]  # response to a unit multiplier of each closure row
    column_multiplier: Annotated[Floats, "n_rows", "n", "rates"]  # tree multipliers of that response
    schur: Annotated[Floats, "n_rows", "n_rows"]
    scale: Annotated[Floats, "n_rows"]  # mobility of each row without joints
    lower: Annotated[Floats, "n_rows", "n_rows"]
    gram: Annotated[Floats, "n_rows", "n_rows"]
    order: Annotated[Ints, "n_rows"]
    rhs: Annotated[Floats, "n_rows"]
    mu: Annotated[Floats, "n_rows"]
    rank: Annotated[Ints, 1]  # rank of the closure rows at the last factorization
    regularity: Annotated[Floats, 1]  # smallest accepted closure pivot, relative; 1 far from any singular pose


def closure_scratch(n: int, n_rows: int, rates: int) -> Closures:
    """Allocate the scratch of n bodies and n_rows closure rows."""
    lengths = {"n": n, "n + 1": n + 1, "n_rows": n_rows, "rates": rates}
    return empty(Closures, **lengths)._replace(regularity=np.ones(1))


@jit
def row_times(block, body, jacobian, slot, row, acceleration):
    """Return one constraint row applied to accelerations."""
    total = 0.0
    for side in range(2):
        of = body[slot, side]
        for c in range(len(block)):
            total += jacobian[slot, side, row, c] * acceleration[of, c]
    return total


@jit
def load_row(block, body, jacobian, slot, row, load):
    """Set the load to one row's: the response to it is a column of T G^T."""
    for i in range(load.shape[0]):
        for c in range(len(block)):
            load[i, c] = 0.0
    for side in range(2):
        on = body[slot, side]
        for c in range(len(block)):
            load[on, c] += jacobian[slot, side, row, c]


@jit
def leave_out(closures, r):
    """Make row r the equation mu = 0."""
    closures.columns[r] = 0.0
    closures.column_multiplier[r] = 0.0
    for other in range(r):
        closures.schur[r, other] = 0.0
        closures.schur[other, r] = 0.0
    closures.schur[r, r] = 1.0
    closures.scale[r] = 1.0


@jit
def fill_schur(block, slots, jacobian, closures, r):
    """Fill row r of the Schur complement, and the same column, up to the diagonal."""
    for other in range(r + 1):
        slot, row = slots.closure_slot[other], slots.closure_row[other]
        value = row_times(block, slots.body, jacobian, slot, row, closures.columns[r])
        closures.schur[r, other] = value
        closures.schur[other, r] = value


@jit
def factor_schur(closures, most):
    """Factor the Schur complement, of rank `most` at most."""
    closures.rank[0], closures.regularity[0] = pivoted_cholesky(
        closures.schur, closures.scale, RANK_TOLERANCE, closures.lower, closures.order, most
    )


@jit
def correct_for_closures(block, slots, jacobian, closures, gamma, acceleration, multiplier):
    """Turn the tree solution into the solution with closed loops."""
    n = acceleration.shape[0] - 1
    for r in range(slots.closure_slot.shape[0]):
        slot, row = slots.closure_slot[r], slots.closure_row[r]
        closures.rhs[r] = row_times(block, slots.body, jacobian, slot, row, acceleration) - gamma[slot, row]
    minimum_norm_solve(closures.lower, closures.order, closures.rank[0], closures.gram, closures.rhs, closures.mu)
    for r in range(slots.closure_slot.shape[0]):
        mu = closures.mu[r]
        multiplier[slots.closure_slot[r], slots.closure_row[r]] = mu
        for i in range(n):
            for c in range(len(block)):
                acceleration[i, c] -= mu * closures.columns[r, i, c]
                multiplier[i, c] -= mu * closures.column_multiplier[r, i, c]
