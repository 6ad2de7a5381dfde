"""How far may a run be off? A companion run that errs less tells, as Richardson (1911) and Roache (1994) have it.

The companion takes half of a fixed step, or a tenth of the tolerances. If its errors are k times smaller, the two runs
differ by d = e (1 - 1/k), and the run errs by e = d k / (k - 1) (Hairer, Norsett, Wanner I, eq. II.4.4): k = 2^p at
order p, 2 where impacts and kinks leave order 1, and 10 if errors are in proportion to the tolerance (ibid., sec.
II.4). To d is added what rounding does to the companion, which no refinement takes from it. Two runs cannot show that
they converge as they should, so SAFETY times that is said. Errors vanish by chance alone, so the estimate never falls
in time.

That proportion holds at one order. Where a method chooses its order, too, the companion's tolerance is two decades
tighter, and no less than it is said. Where a step may err more than the tolerance, it is tighter by as much again. How
far the run is off the constraints is measured: the companion may share it.

A companion that takes no more steps, or hardly differs, shows that the tolerance does not govern the steps that err
most: another is made, tighter by two decades more. Where the finer companion does not end, a coarser one is made: its
errors are the larger ones, and d is their size. Where this does not end either, one by another method is made.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.loop.leg import FEWEST, Options
from mbs_ref.observables.distance import coordinate_size, motion_size, relative
from mbs_ref.run.legs import EPS, Run, run_legs
from mbs_ref.run.plan import ABSOLUTE, DEFAULT_TOLERANCE, Plan
from mbs_ref.trajectory import Estimate, Status

SAFETY = 3.0  # for two runs (P. J. Roache, J. Fluids Eng. 116 (1994) 405: the grid convergence index)
DECADE = 10.0  # between the tolerances of the two
TIGHTEST = 1e-13  # relative tolerance of a companion: some hundred EPS, beyond which roundoff decides
LEAST = 1e-3  # of the tolerance: less than a step errs that it governs
MORE_STEPS = 4  # times those allowed for a finer companion: the square root of ten at order 2, rounded up
OTHER = "lsodar"  # where the default method is the one that fails
ENDED = frozenset({Status.SUCCESS, Status.STOP_EVENT})


class _Seen(NamedTuple):
    """A run and its poses at the outputs."""

    run: Run
    path: Poses


class Beside(NamedTuple):
    """A companion that has been made, and how far it is from its run."""

    run: Run
    gaps: np.ndarray  # (n, 4) at the outputs that both reached
    sizes: np.ndarray  # (4,), how far the two go


class _Companion(NamedTuple):
    """A run to compare with."""

    share: str  # of the run's step or tolerance
    options: Options
    refine: int  # parts of each step
    factor: float  # the estimate over the difference of the two
    method: str | None = None  # another than the run's


class _Compared(NamedTuple):
    """What a companion says."""

    bounds: np.ndarray  # (n, 4), the estimate at the outputs that both reached
    sizes: np.ndarray  # (4,), how far the two go
    is_alike: bool  # no more steps, though its tolerance is the tighter one
    is_vain: bool  # no more steps or hardly a difference, though its tolerance is the tighter one
    status: Status
    how: str

    @property
    def has_ended(self) -> bool:
        return self.status in ENDED


def companion_plan(system: System, plan: Plan) -> tuple[Plan, int]:
    """Return the plan of the companion that is made first, and of how many parts its steps are: see `run_legs`."""
    first = _first(system, plan)
    return replace(plan, options=first.options._replace(stop_on_compliance=False)), first.refine


def all_beside(system: System, paths: list[Poses], runs: list[Run], companions: list[Run]) -> list[Beside]:
    """Return the first companions of some runs, whose poses are known, held against them: of one length at once."""
    found: dict[int, Beside] = {}
    lengths = [(len(run.times), len(other.times)) for run, other in zip(runs, companions, strict=True)]
    for length in set(lengths):
        places = [k for k, own in enumerate(lengths) if own == length]
        first = Poses(*(np.stack(parts) for parts in zip(*(paths[k] for k in places), strict=True)))
        gaps, sizes = _apart(system, runs[places[0]].times, first, np.stack([companions[k].states for k in places]))
        found |= {k: Beside(companions[k], gaps[place], sizes[place]) for place, k in enumerate(places)}
    return [found[k] for k in range(len(runs))]


def estimated(
    system: System, plan: Plan, run: Run, path: Poses | None = None, companion: Beside | None = None
) -> Estimate | None:
    """Estimate the error of a run at its output times; None where Ctrl-C ended a companion.

    `path` is what the run's states say, and `companion` the first one by `companion_plan`, where they are known.
    """
    began, scales, seen = time.perf_counter(), system.scales, _Seen(run, path or system.poses(run.states))
    found = _all_compared(system, plan, seen, companion)
    if any(one.status is Status.INTERRUPTED for one in found):
        return None
    opening, went = _opening(system, plan, run) if plan.options.step else (np.zeros(4), np.zeros(4))
    reached = max(len(one.bounds) for one in found)
    scale = coordinate_size(scales, seen.path.position)
    least = np.fmax(SAFETY * opening, _least(plan, run, found) * scale)
    bounds = SAFETY * _off_constraints(system, plan, seen) + least
    for one in found:
        count = len(one.bounds)
        bounds[:count] = np.fmax(bounds[:count], one.bounds)
    bounds[0], bounds[reached:] = 0.0, np.inf
    return Estimate(
        times=run.times, components=np.maximum.accumulate(bounds), how="; ".join(one.how for one in found),
        size=float(np.max([sizes[:2] for sizes in (went, *(one.sizes for one in found))])),
        tolerance=(plan.settings.rtol or DEFAULT_TOLERANCE) * scale, cost_s=time.perf_counter() - began,
        length=scales.length, time=scales.time,
    )  # fmt: skip


def _least(plan: Plan, run: Run, found: list[_Compared]) -> float:
    """Return what a run errs at least, relative.

    Where no tolerance matters it is what a step may err at the tightest.
    """
    roundoff = SAFETY * _roundoff(run)
    if plan.integrator.varies_order:
        return roundoff + plan.options.rtol / _decades(plan)
    return roundoff + (plan.options.rtol * LEAST if all(one.is_alike for one in found) else 0.0)


def _roundoff(run: Run) -> float:
    """Return what rounding does to coordinates, relative: a random walk (D. Brouwer, Astron. J. 46 (1937) 149)."""
    return EPS * math.sqrt(run.counts.steps)


def _decades(plan: Plan) -> float:
    """Return by how much the companion's tolerance is tighter."""
    return DECADE**2 if plan.integrator.varies_order else DECADE * plan.integrator.slack


