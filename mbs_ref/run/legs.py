"""Run a plan leg by leg, a leg ending at a declared breakpoint, and say in a sentence how it ended."""

from __future__ import annotations

import itertools
import time
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.integrators.loop.leg import FEWEST, Leg, Options, Progress, progress
from mbs_ref.run.diagnosis import culprit, deeper_cause
from mbs_ref.run.interrupts import Interrupts
from mbs_ref.run.plan import ON_GRID, Plan
from mbs_ref.trajectory import Status

EPS = float(np.finfo(float).eps)


class Counts(NamedTuple):
    """Work done in a run."""

    steps: int
    rejected_steps: int
    cut_steps: int  # which ended at an output before accuracy asked for it
    rhs_calls: int
    events: int
    switches: int  # between a method's families


class Run(NamedTuple):
    """What a run of all legs left: samples up to the last time or the first trouble."""

    times: np.ndarray  # (n_t,) s
    states: np.ndarray  # (n_t, n_state)
    compliance: np.ndarray  # (n_t,) m, the largest since the sample before
    counts: Counts
    status: Status
    message: str
    loop_s: float  # in the integrator
    carried_share: float  # of the time reached, passed by DOP853 in place of a multistep method


class LegPlan(NamedTuple):
    """One leg: between two declared breakpoints nothing that is known in advance is non-smooth."""

    times: np.ndarray  # (n,) s, its start and end among them
    asked: np.ndarray  # places of the asked output times in `times`
    options: Options


def run_legs(system: System, plan: Plan, y: np.ndarray, refine: int = 1) -> Run:
    """Integrate up to the last time or the first trouble; say what went wrong, where, and what is still good.

    `refine` makes that many steps of each. `y` (n_state,) is left where the run ended.
    """
    planned = planned_legs(system, plan, refine)
    run = progress(0.0)
    with Interrupts(run, plan.options.max_steps) as interrupts:
        began = time.perf_counter()
        legs = _advanced(system, plan, planned, run, y)
        loop_s = time.perf_counter() - began
    states, compliance = _samples(planned, legs)
    counts = Counts(interrupts.steps, *map(int, (run.rejected, run.cut, run.rhs_calls, run.events, run.switches)))
    times, stuck = plan.times[: len(states)], float(run.t)
    status, message = _outcome(system, plan, legs[-1], run, y, interrupts.asked)
    if status is Status.STOP_EVENT:
        times, states, compliance = np.append(times, stuck), np.vstack((states, y)), np.append(compliance, 0.0)
    elif status is not Status.SUCCESS:
        message += f"; the last good output is at t = {times[-1]:.9g} s"
    carried_s = sum(leg.carried_s for leg in legs)
    share = carried_s / stuck if carried_s else 0.0
    return Run(times, states, compliance, counts, status, message, loop_s, share)


def finite_part(system: System, run: Run) -> Run:
    """Return the run up to its last finite output: one that holds an infinite or NaN number has failed there."""
    with np.errstate(all="ignore"):
        bad = [~np.isfinite(values).reshape(len(run.times), -1).all(axis=1) for values in system.poses(run.states)]
    places = np.flatnonzero(np.any(bad, axis=0))
    if not len(places):
        return run
    good = int(places[0])
    message = f"the output at t = {run.times[good]:.9g} s holds an infinite number or NaN"
    return run._replace(times=run.times[:good], states=run.states[:good], compliance=run.compliance[:good],
                        status=Status.NON_FINITE, message=message)  # fmt: skip


def planned_legs(system: System, plan: Plan, refine: int) -> list[LegPlan]:
    """Divide the run at the declared breakpoints."""
    times = plan.times
    inner = [t for t in system.scene.breakpoints() if 0.0 < t < times[-1]]
    return [
        _leg(plan.options, times, start, end, end - start if inner else np.inf, refine)
        for start, end in itertools.pairwise([0.0, *inner, float(times[-1])])
    ]


