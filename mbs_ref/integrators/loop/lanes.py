"""Many adaptive runs side by side, of one scene or of scenes of one build: a lane is a run with a clock of its own.

Each has its own step, error, figures and tolerances. A run is that which `advance_explicit` returns of a system without
events. One that comes close to a singular pose, or whose constraints cannot be restored, ends there. A lane whose run
has ended takes the next one that waits, so that none is idle before the last have begun. What a lane holds never
depends on its neighbours.
"""

from typing import NamedTuple

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.explicit import NEAR_SINGULAR
from mbs_ref.kernels.algebra.lanes import WIDTH, chosen_in_lanes, in_every_lane, in_lanes, larger, smaller
from mbs_ref.kernels.algebra.lanes import room_for_lanes as room
from mbs_ref.kernels.border.questions import derivative, project, regularity
from mbs_ref.kernels.jit import bare, bare_loop, loop_jit

IDLE = -1


class Runs(NamedTuple):
    """The runs that wait, and what becomes of each."""

    figures: np.ndarray  # (n_scenes, n_figures) of their systems
    atol: np.ndarray  # (n_scenes, n_state) absolute tolerances
    scene: np.ndarray  # (n_runs,) int, whose run it is
    states: np.ndarray  # (n_runs, n_times, n_state), the first is the start
    compliance: np.ndarray  # (n_runs, n_times) largest |C| over the steps since the time before
    slopes: np.ndarray  # (n_runs, n_state) f at the start
    t: np.ndarray  # (n_runs,) s, where it is
    h: np.ndarray  # (n_runs,) s, next step
    steps: np.ndarray  # (n_runs,) int
    rejected: np.ndarray  # (n_runs,) int
    cut: np.ndarray  # (n_runs,) int, steps that end at an output, where accuracy allows longer ones
    rhs_calls: np.ndarray  # (n_runs,) int
    next_output: np.ndarray  # (n_runs,) int, place among the times
    code: np.ndarray  # (n_runs,) int, of mbs_ref.integrators.loop.leg


class Side(NamedTuple):
    """What is side by side: arrays that end in WIDTH lanes, and a number of each lane (WIDTH,)."""

    figures: np.ndarray  # (n_figures, WIDTH) of the systems
    atol: np.ndarray  # (n_state, WIDTH)
    y: np.ndarray  # (n_state, WIDTH)
    new: np.ndarray  # (n_state, WIDTH) the new state
    slopes: np.ndarray  # (s + 1, n_state, WIDTH)
    now: np.ndarray  # (6, WIDTH): STEP, TAKEN, MAIN, LOW, PIVOT, LEFT
    pace: np.ndarray  # (2, WIDTH): MARK, SLOW
    run: np.ndarray  # (WIDTH,) int, place among the runs or IDLE
    scene: np.ndarray  # (WIDTH,) int, whose figures and tolerances the lane has, or IDLE
    lands: np.ndarray  # (WIDTH,) int: 1 where the step ends at an output
    rejected: np.ndarray  # (WIDTH,) int: 1 after a step whose error was too large
    search: np.ndarray  # (1,), for no event


# h (s), 1 where it is taken, the sums of squares of both estimates of its error, the smallest closure pivot of its
# stages, |C| at its end
STEP, TAKEN, MAIN, LOW, PIVOT, LEFT = range(6)
MARK, SLOW = range(2)  # where a run was a stretch of steps ago (s), and how many stretches in a row were slow


def runs_from(figures: np.ndarray, atol: np.ndarray, scene: np.ndarray, starts: np.ndarray, n_times: int) -> Runs:
    """Return the runs that wait, from `starts` (n_runs, n_state), with room for what becomes of them."""
    n, size = starts.shape
    states = np.empty((n, n_times, size))
    states[:, 0] = starts
    counts = [np.zeros(n, np.int64) for _ in range(6)]
    return Runs(
        figures, atol, scene, states, np.zeros((n, n_times)), np.empty((n, size)), np.zeros(n), np.zeros(n), *counts
    )


