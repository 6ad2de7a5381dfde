"""The DAE's residual in four index forms, for solvers that take F(t, x, x') = 0, of any core.

INDEX_3: x = [q, v, lambda]      C = 0
INDEX_2: x = [q, v, lambda]      C_dot = 0
INDEX_1: x = [q, v, lambda]      C_q v' = gamma
GGL:     x = [q, v, lambda, mu]  C = 0 and C_dot = 0, q' = N (v - C_q^T mu) (Gear, Gupta, Leimkuhler 1985)
with M v' = f - C_q^T lambda in each, and q' = N v: in space theta' = theta (0, omega) / 2, which keeps the norm.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numba import carray, types  # pyright: ignore[reportPrivateImportUsage]

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.border.calls import call_for_numbers
from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import Model, Work, handle_class
from mbs_ref.kernels.jit import address_for_c, jit

INDEX_1, GGL, INDEX_3, INDEX_2 = 1, 2, 3, 4


class Dae(NamedTuple):
    """A system as a DAE: its form, its rows, scratch, and what a solver in C hands over.

    `softness` times the multipliers is left in their own rows: it keeps dependent rows solvable. That of lambda is mu's
    over the heaviest mass: a multiplier is as large as the heaviest body's forces, and undivided would open its joint.
    """

    system: Annotated[Ints, 2]  # addresses of the handles of model and work
    form: Annotated[Ints, 1]
    softness: Annotated[Floats, 2]  # of lambda (s/kg) and of mu (s)
    slot: Annotated[Ints, "n_rows"]
    row: Annotated[Ints, "n_rows"]  # in its slot
    lam: Annotated[Floats, "n_slots", "rows"]  # scratch
    balance: Annotated[Floats, "n_rates"]  # scratch
    numbers_of: Annotated[Ints, 1]  # address of what returns the numbers of a solver's vector: double *(void *)
    evaluations: Annotated[Ints, 1]  # called by a solver in C


class DaeGroups(NamedTuple):
    dae: Dae


Problem = handle_class(__name__, "Problem", DaeGroups)


@jit
def residual(dae, t, x, xp, out):
    """Write F(t, x, x') of the chosen form."""
    model, work = Model(dae.system[0]), Work(dae.system[1])
    start, n, m = ask.position_count(model), dae.balance.shape[0], dae.slot.shape[0]
    balance, end = dae.balance, start + n  # of the state
    dae.lam[:] = 0.0
    for r in range(m):
        dae.lam[dae.slot[r], dae.row[r]] = x[end + r]
    y = x[:end]
    ask.force_balance(model, work, t, y, dae.lam, balance)
    ask.times_mass(model, xp[start:end], out[start:end])
    for k in range(n):
        out[start + k] -= balance[k]
    _fill_rows(model, work, dae, xp[start:end], out[end:], x[end:])
    for k in range(n):
        balance[k] = y[start + k]
    if dae.form[0] == GGL:
        for r in range(m):
            ask.add_row(model, work, dae.slot[r], dae.row[r], -x[end + m + r], balance)
    ask.position_rate(model, y, balance, out)
    for k in range(start):
        out[k] = xp[k] - out[k]


@jit
def _fill_rows(model, work, dae, rate, out, multiplier):
    """Write the constraint rows; multiplier is lambda and, in the GGL form, mu after it."""
    m, form = dae.slot.shape[0], dae.form[0]
    if form == INDEX_1:
        gamma = ask.gamma_of(work)
        for r in range(m):
            soft = dae.softness[0] * multiplier[r]
            applied = ask.row_times(model, work, dae.slot[r], dae.row[r], rate)
            out[r] = applied - gamma[dae.slot[r], dae.row[r]] - soft
        return
    position, velocity = ask.defect_of(work, False), ask.defect_of(work, True)
    for r in range(m):
        slot, row = dae.slot[r], dae.row[r]
        if form == INDEX_3:
            out[r] = position[slot, row]
            continue
        out[r] = velocity[slot, row] - dae.softness[0] * multiplier[r]
        if form == GGL:
            out[m + r] = position[slot, row] - dae.softness[1] * multiplier[m + r]


@jit
def largest_balance(model, work, t, y, lam, balance):
    """Return the largest applied force or torque at (t, y)."""
    ask.force_balance(model, work, t, y, lam, balance)
    return np.abs(balance).max()


# --- as C calls them: int (double t, vector x, vector x', vector F, void *data) -----------------------


@jit
def _numbers(dae, vector, size):
    """Return the numbers of a solver's vector."""
    return carray(call_for_numbers(dae.numbers_of[0], vector), size)


def _residual_for_c(t, x, xp, out, data):
    """Write F; return 1 where it is not finite."""
    dae = Problem(data).dae
    count = 2 if dae.form[0] == GGL else 1
    size = ask.position_count(Model(dae.system[0])) + dae.balance.shape[0] + count * dae.slot.shape[0]
    result = _numbers(dae, out, size)
    residual(dae, t, _numbers(dae, x, size), _numbers(dae, xp, size), result)
    dae.evaluations[0] += 1
    for k in range(size):
        if not np.isfinite(result[k]):
            return 1
    return 0


def residual_for_c() -> int:
    """Return the address of the residual."""
    return address_for_c(_residual_for_c, types.intc(types.double, *(4 * [types.intp])))
