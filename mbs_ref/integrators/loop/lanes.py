"""Many adaptive runs side by side, of one scene or of scenes of one build: a lane is a run with a clock of its own.

Each has its own step, error, figures, tolerances and events. A run is that which `advance_explicit` returns. Stages are
computed side by side. The run's own system, by the handles in `Runs`, starts it, watches for events inside its steps
and changes its modes. A run that comes too close to a singular pose, or whose constraints cannot be restored, ends
there. A lane whose run has ended takes the next one that waits, so that none is idle before the last have begun. What a
lane holds never depends on its neighbours.
"""

from typing import NamedTuple

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.events import ACTIVE, EVENT, KEEP, RETRY, Tables, event_tables, has_events, watch_at
from mbs_ref.integrators.loop.exclusion import Ends
from mbs_ref.integrators.loop.explicit import (
    MOST_AVOIDED,
    NEAR_SINGULAR,
    STAGE_ITERATIONS,
    harmless,
    is_too_near,
    resumed,
    shortened,
)
from mbs_ref.kernels.algebra.lanes import WIDTH, chosen_in_lanes, in_every_lane, in_lanes, larger, smaller
from mbs_ref.kernels.algebra.lanes import room_for_lanes as room
from mbs_ref.kernels.border.handles import Model, Work
from mbs_ref.kernels.border.questions import derivative, project, regularity, roots, tangent
from mbs_ref.kernels.jit import bare, bare_loop, loop_jit
from mbs_ref.kernels.rigid.model import Beside

IDLE = -1


class Runs(NamedTuple):
    """The runs that wait, and what becomes of each."""

    handles: np.ndarray  # (n_runs, 4) int, of its system: model, work, and those of what evaluates its loads
    figures: np.ndarray  # (n_scenes, n_figures) of the systems
    atol: np.ndarray  # (n_scenes, n_state) absolute tolerances
    tolerance: np.ndarray  # (n_scenes,) m, rad, of projection
    scene: np.ndarray  # (n_runs,) int, whose run it is
    states: np.ndarray  # (n_runs, n_times, n_state), the first is the start
    compliance: np.ndarray  # (n_runs, n_times) largest |C| over the steps since the time before
    begun: np.ndarray  # (n_runs, n_state) the start, once its modes are settled
    slopes: np.ndarray  # (n_runs, n_state) f there
    pivot: np.ndarray  # (n_runs,) the smallest closure pivot of the last evaluation there
    now: np.ndarray  # (n_runs,) PROGRESS
    code: np.ndarray  # (n_runs,) int, of mbs_ref.integrators.loop.leg


class Side(NamedTuple):
    """What is side by side: arrays that end in WIDTH lanes, and a number or more of each lane (WIDTH, ...)."""

    figures: np.ndarray  # (n_figures, WIDTH) of the systems
    atol: np.ndarray  # (n_state, WIDTH)
    y: np.ndarray  # (n_state, WIDTH)
    new: np.ndarray  # (n_state, WIDTH) the new state
    spare: np.ndarray  # (n_state, WIDTH)
    slopes: np.ndarray  # (s + 1, n_state, WIDTH)
    now: np.ndarray  # (11, WIDTH): TIME, STEP, TAKEN, MAIN, LOW, PIVOT, LAST, THERE, LEFT, RESTORED, TOLERANCE
    pace: np.ndarray  # (4, WIDTH): MARK, SLOW, NATURAL, AVOIDED
    run: np.ndarray  # (WIDTH,) int, place among the runs or IDLE
    scene: np.ndarray  # (WIDTH,) int, whose figures and tolerances the lane has, or IDLE
    rejected: np.ndarray  # (WIDTH,) int: 1 after a step whose error was too large
    search: np.ndarray  # (WIDTH, 8) for an event
    tables: Tables  # of event functions (WIDTH, 4, n)
    ends: Ends  # of the step of the lane that is judged
    beside: Beside  # what evaluates the loads of each lane; 0 of an idle one


