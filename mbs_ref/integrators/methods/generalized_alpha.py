"""Generalized-alpha on the index-3 equations, the field's standard for constrained mechanics; order 2.

Source: M. Arnold, O. Bruls, Convergence of the generalized-alpha scheme for constrained mechanical
systems, Multibody System Dynamics 18 (2007) 185-202, eqs 8-11, with the parameters of J. Chung,
G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375. In space on the group of rotations: O. Bruls, A. Cardona, J. Comput.
Nonlinear Dyn. 5 (2010) 031002.

Positions alone satisfy their constraints within a run. After an event both levels do: the state is projected, and the
method starts anew.
"""

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.events import EVENT, RETRY, event_tables, has_events, settle_at
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.integrators.loop.step import PROJECTION_ITERATIONS, accept, close_attempt, next_attempt, stands_still
from mbs_ref.kernels.answers import FORM
from mbs_ref.kernels.border.questions import derivative, displace, multipliers, position_count, project
from mbs_ref.kernels.implicit import dense_correction, factor_tangent, tree_correction
from mbs_ref.kernels.jit import inlined, jit, loop_jit

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

SPECTRAL_RADIUS = 0.9  # at infinite frequency
ALPHA_M = (2 * SPECTRAL_RADIUS - 1) / (SPECTRAL_RADIUS + 1)
ALPHA_F = SPECTRAL_RADIUS / (SPECTRAL_RADIUS + 1)
GAMMA = 0.5 + ALPHA_F - ALPHA_M
BETA = 0.25 * (GAMMA + 0.5) ** 2
RATIO = (1.0 - ALPHA_F) / (1.0 - ALPHA_M)  # of a new acceleration, what the algorithmic one takes over
TREE_ITERATIONS, DENSE_ITERATIONS = 14, 12
ATTEMPTS = 5  # renewals of the tangent at the latest iterate
SLOW = 0.25  # contraction of the mass-only iteration above which the full tangent pays
SHORT = 1e-3  # of the usual step: rounding of positions is 1 / h in the rates, and a shorter step is explicit
ROUNDOFF = 1e-13  # of the state's size: what a Newton correction may leave


class Motion(NamedTuple):
    """What the method carries from step to step besides the state, in the source's letters."""

    qdd: np.ndarray  # (n,) accelerations
    a: np.ndarray  # (n,) the algorithmic accelerations
    lam: np.ndarray  # (n_slots, rows a slot) multipliers


class Iterate(NamedTuple):
    """The end of a step while it is solved for; lam is corrected in place, and stored here for a repeated step."""

    y: np.ndarray  # the state
    qdd: np.ndarray  # (n,)
    a: np.ndarray  # (n,)
    old_lam: np.ndarray  # (n_slots, rows a slot) at the start of the step


class Tangent(NamedTuple):
    """The full Newton matrix, tried where the mass alone does not converge."""

    row_slot: np.ndarray  # (m,) int: the constraint rows in use
    row_row: np.ndarray  # (m,) int
    lu: np.ndarray  # (n + m, n + m) factors; empty where the matrix is too large to be tried
    pivots: np.ndarray  # (n + m,) int
    step: np.ndarray  # (1,) s, step that the factors belong to; 0 where they are out of date


@inlined
def _is_dense(run, tangent):
    """Return whether steps are solved with the full tangent; once chosen it stays."""
    return tangent.lu.shape[0] > 0 and run.needs_tangent == 1


@inlined
def _size(model, y):
    """Return the largest position, at least 1: what roundoff is measured by."""
    size = 1.0
    for k in range(position_count(model)):
        size = max(size, abs(y[k]))
    return size


@inlined
def _place(model, h, y, motion, iterate, move):
    """Write the state that the accelerations of the iterate lead to (Arnold and Bruls 2007, eqs 8-11)."""
    start = position_count(model)
    qdd, a = motion.qdd, motion.a
    for k in range(qdd.shape[0]):
        iterate.a[k] = ((1.0 - ALPHA_F) * iterate.qdd[k] + ALPHA_F * qdd[k] - ALPHA_M * a[k]) / (1.0 - ALPHA_M)
        move[k] = h * y[start + k] + h * h * ((0.5 - BETA) * a[k] + BETA * iterate.a[k])
        iterate.y[start + k] = y[start + k] + h * ((1.0 - GAMMA) * a[k] + GAMMA * iterate.a[k])
    displace(model, y, move, iterate.y)


