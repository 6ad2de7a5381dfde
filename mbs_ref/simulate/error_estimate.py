"""Estimate the global error of a run by Richardson extrapolation from a second, more accurate run, the companion.

Sources: Richardson (1911); P. J. Roache, J. Fluids Eng. 116 (1994) 405. The companion uses half of a fixed step, or a
tenth of the tolerances. If its errors are k times smaller, the two runs differ by d = e (1 - 1/k), so the run's error
is e = d k / (k - 1) (Hairer, Norsett, Wanner I, eq. II.4.4). k is 2^p at order p, 2 where impacts and kinks reduce the
order to 1, and 10 if errors are proportional to the tolerance (ibid., sec. II.4). The companion's rounding error is
added to d, since no refinement removes it. Two runs cannot confirm asymptotic convergence, so the estimate is
multiplied by SAFETY. An error can pass through zero by chance, so the estimate is the running maximum over time.
Of fixed steps a third run, with twice the step, shows k, and a fourth with a quarter of it where k is much smaller than
the order means, or far larger: between two events that are closer than a step, halved steps may be the same. Where
differences do not decrease, the estimate is the size of the motion. So it is for all methods beyond the time until
which digits hold, unless the further runs confirm the order.

Proportionality to the tolerance requires a constant order. For methods of variable order the companion's tolerance is
two decades tighter, and the estimate is at least that tolerance. For methods that accept steps with an error beyond the
tolerance, it is tighter by the same factor. The violation of the constraints is measured, since both runs may share it.

Where outputs end nearly all steps of an explicit method, and declared breakpoints none, a companion with steps of twice
the size costs half of the run: only every second output ends a step, and tolerances are 2^p times as large. Then
e = d / (2^p - 1). If tolerances limit its steps, or it takes more than half as many, the tighter companion follows.

If the companion takes no more steps, or the difference is negligible, the tolerance does not control the steps with the
largest errors; a third run is then two decades tighter. So is the second one of a run that projected its stages close
to a singular pose; neither counts as more accurate than a first companion. If a companion does not reach the end, or
roundoff forbids a tighter one, a coarser one replaces it, whose errors are the larger ones, so that d bounds them. If
that fails, or ran already, another method is used.
"""

import math
import time
from collections.abc import Generator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.loop.leg import FEWEST, Options
from mbs_ref.observables.distance import coordinate_size, motion_size, relative
from mbs_ref.scene import UserForce
from mbs_ref.scene.traits import touching
from mbs_ref.simulate.legs import EPS, Run, run_legs, start_run
from mbs_ref.simulate.plan import ABSOLUTE, DEFAULT_TOLERANCE, Plan
from mbs_ref.trajectory import VISIBLE, Estimate, Status

SAFETY = 3.0  # multiplies the estimate: Roache's grid convergence index for two runs
DECADE = 10.0  # tolerance over the companion's
TIGHTEST = 1e-13  # smallest rtol of a companion: some hundred EPS, below which roundoff dominates
MIN_COARSENING = 0.75  # steps of the run with twice the step, over the run's: more show no order
MIN_TOLERANCE_RATIO = 1e-3  # smallest error of a step that the tolerance controls, over the tolerance
NOISY = 100.0  # times the rounding error: smaller differences show no order
MORE_STEPS = 4  # max_steps of a finer companion over the run's: sqrt(10) at order 2, rounded up
CUT = 0.9  # share of the steps that outputs cut short, from which they determine the steps
DOUBLED = 0.53  # largest share of the run's steps that steps of twice the size are, besides half a step
COARSEST = 1e-2  # largest rtol of a companion with steps of twice the size
COARSE_SAFETY = 9.0  # in place of SAFETY there, by calibration: longer steps follow the order less closely
NOISE = 1e-11  # smaller relative differences there count in full: rounding errors follow no order
SECOND_METHOD = "lsodar"  # companion if the default method itself fails
DOUBLE = "steps of twice the size"  # share of a companion
ENDED = frozenset({Status.SUCCESS, Status.STOP_EVENT})