def room_beside(figures: np.ndarray, n_state: int, n_stages: int) -> Side:
    """Return room for WIDTH runs, whose figures are to be in `figures` (n_figures, WIDTH)."""
    return Side(
        figures=figures, atol=room(n_state), y=room(n_state), new=room(n_state),
        slopes=room(n_stages + 1, n_state), now=room(6), pace=room(2),
        run=np.full(WIDTH, IDLE), scene=np.full(WIDTH, IDLE), lands=np.zeros(WIDTH, np.int64),
        rejected=np.zeros(WIDTH, np.int64), search=np.zeros(1),
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
def _square_sums(tableau, rtol, atol, h, y, new, slopes):
    """Return for both estimates of the error the sum of squares over the state, each entry in its tolerance."""
    main, low = 0.0 * h, 0.0 * h
    for k in range(y.shape[0]):
        first, second = tableau.error[0] * slopes[0, k], tableau.error_low[0] * slopes[0, k]
        for j in range(1, tableau.error.shape[0]):
            if tableau.error[j] != 0.0 or tableau.error_low[j] != 0.0:
                first = first + tableau.error[j] * slopes[j, k]
                second = second + tableau.error_low[j] * slopes[j, k]
        size = larger(abs(y[k]), abs(new[k]))
        unit = h / (atol[k] + rtol * size)
        main = main + (first * unit) * (first * unit)
        low = low + (second * unit) * (second * unit)
    return main, low


@bare
def _error(main, low, n):
    """Return the scaled error of one lane (Hairer, Norsett, Wanner I, sec. II.10), of `_square_sums`."""
    scale = (main + 0.01 * low) * n
    return 0.0 if scale == 0.0 else main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


@loop_jit
def propose_all(model, work, options, runs, first, last, times, order):
    """Evaluate f at the starts of a scene's runs, first to last, and guess the first steps, as a run alone does."""
    for i in range(first, last):
        y, slope = runs.states[i, 0], runs.slopes[i]
        derivative(model, work, times[0], y, slope)
        runs.h[i] = stepping.first_step(model, work, times[0], y, slope, order, options, times[-1] - times[0])
        runs.t[i], runs.next_output[i], runs.rhs_calls[i] = times[0], 1, 2
        runs.code[i] = leg.SINGULAR if regularity(work) < NEAR_SINGULAR else leg.RUNNING


@bare
def _take_up(runs, side, i, w):
    """Put run i, which waits, into lane w."""
    scene = runs.scene[i]
    if side.scene[w] != scene:
        side.scene[w] = scene
        for k in range(side.figures.shape[0]):
            side.figures[k, w] = runs.figures[scene, k]
        for k in range(side.y.shape[0]):
            side.atol[k, w] = runs.atol[scene, k]
    for k in range(side.y.shape[0]):
        side.y[k, w], side.slopes[0, k, w] = runs.states[i, 0, k], runs.slopes[i, k]
    side.run[w], side.rejected[w] = i, 0
    side.pace[MARK, w], side.pace[SLOW, w] = runs.t[i], 0.0


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
def _choose_steps(options, runs, side, times):
    """Choose the step of every lane, 0 where it is idle."""
    for w in range(WIDTH):
        i = side.run[w]
        if i == IDLE:
            side.now[STEP, w] = 0.0
            continue
        reach = times[runs.next_output[i]] - runs.t[i]
        h, lands, _ = stepping.choose_step(runs.h[i], reach, True, side.search)
        side.now[STEP, w], side.lands[w] = h, lands


@bare
def _try(model, work, tableau, options, atol, y, new, slopes, now):
    """Make the step of every lane; leave the new states and the sums of squares of their errors."""
    h, count, pivot = now[STEP], tableau.b.shape[0], in_every_lane(1.0)
    for i in range(1, count + 1):
        _add_slopes(y, tableau.a[i] if i < count else tableau.b, i, slopes, h, new)
        if i == count:
            now[MAIN], now[LOW] = _square_sums(tableau, options.rtol, atol, h, y, new, slopes)
            if options.project:
                now[LEFT] = project(model, work, 0.0, new, options.projection_tolerance, stepping.PROJECTION_ITERATIONS)
        derivative(model, work, 0.0, new, slopes[i])
        pivot = smaller(pivot, regularity(work))
    now[PIVOT] = pivot


@bare
def _is_hopeless(options, runs, side, span, i, w):
    """Return whether a run creeps: twice in a row a stretch of steps at which max_steps would not suffice."""
    if runs.steps[i] % options.chunk != 0:
        return False
    creeps = runs.t[i] - side.pace[MARK, w] < span * options.chunk / options.max_steps
    side.pace[MARK, w], side.pace[SLOW, w] = runs.t[i], side.pace[SLOW, w] + 1.0 if creeps else 0.0
    return side.pace[SLOW, w] >= 2.0


@bare
def _judge(tableau, options, runs, side, times, i, w):
    """Propose the next step of lane w by this one's error; return how run i stands and whether the step is taken."""
    h, lands, span = side.now[STEP, w], side.lands[w] == 1, times[-1] - times[0]
    target = times[runs.next_output[i]]
    t_new = target if lands else runs.t[i] + h
    if t_new == runs.t[i]:
        return leg.STEP_TOO_SMALL, False
    runs.rhs_calls[i] += tableau.b.shape[0]
    if not side.now[PIVOT, w] >= NEAR_SINGULAR:
        return leg.SINGULAR, False
    proposed = runs.h[i]
    error = _error(side.now[MAIN, w], side.now[LOW, w], side.y.shape[0])
    accepted, runs.h[i] = stepping.resized(error, tableau.error_order, h, runs.h[i], lands, side.rejected[w] == 1)
    side.rejected[w] = 0 if accepted else 1
    if not accepted:
        runs.rejected[i] += 1
        if runs.t[i] + runs.h[i] == runs.t[i] or runs.h[i] < stepping.SHORTEST * span:
            return leg.STEP_TOO_SMALL if np.isfinite(error) else leg.NON_FINITE, False
        return leg.RUNNING, False
    place, left = runs.next_output[i], side.now[LEFT, w]
    if not left <= stepping.PROJECTION_FAILURE * options.projection_tolerance:
        return leg.PROJECTION, False
    runs.compliance[i, place] = max(runs.compliance[i, place], left)
    runs.t[i] = t_new
    runs.steps[i] += 1
    if lands:
        runs.cut[i] += stepping.is_cut(proposed, h)
        for k in range(side.y.shape[0]):
            runs.states[i, place, k] = side.new[k, w]
        runs.next_output[i] += 1
        if runs.next_output[i] == times.shape[0]:
            return leg.DONE, True
    if runs.steps[i] >= options.max_steps:
        return leg.TOO_MANY_STEPS, True
    return leg.STALLED if _is_hopeless(options, runs, side, span, i, w) else leg.RUNNING, True


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
                ended = True
    return ended


@bare_loop
def advance_in_lanes(model, work, tableau, options, runs, side, times, first, last):
    """Integrate the runs from `first` to `last`, each to its last time or to its first failure."""
    atol, y, new = in_lanes(side.atol), in_lanes(side.y), in_lanes(side.new)
    slopes, now = in_lanes(side.slopes), in_lanes(side.now)
    final = tableau.b.shape[0]
    waiting, busy = _fill(runs, side, first, last)
    while busy > 0:
        _choose_steps(options, runs, side, times)
        _try(model, work, tableau, options, atol, y, new, slopes, now)
        ended = _judge_all(tableau, options, runs, side, times)
        taken = now[TAKEN]
        for k in range(y.shape[0]):
            y[k] = chosen_in_lanes(taken, new[k], y[k])
            slopes[0, k] = chosen_in_lanes(taken, slopes[final, k], slopes[0, k])
        if ended:
            waiting, busy = _fill(runs, side, waiting, last)