@inlined
def _correction(model, work, run, t, by_position, motion, iterate, tangent, dense):
    """Correct the iterate's accelerations and the multipliers; return |change| and the largest defect."""
    run.rhs_calls += 1
    if dense:
        return dense_correction(
            model, work, t, iterate.y, iterate.qdd, motion.lam, by_position,
            tangent.row_slot, tangent.row_row, tangent.lu, tangent.pivots,
        )  # fmt: skip
    return tree_correction(model, work, t, iterate.y, iterate.qdd, motion.lam, by_position)


@inlined
def _iterate(model, work, run, t, h, y, motion, iterate, tangent):
    """Correct one step's accelerations and multipliers until nothing is left; return converged, last contraction."""
    move, dense = np.empty_like(motion.qdd), _is_dense(run, tangent)
    by_position, size = h * h * BETA * RATIO, _size(model, y)
    before, contraction = -1.0, 0.0
    for iteration in range(DENSE_ITERATIONS if dense else TREE_ITERATIONS):
        _place(model, h, y, motion, iterate, move)
        change, defect = _correction(model, work, run, t, by_position, motion, iterate, tangent, dense)
        moved = change * by_position
        if not np.isfinite(moved):
            return False, 1.0
        if iteration > 0 and before > 0.0:
            contraction = moved / before
        if moved <= ROUNDOFF * size and defect <= 10 * ROUNDOFF * size:
            _place(model, h, y, motion, iterate, move)  # what is left of 1e-13 here is 1e-13 / h in the velocities
            return True, contraction
        if iteration > 1 and contraction > 2.0:
            return False, contraction
        before = moved
    return False, contraction


@inlined
def _predict(model, h, y, motion, iterate):
    """Begin with the accelerations of the step before, and the state that they would lead to."""
    start, a = position_count(model), motion.a
    move = np.empty_like(a)
    for k in range(a.shape[0]):
        iterate.qdd[k] = motion.qdd[k]
        move[k] = h * (y[start + k] + 0.5 * h * a[k])
        iterate.y[start + k] = y[start + k] + h * a[k]
    displace(model, y, move, iterate.y)


@inlined
def _renew_tangent(model, work, run, attempt, motion, iterate, tangent):
    """Form and factor the full tangent at the iterate; return whether it is regular."""
    h = attempt.h
    regular = factor_tangent(
        model, work, attempt.t_new, iterate.y, motion.lam, h * h * BETA * RATIO, h * GAMMA * RATIO,
        tangent.row_slot, tangent.row_row, tangent.lu, tangent.pivots,
    )  # fmt: skip
    if regular:
        run.rhs_calls += 2 * motion.qdd.shape[0]
        tangent.step[0] = h
    return regular


@inlined
def _solve(model, work, run, attempt, y, motion, iterate, tangent):
    """Solve one step's equations, with the full tangent where the mass alone does not do; return whether it went."""
    iterate.old_lam[:] = motion.lam
    _predict(model, attempt.h, y, motion, iterate)
    for renewal in range(ATTEMPTS):
        dense = _is_dense(run, tangent)
        outdated = dense and (tangent.step[0] != attempt.h or renewal > 0)
        if outdated and not _renew_tangent(model, work, run, attempt, motion, iterate, tangent):
            return False
        converged, contraction = _iterate(model, work, run, attempt.t_new, attempt.h, y, motion, iterate, tangent)
        if converged:
            if dense and contraction > SLOW:
                tangent.step[0] = 0.0
            return True
        if not dense and tangent.lu.shape[0] > 0:
            run.needs_tangent = 1
            tangent.step[0] = 0.0
            motion.lam[:] = iterate.old_lam
            _predict(model, attempt.h, y, motion, iterate)
    return False


@jit
def _start(model, work, t, y, motion):
    """Set accelerations and multipliers that satisfy the equations at (t, y)."""
    dy = np.empty_like(y)
    derivative(model, work, t, y, dy)
    motion.qdd[:] = dy[position_count(model) :]
    motion.a[:] = motion.qdd
    multipliers(work, motion.lam)


@inlined
def _is_short(options, run, attempt, outputs):
    """Return whether an event, or what it leaves of an output interval, cuts the step to SHORT of the usual one."""
    last, following = outputs.times[run.next_output - 1], outputs.times[run.next_output]
    return attempt.h < SHORT * min(options.step, following - last)