class RunWithPoses(NamedTuple):
    """A run and its poses at the outputs."""

    run: Run
    poses: Poses


class Request(NamedTuple):
    """How a companion is computed."""

    share: str  # of the run's step or tolerance
    plan: Plan
    refine: int  # of `run_legs`
    factor: float  # estimate over the difference of the two runs

    @property
    def is_coarse(self) -> bool:
        """Whether steps have twice the size, and every second output is one."""
        return self.share == DOUBLE


class Companion(NamedTuple):
    """A companion run, its distance from the run, and the estimate that it gives."""

    request: Request
    run: Run
    gaps: np.ndarray  # (n, 4) at the companion's outputs that both reached, over the scene's scales
    sizes: np.ndarray  # (4,) how far the two motions go at most
    bounds: np.ndarray  # (n, 4), the estimate at the run's outputs that both reached


type Asking[T] = Generator[Request, Companion, T]


class _Comparison(NamedTuple):
    """The estimate from one companion."""

    bounds: np.ndarray  # (n, 4), the estimate at the outputs that both reached
    other: Companion
    status: Status
    how: str
    is_alike: bool = False  # took no more steps despite a tighter tolerance
    is_uninformative: bool = False  # took no more steps, or hardly differs, despite a tighter tolerance
    is_confirmed: bool = False  # further runs show the order

    @property
    def has_ended(self) -> bool:
        return self.status in ENDED


def companions(
    system: System, request: Request, runs: list[Run], poses: list[Poses], others: list[Run]
) -> list[Companion]:
    """Return the companions `others` of runs with what they show; runs of one length are vectorised."""
    result: dict[int, Companion] = {}
    lengths = [(len(run.times), len(other.times)) for run, other in zip(runs, others, strict=True)]
    for length in set(lengths):
        places = [k for k, own in enumerate(lengths) if own == length]
        own, again = [runs[k] for k in places], [others[k] for k in places]
        shown = _outputs(request, own[0].times)
        parts = [np.stack(parts)[:, shown] for parts in zip(*(poses[k] for k in places), strict=True)]
        gaps, sizes = _distance(system, own[0].times[shown], Poses(*parts), np.stack([run.states for run in again]))
        bounds = _bounds(system, request, gaps, sizes, own, again)
        every = [request] * len(places)
        result |= zip(places, map(Companion, every, again, gaps, sizes, bounds), strict=True)
    return [result[k] for k in range(len(runs))]


def _outputs(request: Request, times: np.ndarray) -> np.ndarray:
    """Return which of the run's outputs are the companion's."""
    return _every_second(times) if request.is_coarse else np.arange(len(times))


def _bounds(
    system: System, request: Request, gaps: np.ndarray, sizes: np.ndarray, runs: list[Run], others: list[Run]
) -> np.ndarray:
    """Return the estimates (n_runs, n, 4) from distances (n_runs, n_common, 4) and sizes (n_runs, 4)."""
    every = runs[0].times
    times = every[_outputs(request, every)[: gaps.shape[1]]]
    noise = np.array([[[_roundoff(run)]] for run in (runs if request.is_coarse else others)])
    # rounding of rates moves bodies by the same share of their path
    path = np.fmax(1.0, np.max(sizes[:, None, 2:], axis=-1, keepdims=True) * times[:, None] / system.scales.time)
    most = 2.0 * sizes[:, None]  # two points within a distance of the start are at most twice that distance apart
    if not request.is_coarse:
        return np.fmax(gaps, np.minimum(request.factor * (gaps + noise * path), most))
    least = SAFETY * (np.minimum(gaps, NOISE * path) + noise * path)
    after = np.searchsorted(times, every[every <= times[-1]])
    return np.minimum(np.fmax(request.factor * gaps, least), most)[:, after]