def _all_compared(system: System, plan: Plan, seen: _Seen, made: Beside | None) -> list[_Compared]:
    """Return what the companions say that are needed: one as a rule, which may be made already."""
    found = [_compared(system, plan, seen, _first(system, plan), made)]
    if found[0].is_vain:
        found.append(_compared(system, plan, seen, _tighter(plan, DECADE**2 * _decades(plan))))
    if not found[-1].has_ended and found[-1].status is not Status.INTERRUPTED:
        found.append(_compared(system, plan, seen, _coarser(plan)))
        if not any(one.has_ended or one.status is Status.INTERRUPTED for one in found):
            found.append(_compared(system, plan, seen, _otherwise(plan)))
    return found


def _first(system: System, plan: Plan) -> _Companion:
    return _half(system, plan) if plan.options.step else _tighter(plan, _decades(plan))


def _half(system: System, plan: Plan) -> _Companion:
    order = 1 if system.scene.contacts or system.scene.events else plan.integrator.order
    options = plan.options._replace(max_steps=2 * plan.options.max_steps)
    return _Companion("half of the step", options, 2, _richardson(2.0**order))


def _tighter(plan: Plan, factor: float) -> _Companion:
    """Return a companion with a tolerance so many times tighter, or the coarser one where roundoff leaves none."""
    options = plan.options
    if options.rtol / DECADE < TIGHTEST:
        return _coarser(plan)
    smaller = min(factor, options.rtol / TIGHTEST)
    tight = options._replace(
        rtol=options.rtol / smaller, atol=options.atol / smaller, max_steps=MORE_STEPS * options.max_steps
    )
    return _Companion(f"1/{smaller:g} of the tolerance", tight, 2, _richardson(smaller))


def _coarser(plan: Plan) -> _Companion:
    options = plan.options
    if options.step:
        return _Companion("twice the step", options._replace(step=2.0 * options.step), 1, SAFETY)
    loose = options._replace(rtol=DECADE * options.rtol, atol=DECADE * options.atol)
    return _Companion(f"{DECADE:g} times the tolerance", loose, 1, SAFETY)


def _otherwise(plan: Plan) -> _Companion:
    """Return a companion by another method, which fails elsewhere; SAFETY covers errors of the same size."""
    method = DEFAULT if plan.integrator.name != DEFAULT else OTHER
    return _Companion(f"{method} instead of {plan.integrator.name}", _adaptive(plan), 1, SAFETY, method)


def _adaptive(plan: Plan) -> Options:
    """Return options of a method with error control: the run's tolerances, or the default ones in place of a step."""
    options = plan.options._replace(project=True, step=0.0)
    if not plan.options.step:
        return options
    return options._replace(rtol=DEFAULT_TOLERANCE, atol=DEFAULT_TOLERANCE * ABSOLUTE * plan.options.units)