# s at the step's start, h (s), 1 where it is taken, the sums of squares of both estimates of its error, the smallest
# closure pivots of its stages, that at its last one and that at its end, |C| there, 1 where stages are projected,
# tolerance of projection
TIME, STEP, TAKEN, MAIN, LOW, PIVOT, LAST, THERE, LEFT, RESTORED, TOLERANCE = range(11)
# where a run was a stretch of steps ago (s), how many stretches in a row were slow, the step (s) that accuracy allows
# while one is shortened to avoid a singular pose, else 0, and how many attempts in a row were
MARK, SLOW, NATURAL, AVOIDED = range(4)


def runs_from(
    handles: np.ndarray, figures: np.ndarray, atol: np.ndarray, tolerance: np.ndarray, scene: np.ndarray,
    starts: np.ndarray,
) -> Runs:  # fmt: skip
    """Return the runs that are to begin at `starts` (n_runs, n_state)."""
    n, size = starts.shape
    return Runs(
        handles, figures, atol, tolerance, scene, states=starts[:, None], compliance=np.zeros((n, 1)),
        begun=np.empty((n, size)), slopes=np.empty((n, size)), pivot=np.ones(n), now=np.zeros(n, leg.PROGRESS),
        code=np.full(n, leg.DONE),
    )  # fmt: skip


def next_leg(runs: Runs, n_times: int) -> Runs:
    """Return the runs from where they are, with room for the states of a leg; those that failed have ended."""
    n, _, size = runs.states.shape
    states, begun = np.empty((n, n_times, size)), runs.states[:, -1].copy()
    states[:, 0] = begun
    code = np.where(runs.code == leg.DONE, leg.RUNNING, runs.code)
    return runs._replace(states=states, compliance=np.zeros((n, n_times)), begun=begun, code=code)


def room_beside(figures: np.ndarray, beside: Beside, n_state: int, n_stages: int, n_roots: int) -> Side:
    """Return room for WIDTH runs, whose figures are to be in `figures` (n_figures, WIDTH), and handles in `beside`."""
    return Side(
        figures=figures, atol=room(n_state), y=room(n_state), new=room(n_state), spare=room(n_state),
        slopes=room(n_stages + 1, n_state), now=room(11), pace=room(4),
        run=np.full(WIDTH, IDLE), scene=np.full(WIDTH, IDLE), rejected=np.zeros(WIDTH, np.int64),
        search=np.zeros((WIDTH, 8)), tables=Tables(*np.zeros((3, WIDTH, 4, n_roots))),
        ends=Ends(*np.zeros((4, n_state)), known=np.ones(2, np.int64)), beside=beside,
    )  # fmt: skip


@bare
def _add_slopes(y, weights, count, slopes, h, out):
    """Write y + h sum w_j k_j over the first `count` slopes."""
    for k in range(out.shape[0]):
        total = weights[0] * slopes[0, k]
        for j in range(1, count):
            if weights[j] != 0.0:
                total = total + weights[j] * slopes[j, k]
        out[k] = y[k] + h * total


@bare
def _restore(model, work, t, new, spare, now):
    """Project the states of the lanes that are near a singular pose."""
    for k in range(new.shape[0]):
        spare[k] = new[k]
    project(model, work, t, spare, now[TOLERANCE], STAGE_ITERATIONS)
    for k in range(new.shape[0]):
        new[k] = chosen_in_lanes(now[RESTORED], spare[k], new[k])


@bare
def _square_sum(model, work, weights, rtol, atol, y, new, spare, slopes, now, restores, pivot):
    """Return for an estimate of the error the sum of squares over the state, each entry in its tolerance.

    Of lanes near a singular pose an error off the constraints that is harmless at the stages' `pivot` does not count.
    The last slope is not in use yet.
    """
    count, last = weights.shape[0], slopes[weights.shape[0]]
    for k in range(y.shape[0]):
        total = weights[0] * slopes[0, k]
        for j in range(1, count):
            if weights[j] != 0.0:
                total = total + weights[j] * slopes[j, k]
        last[k] = now[STEP] * total
    whole = _squared(last, rtol, atol, y, new)
    if not restores:
        return whole
    for k in range(y.shape[0]):
        spare[k] = last[k]
    tangent(model, work, spare)
    along = _squared(spare, rtol, atol, y, new)
    off = larger(np.sqrt(whole) - np.sqrt(1.0 * y.shape[0]) * harmless(pivot, rtol), 0.0 * along)
    return chosen_in_lanes(now[RESTORED], larger(off * off, along) + 0.0 * along, whole)  # NaN must stay NaN