def estimated(system: System, plan: Plan, run: Run, poses: Poses) -> Estimate | None:
    """Return the estimated error of a run with these poses at its output times; None if Ctrl-C ended a companion."""
    began, steps = time.perf_counter(), estimating(system, plan, run, poses)
    request = next(steps)
    while True:
        times = run.times[_outputs(request, run.times)]
        other = _rerun(system, request.plan, run.states[0], times, request.refine)
        try:
            request = steps.send(companions(system, request, [run], [poses], [other])[0])
        except StopIteration as end:
            return end.value and replace(end.value, cost_s=time.perf_counter() - began)


def estimating(system: System, plan: Plan, run: Run, poses: Poses) -> Asking[Estimate | None]:
    """Return `estimated`, whose companions are computed by the caller: one is sent for each request that is yielded."""
    scales, own = system.scales, RunWithPoses(run, poses)
    compared = yield from _comparisons(system, plan, own)
    if any(one.status is Status.INTERRUPTED for one in compared):
        return None
    opening, went = _opening(system, plan, run) if plan.options.step else (np.zeros(4), np.zeros(4))
    reached = max(len(one.bounds) for one in compared)
    scale = coordinate_size(scales, own.poses.position)
    least = np.fmax(SAFETY * opening, _least(plan, run, compared) * scale)
    bounds = SAFETY * _off_constraints(system, plan, own) + least
    for one in compared:
        count = len(one.bounds)
        bounds[:count] = np.fmax(bounds[:count], one.bounds)
    bounds[0], bounds[reached:] = 0.0, np.inf
    sizes = np.max([went, *(one.other.sizes for one in compared)], axis=0)
    estimate = Estimate(
        times=run.times, components=np.maximum.accumulate(bounds), how="; ".join(one.how for one in compared),
        size=float(np.max(sizes[:2])),
        tolerance=(plan.settings.rtol or DEFAULT_TOLERANCE) * scale,
        cost_s=sum(one.other.run.loop_s for one in compared), length=scales.length, time=scales.time,
    )  # fmt: skip
    if estimate.holds_until is None or (yield from _is_confirmed(system, plan, compared[0])):
        return estimate
    lost = run.times[:, None] > estimate.holds_until
    return replace(estimate, components=np.where(lost, np.fmax(estimate.components, sizes), estimate.components))


def _least(plan: Plan, run: Run, compared: list[_Comparison]) -> float:
    """Return the smallest relative error of a run: rounding, and a step's share where no tolerance has an effect."""
    roundoff = SAFETY * _roundoff(run)
    if plan.integrator.varies_order:
        return roundoff + plan.options.rtol / _tolerance_ratio(plan)
    return roundoff + (plan.options.rtol * MIN_TOLERANCE_RATIO if all(one.is_alike for one in compared) else 0.0)


def _roundoff(run: Run) -> float:
    """Return the relative rounding error of coordinates: a random walk (D. Brouwer, Astron. J. 46 (1937) 149)."""
    return EPS * math.sqrt(run.counts.steps)


def _tolerance_ratio(plan: Plan) -> float:
    """Return the run's tolerance over the companion's."""
    return DECADE**2 if plan.integrator.varies_order else DECADE * plan.integrator.slack


def _comparisons(system: System, plan: Plan, own: RunWithPoses) -> Asking[list[_Comparison]]:
    """Return the comparisons with the needed companions, no two alike: one as a rule."""
    if _is_coarsened(system, plan, own.run):
        coarse = yield from _compared(plan, own, _doubled(plan))
        if coarse.status is Status.INTERRUPTED or _shows_order(own.run, coarse.other):
            return [coarse]
    begun, second, needs_second = _first_two(system, plan, own.run)
    compared = [(yield from _compared(plan, own, begun))]
    if plan.options.step and compared[0].has_ended:
        compared[0] = yield from _by_observed_order(system, plan, own, compared[0])
    wanted = compared[0].is_uninformative or needs_second
    if compared[0].has_ended and not wanted:
        return compared
    middle = [second] if wanted or own.run.near_singular else []
    _, *further = {one.share: one for one in (begun, *middle, _coarser(plan), _by_another_method(plan))}.values()
    if compared[0].has_ended:
        further = further[:-1] or further  # another method, which may cost far more, only for want of any other
    while further and compared[-1].status is not Status.INTERRUPTED and (wanted or not compared[-1].has_ended):
        compared.append((yield from _compared(plan, own, further.pop(0))))
        wanted = False
    return compared