@inlined
def _take_short(model, work, options, run, attempt, y, motion, iterate):
    """End a short step where the accelerations at its start lead."""
    _start(model, work, attempt.t, y, motion)
    run.rhs_calls += 1
    iterate.old_lam[:], iterate.qdd[:] = motion.lam, motion.qdd
    _predict(model, attempt.h, y, motion, iterate)
    project(model, work, attempt.t_new, iterate.y, options.projection_tolerance, PROJECTION_ITERATIONS)


@inlined
def _begin(model, work, options, run, y, motion, table):
    """Settle the modes; where that moved anything, start anew. Return a status code."""
    t, before = run.t, run.events
    if not has_events(table):
        return leg.RUNNING
    code = settle_at(options.settle, model, work, t, y, table, run, options.max_events)
    if code == leg.RUNNING and run.events != before:
        _start(model, work, t, y, motion)
    return code


@loop_jit
def advance_generalized_alpha(model, work, options, run, y, motion, tangent, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up)."""
    n = motion.qdd.shape[0]
    iterate = Iterate(np.empty_like(y), np.empty(n), np.empty(n), motion.lam.copy())
    span = outputs.times[-1] - outputs.times[0]
    search, table = event_tables(model)
    ends = step_ends(y, np.empty_like(y), iterate.y, np.empty_like(y))
    budget = run.steps + options.chunk
    code = _begin(model, work, options, run, y, motion, table)
    tangent.step[0] = 0.0
    while code == leg.RUNNING and run.steps < budget:
        attempt = next_attempt(options.step, run, outputs.times[run.next_output], False, search)
        if stands_still(attempt):
            return leg.STEP_TOO_SMALL
        short = _is_short(options, run, attempt, outputs)
        if short:
            _take_short(model, work, options, run, attempt, y, motion, iterate)
        elif not _solve(model, work, run, attempt, y, motion, iterate, tangent):
            return leg.NOT_CONVERGED
        ends.known[:] = 0
        code, verdict = close_attempt(model, work, options, run, attempt, span, ends, search, table)
        if verdict == RETRY:
            motion.lam[:] = iterate.old_lam
            continue
        if code == leg.RUNNING:
            motion.qdd[:], motion.a[:] = iterate.qdd, iterate.a
            code = accept(model, work, options, run, attempt, verdict, y, iterate.y, table, outputs)
        if code == leg.RUNNING and (short or verdict == EVENT):
            project(model, work, attempt.t_new, y, options.projection_tolerance, PROJECTION_ITERATIONS)
            _start(model, work, attempt.t_new, y, motion)
            tangent.step[0] = 0.0
    return code


DENSE_LIMIT = 900  # unknowns; a dense tangent beyond costs seconds a factorization and is not tried


def advance(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
    """Integrate one leg."""
    assert isinstance(system, JointedSystem)  # `cores` of the METHOD sees to it
    system.prepare(FORM)
    n = len(y) - system.n_positions
    motion = Motion(np.empty(n), np.empty(n), np.zeros_like(system.scratch.rows.multiplier))
    _start(system.model, system.work, float(times[0]), y, motion)
    run.rhs_calls += 1
    own = options, run, y, motion, _tangent(system, n)
    chunk = partial(advance_generalized_alpha, system.model, system.work, *own)
    return leg.run_chunks(chunk, options, run, y, times)


def _tangent(system: JointedSystem, n: int) -> Tangent:
    """Return room for the full Newton matrix of n rates and the multipliers, unless it is too large."""
    rows = np.array([(slot, row) for _, slot, row in system.rows(every=True)], dtype=np.int64).reshape(-1, 2)
    unknowns = n + len(rows) if n + len(rows) <= DENSE_LIMIT else 0
    row_slot, row_row = np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1])
    lu, pivots = np.empty((unknowns, unknowns)), np.empty(unknowns, dtype=np.int64)
    return Tangent(row_slot, row_row, lu, pivots, np.zeros(1))


METHOD = leg.Integrator(
    name="generalized_alpha",
    kind="fixed",
    order=2,
    description="generalized-alpha on the index-3 equations, spectral radius 0.9",
    advance=advance,
    stabilization="none",
    stabilizations=("none", "projection"),
    ladder=(2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
    source="Arnold and Bruls 2007; Chung and Hulbert 1993",
    holds_deflections=False,
    needs_positions=True,
    cores=("planar", "spatial"),
)