@bare
def _squared(error, rtol, atol, y, new):
    """Return the sum of squares of an error, each entry in its tolerance."""
    square = 0.0 * error[0]
    for k in range(y.shape[0]):
        scaled = error[k] / (atol[k] + rtol * larger(abs(y[k]), abs(new[k])))
        square = square + scaled * scaled
    return square


@bare
def _error(main, low, n):
    """Return the scaled error of one lane (Hairer, Norsett, Wanner I, sec. II.10), of two sums of squares."""
    scale = (main + 0.01 * low) * n
    return 0.0 if scale == 0.0 else main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


# Return the event functions of a lane.
_table = bare(lambda side, w: Tables(side.tables.low[w], side.tables.high[w], side.tables.new[w]))
# Return model and work of a run's own system.
_system = bare(lambda runs, i: (Model(runs.handles[i, 0]), Work(runs.handles[i, 1])))


@loop_jit
def begin_all(options, runs, first, last, times, order):
    """Begin a leg of a scene's runs, first to last, as a run alone does: modes, f, and a guess of the first step."""
    for i in range(first, last):
        if runs.code[i] != leg.RUNNING:
            continue
        (model, work), y, slope, run = _system(runs, i), runs.begun[i], runs.slopes[i], runs.now[i]
        run.t, run.h, run.next_output, run.span = times[0], 0.0, 1, times[-1] - times[0]
        runs.code[i] = stepping.begin(model, work, options, run, y, slope, event_tables(model)[1])
        if runs.code[i] == leg.RUNNING:
            run.h = stepping.first_step(model, work, run.t, y, slope, order, options, run.span)
            run.rhs_calls += 1
            runs.pivot[i] = regularity(work)


@bare
def _take_up(runs, side, i, w):
    """Put run i, which waits, into lane w."""
    scene = runs.scene[i]
    if side.scene[w] != scene:
        side.scene[w] = scene
        side.now[TOLERANCE, w] = runs.tolerance[scene]
        for k in range(side.figures.shape[0]):
            side.figures[k, w] = runs.figures[scene, k]
        for k in range(side.y.shape[0]):
            side.atol[k, w] = runs.atol[scene, k]
    for k in range(side.y.shape[0]):
        side.y[k, w], side.slopes[0, k, w] = runs.begun[i, k], runs.slopes[i, k]
    side.run[w], side.rejected[w], side.search[w, ACTIVE] = i, 0, 0.0
    side.now[PIVOT, w] = side.now[THERE, w] = runs.pivot[i]
    side.pace[MARK, w], side.pace[SLOW, w] = runs.now[i].t, 0.0
    side.pace[NATURAL, w], side.pace[AVOIDED, w] = 0.0, 0.0
    side.beside.model[w], side.beside.work[w] = runs.handles[i, 2], runs.handles[i, 3]
    table = _table(side, w)
    if has_events(table):
        model, work = _system(runs, i)
        roots(model, work, runs.now[i].t, runs.begun[i], 0.0, table.low)


@bare
def _fill(runs, side, waiting, last):
    """Give every idle lane a run that waits, the next of which is `waiting`; return the next and how many lanes run."""
    busy = 0
    for w in range(WIDTH):
        while waiting < last and runs.code[waiting] != leg.RUNNING:
            waiting += 1
        if side.run[w] == IDLE and waiting < last:
            _take_up(runs, side, waiting, w)
            waiting += 1
        busy += side.run[w] != IDLE
    return waiting, busy


@bare
def _attempt(runs, side, times, i, w):
    """Return the step that lane w is to try."""
    run = runs.now[i]
    return stepping.next_attempt(0.0, run, times[run.next_output], side.pace[NATURAL, w] == 0.0, side.search[w])