def _is_coarsened(system: System, plan: Plan, run: Run) -> bool:
    """Return whether the companion of a run has steps of twice the size, because outputs determine the steps."""
    options, scene = plan.options, system.scene
    unknown = run.near_singular or any(isinstance(load, UserForce) for load in scene.loads)
    unknown = unknown or bool(scene.breakpoints())  # steps that these end are the same in both runs
    controlled = bool(plan.integrator.stability) and not options.step and not options.dense and not unknown
    within = len(run.times) > 2 and TIGHTEST <= options.rtol <= COARSEST / 2.0**plan.integrator.order
    return controlled and within and not system.event_sources and not touching(scene) and _is_cut(run)


def _is_cut(run: Run) -> bool:
    return run.counts.cut_steps >= CUT * run.counts.steps


def _doubled(plan: Plan) -> Request:
    """Request steps of twice the size."""
    larger = 2.0**plan.integrator.order
    options = plan.options._replace(rtol=larger * plan.options.rtol, atol=larger * plan.options.atol)
    coarse = replace(plan, times=plan.times[_every_second(plan.times)])
    return _request(DOUBLE, coarse, options, 1, COARSE_SAFETY / (larger - 1.0))


def _every_second(times: np.ndarray) -> np.ndarray:
    """Return the places of every second output and the last."""
    return np.append(np.arange(0, len(times) - 1, 2), len(times) - 1)


def _shows_order(run: Run, coarse: Companion) -> bool:
    """Return whether a companion with steps of twice the size shows how errors depend on them."""
    is_visible = np.max(coarse.gaps[:, :2]) > VISIBLE * np.max(coarse.sizes[:2])
    is_doubled = _is_cut(coarse.run) and coarse.run.counts.steps <= DOUBLED * run.counts.steps + 0.5
    return coarse.run.status in ENDED and is_doubled and not is_visible


def _by_observed_order(system: System, plan: Plan, own: RunWithPoses, half: _Comparison) -> Asking[_Comparison]:
    """Return the comparison with the run with half of the step, its factor by the order that further runs show."""
    run, (request, finer, gaps, sizes, _) = own.run, half.other
    nominal, floor = _error_ratio(system, plan), NOISY * _roundoff(finer)
    double = yield from _compared(plan, own, _coarser(plan))
    if double.status is Status.INTERRUPTED:
        return half._replace(status=double.status)
    shown = _shrinkage(double.other.gaps, gaps, floor)
    is_coarser = double.has_ended and double.other.run.counts.steps < MIN_COARSENING * run.counts.steps
    fastest = np.max(shown[double.other.gaps[: len(shown)] > floor], initial=0.0)
    if not is_coarser or np.min(shown) < math.sqrt(nominal) or fastest > 4.0**plan.integrator.order:
        quarter = _rerun(system, request.plan, run.states[0], run.times, 4)
        if quarter.status is Status.INTERRUPTED:
            return half._replace(status=quarter.status)
        later, _ = _distance(system, finer.times, system.poses(finer.states), quarter.states)
        shown = _shrinkage(gaps, later, floor)
        gaps = np.fmax(gaps[: len(later)], later[: len(gaps)])
    shown = np.minimum(shown, nominal)
    factor = _richardson(np.fmax(shown, 1.0 + EPS))
    bounds, count = half.bounds.copy(), len(shown)
    bounds[:count] = np.fmax(bounds[:count], np.fmin(factor * np.maximum.accumulate(gaps[:count]), 2.0 * sizes))
    if np.min(shown) > math.sqrt(nominal):
        return half._replace(is_confirmed=True)
    how = f"{half.how}, by more where halved steps change it by {np.min(shown):.2g} times less, not {nominal:.2g} times"
    return half._replace(bounds=bounds, how=how)


