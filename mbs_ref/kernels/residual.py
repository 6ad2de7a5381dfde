"""The DAE's residual in three index forms, for solvers that take F(t, x, x') = 0, of any core.

INDEX_3: x = [q, v, lambda]      C = 0
INDEX_1: x = [q, v, lambda]      C_q v' = gamma
GGL:     x = [q, v, lambda, mu]  C = 0 and C_dot = 0, q' = N (v - C_q^T mu) (Gear, Gupta, Leimkuhler 1985)
with M v' = f - C_q^T lambda in each, and q' = N v: in space theta' = theta (0, omega) / 2, which keeps the norm.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import (
    defect_of,
    force_balance,
    gamma_of,
    position_count,
    position_rate,
    rows_times,
    subtract_rows,
    times_mass,
)
from mbs_ref.kernels.jit import jit

INDEX_1, GGL, INDEX_3 = 1, 2, 3


@jit
def residual(model, work, t, x, xp, form, proximal, heaviest, row_slot, row_row, lam, balance, out):
    """Write F(t, x, x') of the chosen form; lam (n_slots, rows a slot) and balance (n_rates,) are scratch.

    `proximal` (s) times a multiplier over the mass `heaviest` (kg) is left in its own row: it keeps dependent rows
    solvable. A multiplier is as large as the heaviest body's forces, and undivided would open its joint.
    """
    start, n, m = position_count(model), balance.shape[0], row_slot.shape[0]
    end = start + n  # of the state
    lam[:] = 0.0
    for r in range(m):
        lam[row_slot[r], row_row[r]] = x[end + r]
    y = x[:end]
    force_balance(model, work, t, y, lam, balance)
    times_mass(model, xp[start:end], out[start:end])
    for k in range(n):
        out[start + k] -= balance[k]
    _fill_rows(model, work, x, xp[start:end], form, proximal, heaviest, row_slot, row_row, out[end:], x[end:])
    for k in range(n):
        balance[k] = y[start + k]
    if form == GGL:
        subtract_rows(model, work, row_slot, row_row, x[end + m :], balance)
    position_rate(model, y, balance, out)
    for k in range(start):
        out[k] = xp[k] - out[k]


@jit
def _fill_rows(model, work, x, rate, form, proximal, heaviest, row_slot, row_row, out, multiplier):
    """Write the constraint rows; multiplier is lambda and, in the GGL form, mu after it."""
    m = row_slot.shape[0]
    if form == INDEX_1:
        gamma = gamma_of(work)
        rows_times(model, work, row_slot, row_row, rate, out)
        for r in range(m):
            soft = proximal / heaviest * multiplier[r]
            out[r] = out[r] - gamma[row_slot[r], row_row[r]] - soft
        return
    position, velocity = defect_of(work, False), defect_of(work, True)
    for r in range(m):
        slot, row = row_slot[r], row_row[r]
        if form == GGL:
            out[r] = velocity[slot, row] - proximal / heaviest * multiplier[r]
            out[m + r] = position[slot, row] - proximal * multiplier[m + r]
        else:
            out[r] = position[slot, row]


@jit
def largest_balance(model, work, t, y, lam, balance):
    """Return the largest applied force or torque at (t, y)."""
    force_balance(model, work, t, y, lam, balance)
    return np.abs(balance).max()
