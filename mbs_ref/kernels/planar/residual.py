"""The DAE's residual in three index forms, for solvers that take F(t, x, x') = 0.

INDEX_3: x = [q, v, lambda]      C = 0
INDEX_1: x = [q, v, lambda]      C_q v' = gamma
GGL:     x = [q, v, lambda, mu]  C = 0 and C_dot = 0, q' = v - C_q^T mu (Gear, Gupta, Leimkuhler 1985)
with M v' = f - C_q^T lambda in each.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.implicit import planar_force_balance
from mbs_ref.kernels.planar.model import bodies_of, rows_of, slots_of

INDEX_1, GGL, INDEX_3 = 1, 2, 3

@jit
def planar_residual(model, work, t, x, xp, form, proximal, heaviest, row_slot, row_row, lam, balance, out):
    """Write F(t, x, x') of the chosen form; lam (n_slots, 3) and balance (3 n,) are scratch.

    `proximal` (s) times a multiplier over the mass `heaviest` (kg) is left in its own row: it keeps dependent rows
    solvable. A multiplier is as large as the heaviest body's forces, and undivided would open its joint.
    """
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    n = bodies.mass.shape[0]
    half = 3 * n
    m = row_slot.shape[0]
    lam[:] = 0.0
    for r in range(m):
        lam[row_slot[r], row_row[r]] = x[2 * half + r]
    planar_force_balance(model, work, t, x[: 2 * half], lam, balance)
    for k in range(half):
        out[k] = xp[k] - x[half + k]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            mass = bodies.inertia[i] if c == 2 else bodies.mass[i]
            out[half + k + c] = mass * xp[half + k + c] - balance[k + c]
    for r in range(m):
        slot, row = row_slot[r], row_row[r]
        if form == GGL:
            mu = x[2 * half + m + r]
            out[2 * half + r] = rows.rate[slot, row] - proximal / heaviest * x[2 * half + r]
            out[2 * half + m + r] = rows.residual[slot, row] - proximal * mu
        elif form == INDEX_3:
            out[2 * half + r] = rows.residual[slot, row]
        else:
            out[2 * half + r] = -rows.gamma[slot, row] - proximal / heaviest * x[2 * half + r]
        for side in range(2):
            body = slots.body[slot, side]
            if body < n:
                k = 3 * bodies.scene_index[body]
                for c in range(3):
                    g = rows.jacobian[slot, side, row, c]
                    if form == GGL:
                        out[k + c] += g * mu
                    elif form == INDEX_1:
                        out[2 * half + r] += g * xp[half + k + c]


def residual_scratch(n_bodies: int, n_slots: int) -> tuple[np.ndarray, np.ndarray]:
    """Return lam and balance for `planar_residual`."""
    return np.zeros((n_slots, 3)), np.zeros(3 * n_bodies)
