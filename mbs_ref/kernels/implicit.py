"""What methods on the DAE itself need: Newton corrections in (v', lambda), for any core.

One correction solves [M + g C_t + b K_t, C_q^T; C_q, 0][d_v'; d_lambda] = [f - M v' - C_q^T lambda; -C/b]
with b = dq/dv' and g = dv/dv' of the method. The cheap correction keeps M alone and runs along the
joint tree in O(N); the full one forms K_t and C_t by differences, and is dense.
"""

import numpy as np

from mbs_ref.kernels.algebra.dense import lu_factor, lu_solve
from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rows import largest_entry

PROXIMAL = 1e-12  # weight on the multipliers' diagonal: dependent rows then share, instead of failing
DIFFERENCE = 1e-7  # m or rad, and m/s or rad/s: for the tangent's columns


@jit
def tree_correction(model, work, t, y, qdd, lam, weight):
    """Correct qdd and lam (n_slots, rows a slot) with the mass matrix alone; return |d_qdd| and max defect."""
    balance, inert, found = np.empty_like(qdd), np.empty_like(qdd), np.empty_like(lam)
    ask.force_balance(model, work, t, y, lam, balance)
    ask.times_mass(model, qdd, inert)
    for k in range(qdd.shape[0]):
        balance[k] -= inert[k]
    defect = ask.defect_of(work, False)
    size = largest_entry(defect)
    gamma = ask.gamma_of(work)
    for slot in range(lam.shape[0]):
        for row in range(lam.shape[1]):
            gamma[slot, row] = -defect[slot, row] / weight
    ask.answer(model, work, balance, inert)
    ask.multipliers(work, found)
    for k in range(qdd.shape[0]):
        qdd[k] += inert[k]
    for slot in range(lam.shape[0]):
        for row in range(lam.shape[1]):
            lam[slot, row] += found[slot, row]
    return largest_entry(inert.reshape(1, -1)), size


@jit
def factor_tangent(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots):
    """Form and factor the full Newton matrix (n + m, n + m); row_slot, row_row (m,) name the rows in use.

    Return False where it is singular.
    """
    start = ask.position_count(model)
    n = y.shape[0] - start
    base, shifted, move = np.empty(n), np.empty(n), np.zeros(n)
    state = y.copy()
    ask.force_balance(model, work, t, y, lam, base)
    lu[:] = 0.0
    for r in range(row_slot.shape[0]):
        ask.add_row(model, work, row_slot[r], row_row[r], 1.0, lu[n + r, :n])
        for k in range(n):
            lu[k, n + r] = lu[n + r, k]
        lu[n + r, n + r] = -PROXIMAL
    for j in range(n):
        move[j] = 1.0
        ask.times_mass(model, move, lu[j, :n])  # a column of the symmetric M, stored as a row until the end
        move[j] = DIFFERENCE
        ask.displace(model, y, move, state)
        ask.force_balance(model, work, t, state, lam, shifted)
        for i in range(n):
            lu[j, i] -= by_position * (shifted[i] - base[i]) / DIFFERENCE
        move[j] = 0.0
        ask.displace(model, y, move, state)
        state[start + j] += DIFFERENCE
        ask.force_balance(model, work, t, state, lam, shifted)
        for i in range(n):
            lu[j, i] -= by_velocity * (shifted[i] - base[i]) / DIFFERENCE
        state[start + j] = y[start + j]
    for i in range(n):
        for j in range(i):
            lu[i, j], lu[j, i] = lu[j, i], lu[i, j]
    return lu_factor(lu, pivots)


@jit
def dense_correction(model, work, t, y, qdd, lam, weight, row_slot, row_row, lu, pivots):
    """Correct qdd and lam with the factored full Newton matrix; return |d_qdd| and max defect."""
    n = qdd.shape[0]
    rhs, inert = np.empty(n + row_slot.shape[0]), np.empty(n)
    ask.force_balance(model, work, t, y, lam, rhs[:n])
    ask.times_mass(model, qdd, inert)
    for k in range(n):
        rhs[k] -= inert[k]
    defect = ask.defect_of(work, False)
    size = largest_entry(defect)
    for r in range(row_slot.shape[0]):
        rhs[n + r] = -defect[row_slot[r], row_row[r]] / weight
    lu_solve(lu, pivots, rhs)
    for k in range(n):
        qdd[k] += rhs[k]
    for r in range(row_slot.shape[0]):
        lam[row_slot[r], row_row[r]] += rhs[n + r]
    return largest_entry(rhs[:n].reshape(1, -1)), size