@bare
def _choose_steps(options, runs, side, times):
    """Choose the step of every lane, 0 where it is idle; return whether any projects its stages."""
    restores, now = False, side.now
    for w in range(WIDTH):
        i = side.run[w]
        now[STEP, w] = now[RESTORED, w] = 0.0
        if i == IDLE:
            continue
        attempt = _attempt(runs, side, times, i, w)
        now[TIME, w], now[STEP, w] = attempt.t, attempt.h
        is_near = (side.rejected[w] == 1 and now[PIVOT, w] < NEAR_SINGULAR) or now[THERE, w] < NEAR_SINGULAR
        if options.project and is_near:
            runs.now[i].near_singular += 1
            now[RESTORED, w] = 1.0
            restores = True
    return restores


@bare
def _try(model, work, tableau, options, atol, y, new, spare, slopes, now, restores):
    """Make the step of every lane; leave the new states and the sums of squares of their errors."""
    h, count, pivot = now[STEP], tableau.b.shape[0], in_every_lane(1.0)
    for i in range(1, count):
        _add_slopes(y, tableau.a[i], i, slopes, h, new)
        t = now[TIME] + tableau.c[i] * h
        if restores:
            _restore(model, work, t, new, spare, now)
        derivative(model, work, t, new, slopes[i])
        pivot = smaller(pivot, regularity(work))
    _add_slopes(y, tableau.b, count, slopes, h, new)
    t, now[LAST] = now[TIME] + h, regularity(work)
    if restores:
        _restore(model, work, t, new, spare, now)
        now[LAST] = chosen_in_lanes(now[RESTORED], regularity(work), now[LAST])
    for place, weights in ((MAIN, tableau.error), (LOW, tableau.error_low)):
        now[place] = _square_sum(model, work, weights, options.rtol, atol, y, new, spare, slopes, now, restores, pivot)
    if options.project:
        now[LEFT] = project(model, work, t, new, now[TOLERANCE], stepping.PROJECTION_ITERATIONS)
    derivative(model, work, t, new, slopes[count])
    now[PIVOT], now[THERE] = pivot, regularity(work)


@bare
def _is_hopeless(options, run, side, w):
    """Return whether a run creeps: twice in a row a stretch of steps at which max_steps would not suffice."""
    if run.steps % options.chunk != 0:
        return False
    creeps = run.t - side.pace[MARK, w] < run.span * options.chunk / options.max_steps
    side.pace[MARK, w], side.pace[SLOW, w] = run.t, side.pace[SLOW, w] + 1.0 if creeps else 0.0
    return side.pace[SLOW, w] >= 2.0


@bare
def _is_avoided(options, side, w):
    """Return whether a step is not to end so close to a singular pose."""
    pivot = side.now[PIVOT, w] if side.now[RESTORED, w] == 1.0 else 1.0
    return is_too_near(side.now[THERE, w], pivot, options.rtol, side.pace[AVOIDED, w], True)


@bare
def _avoid(options, run, side, attempt, outputs, w):
    """Store an output next to a singular pose, or shorten the step that would end there; return how the run stands."""
    pace = side.pace
    pace[AVOIDED, w] += 1.0
    if pace[AVOIDED, w] > MOST_AVOIDED:
        return leg.SINGULAR
    if attempt.lands:
        stepping.record(run, side.ends.y_new, outputs)
        return leg.DONE if run.next_output == outputs.times.shape[0] else leg.RUNNING
    pace[NATURAL, w] = max(pace[NATURAL, w], run.h)
    is_last = pace[AVOIDED, w] == MOST_AVOIDED
    run.h = pace[NATURAL, w] if is_last else shortened(attempt.h, side.now[THERE, w], options.rtol)
    return leg.RUNNING


@bare
def _resize(tableau, run, side, attempt, w):
    """Propose the next step of lane w by this one's error; return whether that is borne, and how the run stands."""
    error = _error(side.now[MAIN, w], side.now[LOW, w], side.y.shape[0])
    was_rejected = side.rejected[w] == 1
    is_borne, run.h = stepping.resized(
        error, tableau.error_order, attempt.h, attempt.proposed, attempt.lands, was_rejected
    )
    side.rejected[w] = 0 if is_borne else 1
    if is_borne:
        return True, leg.RUNNING
    run.rejected += 1
    side.now[THERE, w] = side.now[LAST, w]
    if attempt.t + run.h == attempt.t or run.h < stepping.SHORTEST * run.span:
        return False, leg.STEP_TOO_SMALL if np.isfinite(error) else leg.NON_FINITE
    return False, leg.RUNNING


