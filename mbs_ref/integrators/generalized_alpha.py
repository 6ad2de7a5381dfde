"""Generalized-alpha on the index-3 equations, the field's standard for constrained mechanics; order 2.

Source: M. Arnold, O. Bruls, Convergence of the generalized-alpha scheme for constrained mechanical
systems, Multibody System Dynamics 18 (2007) 185-202, eqs 8-11, with the parameters of J. Chung,
G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375. In space on the group of rotations: O. Bruls, A. Cardona, J. Comput.
Nonlinear Dyn. 5 (2010) 031002.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.events import EVENT, RETRY, event_tables, settle, watch
from mbs_ref.integrators.leg import (
    CLOCK_COMPLIANCE,
    CLOCK_T,
    COUNT_EVENTS,
    COUNT_OUTPUT,
    COUNT_OWN,
    COUNT_RHS,
    COUNT_STEPS,
    DONE,
    NOT_CONVERGED,
    RUNNING,
    STEP_TOO_SMALL,
    Integrator,
    Leg,
    Options,
    Progress,
    run_chunks,
)
from mbs_ref.integrators.step_control import choose_step, close_step, end_step
from mbs_ref.jointed_system import JointedSystem
from mbs_ref.kernels.core import FORM
from mbs_ref.kernels.implicit import dense_correction, factor_tangent, tree_correction
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.questions import derivative, displace, multipliers, position_count
from mbs_ref.system import System

SPECTRAL_RADIUS = 0.9  # at infinite frequency
ALPHA_M = (2 * SPECTRAL_RADIUS - 1) / (SPECTRAL_RADIUS + 1)
ALPHA_F = SPECTRAL_RADIUS / (SPECTRAL_RADIUS + 1)
GAMMA = 0.5 + ALPHA_F - ALPHA_M
BETA = 0.25 * (GAMMA + 0.5) ** 2
TREE_ITERATIONS, DENSE_ITERATIONS = 14, 12
ATTEMPTS = 5  # renewals of the tangent at the latest iterate
SLOW = 0.25  # contraction of the mass-only iteration above which the full tangent pays
ROUNDOFF = 1e-13  # of the state's size: what a Newton correction may leave


@jit
def _iterate(model, work, t, h, y, qdd, a, lam, trial, new_qdd, new_a, dense, row_slot, row_row, lu, pivots, counts):
    """Solve one step for new_qdd and lam; leave the state in `trial`. Return converged, last contraction."""
    n, start = qdd.shape[0], position_count(model)
    move = np.empty(n)
    ratio = (1.0 - ALPHA_F) / (1.0 - ALPHA_M)
    by_position = h * h * BETA * ratio
    size = 1.0
    for k in range(start):
        size = max(size, abs(y[k]))
    before = -1.0
    contraction = 0.0
    for iteration in range(DENSE_ITERATIONS if dense else TREE_ITERATIONS):
        for k in range(n):
            new_a[k] = ((1.0 - ALPHA_F) * new_qdd[k] + ALPHA_F * qdd[k] - ALPHA_M * a[k]) / (1.0 - ALPHA_M)
            move[k] = h * y[start + k] + h * h * ((0.5 - BETA) * a[k] + BETA * new_a[k])
            trial[start + k] = y[start + k] + h * ((1.0 - GAMMA) * a[k] + GAMMA * new_a[k])
        displace(model, y, move, trial)
        if dense:
            change, defect = dense_correction(
                model, work, t, trial, new_qdd, lam, by_position, False, row_slot, row_row, lu, pivots
            )
        else:
            change, defect = tree_correction(model, work, t, trial, new_qdd, lam, by_position, False)
        counts[COUNT_RHS] += 1
        moved = change * by_position
        if not np.isfinite(moved):
            return False, 1.0
        if iteration > 0 and before > 0.0:
            contraction = moved / before
        if moved <= ROUNDOFF * size and defect <= 10 * ROUNDOFF * size:
            return True, contraction
        if iteration > 1 and contraction > 2.0:
            return False, contraction
        before = moved
    return False, contraction


@jit
def _predict(model, h, y, a, trial):
    """Write the state that the accelerations of the step before would lead to."""
    start = position_count(model)
    move = np.empty_like(a)
    for k in range(a.shape[0]):
        move[k] = h * (y[start + k] + 0.5 * h * a[k])
        trial[start + k] = y[start + k] + h * a[k]
    displace(model, y, move, trial)


@jit
def _start(model, work, t, y, qdd, lam):
    """Set accelerations and multipliers that satisfy the equations at the start."""
    dy = np.empty_like(y)
    derivative(model, work, t, y, dy)
    qdd[:] = dy[position_count(model) :]
    multipliers(work, lam)


@jit
def advance_generalized_alpha(
    model, work, options, run, y, qdd, a, lam, row_slot, row_row, lu, pivots, times, states, worst_per_time
):
    """Advance y through times[1:], in place; return a status code (RUNNING when the chunk is used up)."""
    clock, counts = run.clock, run.counts
    n = qdd.shape[0]
    trial = np.empty_like(y)
    new_qdd = np.empty(n)
    new_a = np.empty(n)
    old_lam = lam.copy()
    budget = counts[COUNT_STEPS] + options.chunk
    search, table = event_tables(model)
    watched = table.shape[1] > 0
    if watched:
        before = counts[COUNT_EVENTS]
        code = settle(model, work, clock[CLOCK_T], y, table, run, options.max_events)
        if code != RUNNING:
            return code
        if counts[COUNT_EVENTS] != before:
            _start(model, work, clock[CLOCK_T], y, qdd, lam)
            a[:] = qdd
    ratio = (1.0 - ALPHA_F) / (1.0 - ALPHA_M)
    dense = lu.shape[0] > 0 and counts[COUNT_OWN] == 1
    factored = 0.0
    while counts[COUNT_OUTPUT] < times.shape[0]:
        t = clock[CLOCK_T]
        target = times[counts[COUNT_OUTPUT]]
        reach = target - t
        h, lands, searching = choose_step(options.step, reach, False, search)
        t_new = target if lands else t + h
        if t_new == t and not searching:
            return STEP_TOO_SMALL
        converged = False
        contraction = 1.0
        old_lam[:] = lam
        new_qdd[:] = qdd
        _predict(model, h, y, a, trial)
        for attempt in range(ATTEMPTS):
            if dense and (factored != h or attempt > 0):
                if not factor_tangent(
                    model, work, t_new, trial, lam, h * h * BETA * ratio, h * GAMMA * ratio,
                    row_slot, row_row, lu, pivots,
                ):  # fmt: skip
                    break
                counts[COUNT_RHS] += n
                factored = h
            converged, contraction = _iterate(
                model, work, t_new, h, y, qdd, a, lam, trial, new_qdd, new_a,
                dense, row_slot, row_row, lu, pivots, counts,
            )  # fmt: skip
            if converged:
                break
            if not dense and lu.shape[0] > 0:
                dense = True
                counts[COUNT_OWN] = 1
                factored = 0.0
                new_qdd[:] = qdd
                lam[:] = old_lam
                _predict(model, h, y, a, trial)
        if not converged:
            return NOT_CONVERGED
        if dense and contraction > SLOW:
            factored = 0.0
        code, clock[CLOCK_COMPLIANCE] = close_step(
            model, work, t_new, trial, h, options.project, options.projection_tolerance,
            options.stop_on_compliance, clock[CLOCK_COMPLIANCE],
        )  # fmt: skip
        if code != RUNNING:
            return code
        verdict = 0
        if watched:
            verdict = watch(model, work, t, h, trial, search, table)
            if verdict == RETRY:
                lam[:] = old_lam
                continue
        y[:], qdd[:], a[:] = trial, new_qdd, new_a
        clock[CLOCK_T] = t_new
        counts[COUNT_STEPS] += 1
        if verdict == EVENT:
            code = settle(model, work, t_new, y, table, run, options.max_events)
            if code != RUNNING:
                return code
            _start(model, work, t_new, y, qdd, lam)
            a[:] = qdd
            factored = 0.0
        code = end_step(run, lands, y, times, states, worst_per_time, options.max_steps)
        if code != RUNNING:
            return code
        if counts[COUNT_STEPS] >= budget:
            return RUNNING
    return DONE


DENSE_LIMIT = 900  # unknowns; a dense tangent beyond costs seconds a factorization and is not tried


def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
    """Integrate one leg."""
    assert isinstance(system, JointedSystem)  # `cores` of the INTEGRATOR sees to it
    system.prepare(FORM)
    n = len(y) - system.n_positions
    qdd, lam = np.empty(n), np.zeros_like(system.scratch.rows.multiplier)
    _start(system.model, system.work, float(times[0]), y, qdd, lam)
    run.counts[COUNT_RHS] += 1
    a = qdd.copy()
    rows = np.array([(slot, row) for _, slot, row in system.rows(every=True)], dtype=np.int64).reshape(-1, 2)
    unknowns = n + len(rows) if n + len(rows) <= DENSE_LIMIT else 0
    lu, pivots = np.empty((unknowns, unknowns)), np.empty(unknowns, dtype=np.int64)
    row_slot, row_row = np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1])

    def chunk(states: np.ndarray, worst: np.ndarray) -> int:
        return advance_generalized_alpha(
            system.model, system.work, options, run, y, qdd, a, lam, row_slot, row_row, lu, pivots, times, states, worst
        )

    return run_chunks(chunk, options, run, y, times)


INTEGRATOR = Integrator(
    name="generalized_alpha",
    kind="fixed",
    order=2,
    description="generalized-alpha on the index-3 equations, spectral radius 0.9",
    advance=advance,
    stabilization="none",
    stabilizations=("none", "projection"),
    ladder=(2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
    source="Arnold and Bruls 2007; Chung and Hulbert 1993",
    keeps_constraints=True,
    holds_deflections=False,
    cores=("planar", "spatial"),
)