def _richardson(smaller: float) -> float:
    return SAFETY * smaller / (smaller - 1.0)


def _compared(system: System, plan: Plan, seen: _Seen, companion: _Companion, made: Beside | None = None) -> _Compared:
    """Make the companion, unless it has been made, and hold the run against it."""
    run, scales = seen.run, system.scales
    own = replace(plan, options=companion.options, integrator=integrators()[companion.method or plan.integrator.name])
    made = made or _beside(system, seen, _made(system, own, run.states[0], run.times, companion.refine))
    other, gaps, sizes = made
    # what rounding does to rates moves bodies by the same share of the way that they go
    way = np.fmax(1.0, np.max(sizes[2:]) * run.times[: len(gaps), None] / scales.time)
    apart = companion.factor * (gaps + _roundoff(other) * way)
    ended = other.status in ENDED
    tighter = companion.options.rtol < plan.options.rtol
    is_alike = ended and tighter and bool(other.counts.steps <= run.counts.steps)
    return _Compared(
        # places no further than so far from the start are no further than twice that from each other
        bounds=np.fmax(gaps, np.minimum(apart, 2.0 * sizes)), sizes=sizes,
        is_alike=is_alike, status=other.status,
        is_vain=is_alike or (ended and tighter and bool(np.max(gaps) < LEAST * plan.options.rtol)),
        how=f"{companion.factor:.3g} times the difference from a run with {companion.share}"
            + ("" if ended else f", which did not end: {other.message}"),
    )  # fmt: skip


def _beside(system: System, seen: _Seen, other: Run) -> Beside:
    return Beside(other, *_apart(system, seen.run.times, seen.path, other.states))


def _apart(system: System, times: np.ndarray, path: Poses, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far runs are apart (..., n, 4) where both are, and how far they go (..., 4).

    `path` is of one run or of several, (n_runs, n_t, ...), and `others` are the states of what each is held against.
    """
    lead = others.shape[:-2]
    count = min(len(times), others.shape[-2])
    here = (slice(None),) * len(lead) + (slice(count),)
    told = system.poses(others[here].reshape(-1, others.shape[-1]))
    first = Poses(*(part[here] for part in path))
    second = Poses(*(part.reshape(*lead, count, *part.shape[1:]) for part in told))
    sizes = [motion_size(system.scene, system.scales, one, times[:count]) for one in (first, second)]
    return _gaps(system, first, second), np.maximum(*sizes)


def _gaps(system: System, first: Poses, second: Poses) -> np.ndarray:
    """Return how far runs are apart (..., n, 4), infinite where not finite; particles' orientations add nothing."""
    gaps = relative(system.scene, first, second, np.inf, system.scales)
    return np.where(np.isnan(gaps), 0.0, gaps)


def _off_constraints(system: System, plan: Plan, seen: _Seen) -> np.ndarray:
    """Return how far the outputs are from the nearest poses and rates that keep the constraints (n_t, 4)."""
    run = seen.run
    if system.keeps_itself:
        return np.zeros((len(run.times), 4))
    other, near = system.beside(), run.states.copy()
    for t, y in zip(run.times, near, strict=True):
        other.set_mode_time(float(t))
        other.project(float(t), y, plan.options.projection_tolerance)
    return _gaps(system, seen.path, system.poses(near))


def _opening(system: System, plan: Plan, run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much the FEWEST first fixed steps are off (4,), and how far these go (4,), by DOP853's account.

    A method that damps what its steps cannot follow lands where half of the step lands, too.
    """
    grid = plan.options.step * np.arange(1, FEWEST + 1)
    times = np.union1d(run.times, grid[grid <= run.times[-1]])[: FEWEST + 1]  # outputs end steps, too
    options = _adaptive(plan)._replace(max_steps=int(run.counts.rhs_calls))
    fine = replace(plan, integrator=integrators()[DEFAULT], options=options, baumgarte_gain=0.0)
    first, second = (_made(system, one, run.states[0], times) for one in (plan, fine))
    gaps, sizes = _apart(system, times, system.poses(first.states), second.states)
    return np.max(gaps, axis=0), sizes


def _made(system: System, plan: Plan, start: np.ndarray, times: np.ndarray, refine: int = 1) -> Run:
    """Run a plan up to other times, on a system of its own."""
    other, y = system.beside(), start.copy()
    other.set_mode_time(0.0)
    other.set_baumgarte(plan.baumgarte_gain)
    other.start_contacts(0.0, y, plan.settings.events != "none")
    again = replace(plan, times=times, options=plan.options._replace(stop_on_compliance=False))
    return run_legs(other, again, y, refine=refine)