@bare
def _judge(tableau, options, runs, side, times, i, w):
    """Judge the step of lane w by its error and the events inside; return how run i stands and whether it is taken."""
    run, now, last, (model, work) = runs.now[i], side.now, tableau.b.shape[0], _system(runs, i)
    table, ends, attempt = _table(side, w), side.ends, _attempt(runs, side, times, i, w)
    if stepping.stands_still(attempt):
        return leg.STEP_TOO_SMALL, False
    run.rhs_calls += last
    if not attempt.searching:
        is_borne, code = _resize(tableau, run, side, attempt, w)
        if not is_borne:
            return code, False
    if not now[LEFT, w] <= stepping.PROJECTION_FAILURE * now[TOLERANCE, w]:
        return leg.PROJECTION, False
    run.compliance = max(run.compliance, now[LEFT, w])
    for k in range(side.y.shape[0]):
        ends.y[k], ends.y_new[k] = side.y[k, w], side.new[k, w]
        ends.dy[k], ends.dy_new[k] = side.slopes[0, k, w], side.slopes[last, k, w]
    verdict = KEEP
    if has_events(table):
        verdict = watch_at(options.watch, model, work, attempt.t, attempt.h, ends, run, side.search[w], table)
        if verdict == RETRY:
            run.h = attempt.proposed
            return leg.RUNNING, False
    outputs = leg.Outputs(times, runs.states[i], runs.compliance[i])
    if verdict != EVENT and _is_avoided(options, side, w):
        return _avoid(options, run, side, attempt, outputs, w), False
    run.h, side.pace[NATURAL, w], side.pace[AVOIDED, w] = resumed(run.h, side.pace[NATURAL, w]), 0.0, 0.0
    code = stepping.accept(model, work, options, run, attempt, verdict, ends.y, ends.y_new, table, outputs)
    if verdict == EVENT and code == leg.RUNNING:
        _take_event(model, work, attempt.t_new, side, w, last)
        run.rhs_calls += 1
    if code == leg.RUNNING and _is_hopeless(options, run, side, w):
        return leg.STALLED, True
    return code, True


@bare
def _take_event(model, work, t, side, w, last):
    """Let lane w go on from the state after an event, in its new modes."""
    derivative(model, work, t, side.ends.y, side.ends.dy)
    side.now[THERE, w] = regularity(work)
    for k in range(side.y.shape[0]):
        side.new[k, w], side.slopes[last, k, w] = side.ends.y[k], side.ends.dy[k]


@bare
def _judge_all(tableau, options, runs, side, times):
    """Judge the step of every lane and put runs that have ended out of theirs; return whether any has."""
    ended = False
    for w in range(WIDTH):
        i = side.run[w]
        side.now[TAKEN, w] = 0.0
        if i != IDLE:
            code, taken = _judge(tableau, options, runs, side, times, i, w)
            side.now[TAKEN, w] = 1.0 if taken else 0.0
            runs.code[i] = code
            if code != leg.RUNNING:
                side.run[w] = IDLE
                side.beside.model[w] = 0
                ended = True
    return ended


@bare_loop
def advance_in_lanes(model, work, tableau, options, runs, side, times, first, last):
    """Integrate the runs from `first` to `last`, each to its last time or to its first failure."""
    atol, y, new, spare = in_lanes(side.atol), in_lanes(side.y), in_lanes(side.new), in_lanes(side.spare)
    slopes, now = in_lanes(side.slopes), in_lanes(side.now)
    final = tableau.b.shape[0]
    waiting, busy = _fill(runs, side, first, last)
    while busy > 0:
        restores = _choose_steps(options, runs, side, times)
        _try(model, work, tableau, options, atol, y, new, spare, slopes, now, restores)
        ended = _judge_all(tableau, options, runs, side, times)
        taken = now[TAKEN]
        for k in range(y.shape[0]):
            y[k] = chosen_in_lanes(taken, new[k], y[k])
            slopes[0, k] = chosen_in_lanes(taken, slopes[final, k], slopes[0, k])
        if ended:
            waiting, busy = _fill(runs, side, waiting, last)