def _is_confirmed(system: System, plan: Plan, first: _Comparison) -> Asking[bool]:
    """Return whether further runs show that errors decrease: for a tolerance, one that is tighter by as much again."""
    if plan.options.step or first.other.request.is_coarse or not first.has_ended:
        return first.is_confirmed
    begun, finer, gaps, *_ = first.other
    ratio = plan.options.rtol / begun.plan.options.rtol
    request = _tighter(plan, ratio**2)
    if ratio <= 1.0 or ratio * request.plan.options.rtol > 0.5 * plan.options.rtol:
        return False
    third = yield request
    later, _ = _distance(system, finer.times, system.poses(finer.states), third.run.states)
    return bool(np.min(_shrinkage(gaps, later, NOISY * _roundoff(finer))) > math.sqrt(ratio))


def _shrinkage(before: np.ndarray, after: np.ndarray, floor: float) -> np.ndarray:
    """Return how many times smaller differences (n, 4) become, as far as both reach; infinite where they are noise."""
    count = min(len(before), len(after))
    first, second = (np.maximum.accumulate(gaps[:count]) for gaps in (before, after))
    return np.divide(first, second, out=np.full_like(first, np.inf), where=second > floor)


def _request(share: str, plan: Plan, options: Options, refine: int, factor: float) -> Request:
    return Request(share, replace(plan, options=options._replace(stop_on_compliance=False)), refine, factor)


def _first_two(system: System, plan: Plan, run: Run) -> tuple[Request, Request, bool]:
    """Return the first companion of a run, the second, and whether both are needed in any case.

    The tighter one is the first if an adaptive run projected its stages close to a singular pose.
    """
    first, second = _first(system, plan), _tighter(plan, DECADE**2 * _tolerance_ratio(plan), 2 * _tolerance_ratio(plan))
    is_near_singular = run.near_singular and not plan.options.step
    if second.plan.options.rtol >= first.plan.options.rtol:
        return first, second, is_near_singular
    second = second._replace(factor=first.factor)
    return (second, first, False) if is_near_singular else (first, second, False)


def _first(system: System, plan: Plan) -> Request:
    if not plan.options.step:
        return _tighter(plan, _tolerance_ratio(plan))
    options = plan.options._replace(max_steps=2 * plan.options.max_steps)
    return _request("half of the step", plan, options, 2, float(_richardson(_error_ratio(system, plan))))


def _error_ratio(system: System, plan: Plan) -> float:
    """Return how many times smaller errors are at half of a fixed step."""
    return 2.0 ** (1 if touching(system.scene) or system.scene.events else plan.integrator.order)


def _tighter(plan: Plan, factor: float, least: float = DECADE) -> Request:
    """Request a tolerance tighter by a factor, or the coarser one if roundoff forbids one tighter by the `least`."""
    options = plan.options
    if options.rtol / least < TIGHTEST:
        return _coarser(plan)
    smaller = min(factor, options.rtol / TIGHTEST)
    tight = options._replace(
        rtol=options.rtol / smaller, atol=options.atol / smaller, max_steps=MORE_STEPS * options.max_steps
    )
    return _request(f"1/{smaller:g} of the tolerance", plan, tight, 2, _richardson(smaller))


def _coarser(plan: Plan) -> Request:
    options = plan.options
    if options.step:
        return _request("twice the step", plan, options._replace(step=2.0 * options.step), 1, SAFETY)
    loose = options._replace(rtol=DECADE * options.rtol, atol=DECADE * options.atol)
    return _request(f"{DECADE:g} times the tolerance", plan, loose, 1, SAFETY)


def _by_another_method(plan: Plan) -> Request:
    """Request a method that fails elsewhere; SAFETY covers errors of the same size."""
    method = DEFAULT if plan.integrator.name != DEFAULT else SECOND_METHOD
    other = replace(plan, integrator=integrators()[method])
    return _request(f"{method} instead of {plan.integrator.name}", other, _adaptive(plan), 1, SAFETY)