def _leg(options: Options, times: np.ndarray, start: float, end: float, length: float, refine: int) -> LegPlan:
    """Return the leg from start to end (s), of FEWEST steps at least over `length` (s), each divided by `refine`.

    Adaptive steps are their own choice, but may end at outputs: there the way between two of them is divided.
    """
    inside = times[(times > start) & (times <= end)]
    own = np.unique(np.concatenate(([start], inside, [end])))
    if options.step:
        options = options._replace(step=min(options.step, length / FEWEST) / refine)
    if refine > 1 and not options.dense:
        own = _refined(own, refine * options.step or np.inf, refine)
    return LegPlan(own, np.searchsorted(own, inside), options)


def _refined(times: np.ndarray, step: float, refine: int) -> np.ndarray:
    """Divide the intervals that are shorter than the step (s): outputs cut it there, and would cut its parts alike."""
    gaps = np.diff(times)
    short = np.flatnonzero(gaps < step * (1.0 - ON_GRID))
    parts = [times[short] + gaps[short] * k / refine for k in range(1, refine)]
    return np.unique(np.concatenate((times, *parts)))


def _advanced(system: System, plan: Plan, planned: list[LegPlan], run: Progress, y: np.ndarray) -> list[Leg]:
    """Integrate leg by leg, up to the first that does not reach its end."""
    legs: list[Leg] = []
    for leg in planned:
        system.set_mode_time(0.5 * (leg.times[0] + leg.times[-1]))
        run.t, run.h = leg.times[0], 0.0
        legs.append(plan.integrator.advance(system, leg.options, run, y, leg.times))
        if legs[-1].status is not Status.SUCCESS:
            break
        y[:] = legs[-1].states[-1]
    return legs


def _samples(planned: list[LegPlan], legs: list[Leg]) -> tuple[np.ndarray, np.ndarray]:
    """Return the states at the asked times that were reached, and the compliance (m) of the steps up to each."""
    states, compliance, carried = [legs[0].states[:1]], [np.zeros(1)], 0.0
    for plan, leg in zip(planned, legs, strict=False):
        kept = plan.asked[plan.asked < leg.reached]
        largest, carried = _largest_between(leg.compliance[: leg.reached], kept, carried)
        states.append(leg.states[kept])
        compliance.append(largest)
    return np.concatenate(states), np.concatenate(compliance)


def _largest_between(compliance: np.ndarray, kept: np.ndarray, carried: float) -> tuple[np.ndarray, float]:
    """Return the largest compliance (m) since the sample before, for each kept one, and what is left for the next leg.

    `carried` (m) is what the leg before left.
    """
    last = kept[-1] if len(kept) else 0
    left = np.fmax.reduce(compliance[last + 1 :], initial=0.0)
    if not len(kept):
        return np.zeros(0), max(carried, left)
    largest = np.fmax.reduceat(compliance[: last + 1], np.append(1, kept[:-1] + 1))
    largest[0] = np.fmax(largest[0], carried)
    return largest, left


def reached(plan: Plan) -> str:
    """Return the sentence for a run that reached its end."""
    return f"reached t = {plan.times[-1]:g} s"


def _outcome(
    system: System, plan: Plan, last: Leg, run: Progress, y: np.ndarray, interrupted: bool
) -> tuple[Status, str]:
    """Return how the run ended and the sentence for it, with the part or the cause where one is known."""
    stuck = float(run.t)
    if system.user_error is not None:
        return Status.ENGINE_ERROR, f"a user's function raised {system.user_error!r}"
    if interrupted and last.status is Status.TOO_MANY_STEPS:
        return Status.INTERRUPTED, f"interrupted at t = {stuck:.9g} s"
    if last.status is Status.SUCCESS:
        return Status.SUCCESS, last.message or reached(plan)
    if last.status is Status.ENDLESS_EVENTS:
        return last.status, f"{last.message}; {system.event_sources[run.event_source]!r} was the last"
    if last.status is Status.STOP_EVENT:
        return last.status, f"{last.message}: {system.event_sources[run.event_source]!r}"
    if last.status is Status.SINGULAR and plan.options.rtol < EPS:
        asked = f"rtol = {plan.options.rtol:.3g} asks for more than roundoff leaves"
        return Status.STEP_TOO_SMALL, f"at t = {stuck:.9g} s {asked}"
    return last.status, last.message + culprit(system, stuck, y) + deeper_cause(system, last.status, stuck, y)