def _adaptive(plan: Plan) -> Options:
    """Return options of a method with error control: the run's tolerances, or the default ones in place of a step."""
    options = plan.options._replace(project=True, step=0.0)
    if not plan.options.step:
        return options
    return options._replace(rtol=DEFAULT_TOLERANCE, atol=DEFAULT_TOLERANCE * ABSOLUTE * plan.options.units)


def _richardson[T: (float, np.ndarray)](smaller: T) -> T:
    return SAFETY * smaller / (smaller - 1.0)


def _compared(plan: Plan, own: RunWithPoses, request: Request) -> Asking[_Comparison]:
    """Compare the run with a companion."""
    other = yield request
    _, second, gaps, _, bounds = other
    ended = second.status in ENDED
    tighter = ended and request.plan.options.rtol < plan.options.rtol
    is_alike = tighter and bool(second.counts.steps <= own.run.counts.steps)
    negligible = tighter and bool(np.max(gaps) < MIN_TOLERANCE_RATIO * plan.options.rtol)
    how = f"{request.factor:.3g} times the difference from a run with {request.share}"
    how += "" if ended else f", which did not end: {second.message}"
    return _Comparison(bounds, other, second.status, how, is_alike, is_alike or negligible)


def _distance(system: System, times: np.ndarray, path: Poses, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of runs (..., n, 4) over their common outputs, and how far they go at most (..., 4).

    `path` holds one run or several, (n_runs, n_t, ...), and `others` the states of their companions.
    """
    lead = others.shape[:-2]
    count = min(len(times), others.shape[-2])
    common = (slice(None),) * len(lead) + (slice(count),)
    poses = system.poses(others[common].reshape(-1, others.shape[-1]))
    first = Poses(*(part[common] for part in path))
    gaps = _gaps(system, first, Poses(*(part.reshape(*lead, count, *part.shape[1:]) for part in poses)))
    further = np.max(gaps, axis=-2, where=np.isfinite(gaps), initial=0.0)
    return gaps, motion_size(system.scene, system.scales, first, times[:count]) + further


def _gaps(system: System, first: Poses, second: Poses) -> np.ndarray:
    """Return distances (..., n, 4), infinite where not finite; orientations of particles count as 0."""
    gaps = relative(system.scene, first, second, np.inf, system.scales)
    return np.where(np.isnan(gaps), 0.0, gaps)


def _off_constraints(system: System, plan: Plan, own: RunWithPoses) -> np.ndarray:
    """Return the distance (n_t, 4) of the outputs from the nearest poses and rates that satisfy the constraints."""
    run = own.run
    if system.keeps_itself or (plan.options.project and np.max(run.compliance) <= plan.options.projection_tolerance):
        return np.zeros((len(run.times), 4))
    other, near = system.beside(), run.states.copy()
    for t, y in zip(run.times, near, strict=True):
        other.set_mode_time(float(t))
        other.project(float(t), y, plan.options.projection_tolerance)
    return _gaps(system, own.poses, system.poses(near))


def _opening(system: System, plan: Plan, run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return the error of the FEWEST first fixed steps (4,) against DOP853, and how far these go (4,).

    A method that damps motions too fast for its step ends at the same place with half of the step.
    """
    grid = plan.options.step * np.arange(1, FEWEST + 1)
    times = np.union1d(run.times, grid[grid <= run.times[-1]])[: FEWEST + 1]  # outputs end steps, too
    again = replace(plan, options=plan.options._replace(stop_on_compliance=False))
    options = _adaptive(again)._replace(max_steps=int(run.counts.rhs_calls))
    fine = replace(plan, integrator=integrators()[DEFAULT], options=options, baumgarte_gain=0.0)
    first, second = (_rerun(system, one, run.states[0], times) for one in (again, fine))
    gaps, sizes = _distance(system, times, system.poses(first.states), second.states)
    return np.max(gaps, axis=0), sizes


def _rerun(system: System, plan: Plan, start: np.ndarray, times: np.ndarray, refine: int = 1) -> Run:
    """Run a plan over other output times, on a system of its own."""
    other, y = system.beside(), start.copy()
    start_run(other, plan, y)
    return run_legs(other, replace(plan, times=times), y, refine)
