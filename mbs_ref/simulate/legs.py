"""Integrate a plan leg by leg, a leg ending at a declared breakpoint, and report how the run ended."""

import itertools
import os
import signal
import threading
import time
from functools import cache
from types import FrameType
from typing import Any, NamedTuple, Self

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators.loop.leg import FEWEST, Figures, Leg, Options, Progress, figures_of, progress
from mbs_ref.simulate.diagnosis import culprit, deeper_cause
from mbs_ref.simulate.plan import ON_GRID, Plan
from mbs_ref.trajectory import Status

EPS = float(np.finfo(float).eps)
READ = b"\0"  # no signal's number
GOLDEN = 0.5 * (3.0 - 5.0**0.5)  # of an interval: the golden section


class Interrupts:
    """While entered, the first SIGINT sets the step count to `max_steps`, so that the run ends after its next step.

    Python receives the signal once compiled code has returned, in a large scene after minutes; a thread that waits for
    its number does at once. A second SIGINT raises KeyboardInterrupt. In other threads than the main one, and where
    another handler is installed, nothing changes.
    """

    def __init__(self, run: Progress, max_steps: int) -> None:
        self.received = self._signalled = False
        self._run, self._max_steps, self._steps_before = run, max_steps, 0
        self._previous: Any = None
        self._descriptor = -1

    @property
    def steps(self) -> int:
        """The number of steps without the artificial increase."""
        count = int(self._run.steps)
        return self._steps_before + count - self._max_steps if self.received else count

    def __enter__(self) -> Self:
        in_main_thread = threading.current_thread() is threading.main_thread()
        if in_main_thread and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self._previous = signal.signal(signal.SIGINT, self._receive)
            waiting = _waiting_thread()
            waiting.entered.append(self)
            self._descriptor = signal.set_wakeup_fd(waiting.target, warn_on_full_buffer=False)
        return self

    def __exit__(self, *_: object) -> None:
        if self._previous is not None:
            signal.set_wakeup_fd(self._descriptor)
            waiting = _waiting_thread()
            waiting.entered.remove(self)
            signal.signal(signal.SIGINT, self._previous)
            if self._signalled:  # the next run is not to be stopped by a number that is read late
                os.write(waiting.target, READ)
                waiting.has_read.wait()
                waiting.has_read.clear()

    def _receive(self, _number: int, _frame: FrameType | None) -> None:
        self._signalled = True
        self.stop()
        signal.signal(signal.SIGINT, self._previous)

    def stop(self) -> None:
        """Set the step count."""
        if self._run.steps < self._max_steps:
            self.received, self._steps_before = True, int(self._run.steps)
            self._run.steps = self._max_steps


class _Waiting(NamedTuple):
    """A thread that waits for numbers of signals, for the whole life of the process."""

    target: int  # where Python is to write them, a file's descriptor
    entered: list[Interrupts]  # what SIGINT stops
    has_read: threading.Event  # set once READ, and so whatever was written before, is read


@cache
def _waiting_thread() -> _Waiting:
    """Start the thread."""
    source, target = os.pipe()
    os.set_blocking(target, False)
    waiting = _Waiting(target, [], threading.Event())

    def wait() -> None:
        while number := os.read(source, 1):
            if number == READ:
                waiting.has_read.set()
            for one in tuple(waiting.entered) if number[0] == signal.SIGINT else ():
                one.stop()

    threading.Thread(target=wait, daemon=True).start()
    return waiting


class Counts(NamedTuple):
    """Work of a run."""

    steps: int
    rejected_steps: int
    cut_steps: int  # shortened by an output time
    rhs_calls: int
    events: int
    switches: int  # between a method's families


class Run(NamedTuple):
    """The result of all legs: samples up to the last output time or the first failure."""

    times: np.ndarray  # (n_t,) s
    states: np.ndarray  # (n_t, n_state)
    compliance: np.ndarray  # (n_t,) m, the largest |C| since the sample before
    counts: Counts
    status: Status
    message: str
    loop_s: float  # s in the integrator
    carried_share: float  # of the simulated time, integrated by DOP853 in place of a multistep method
    near_singular: bool  # the method, or DOP853 in its place, projected stages close to a singular pose; else unknown


class LegPlan(NamedTuple):
    """One leg: between two declared breakpoints every signal is smooth."""

    times: np.ndarray  # (n,) s, its start and end among them
    outputs: np.ndarray  # indices of the output times in `times`
    options: Options


def start_run(system: System, plan: Plan, y: np.ndarray) -> None:
    """Prepare the system for a run from y at t = 0: stabilization and contact modes."""
    system.set_mode_time(0.0)
    system.set_baumgarte(plan.baumgarte_gain)
    if system.event_sources:
        system.start_contacts(0.0, y, plan.settings.events != "none")


def run_legs(system: System, plan: Plan, y: np.ndarray, refine: int = 1) -> Run:
    """Integrate up to the last output time or the first failure, which the message explains.

    `refine` divides each step into so many. `y` (n_state,) is overwritten by the state where the run ended.
    """
    planned = planned_legs(system, plan, refine)
    run = progress(0.0)
    with Interrupts(run, plan.options.max_steps) as interrupts:
        began = time.perf_counter()
        legs = _advanced(system, plan, planned, run, y)
        loop_s = time.perf_counter() - began
    states, compliance = samples(planned, legs)
    ended = figures_of(run)
    counts = Counts(interrupts.steps, ended.rejected, ended.cut, ended.rhs_calls, ended.events, ended.switches)
    times, stuck = plan.times[: len(states)], ended.t
    status, message = _outcome(system, plan, legs[-1], ended, y, interrupts.received)
    if status is Status.STOP_EVENT:
        times, states, compliance = np.append(times, stuck), np.vstack((states, y)), np.append(compliance, 0.0)
    elif status is not Status.SUCCESS:
        message += f"; the last good output is at t = {times[-1]:.9g} s"
    share = ended.carried / stuck if ended.carried else 0.0
    return Run(times, states, compliance, counts, status, message, loop_s, share, bool(ended.near_singular))


def finite_part(run: Run, poses: Poses) -> Run:
    """Return the run up to its last output of finite poses; an infinite number or NaN makes it `non-finite`."""
    if all(np.isfinite(values).all() for values in poses):
        return run
    bad = [~np.isfinite(values).reshape(len(run.times), -1).all(axis=1) for values in poses]
    good = int(np.flatnonzero(np.any(bad, axis=0))[0])
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
    """Return the leg from start to end (s), of at least FEWEST steps over `length` (s), each divided by `refine`.

    Adaptive steps cannot be divided, but they may end at outputs; the intervals between outputs are divided then, so
    unevenly that no period of the motion or of the outputs is met again.
    """
    inside = times[slice(*np.searchsorted(times, (start, end), side="right"))]
    own = np.concatenate(([start], inside, [] if end in inside[-1:] else [end]))
    if options.step:
        options = options._replace(step=min(options.step, length / FEWEST) / refine)
    if refine > 1 and not options.dense:
        shares = np.arange(1, refine) / refine if options.step else np.array([GOLDEN])
        own = _refined(own, refine * options.step or np.inf, shares)
    return LegPlan(own, np.searchsorted(own, inside), options)


def _refined(times: np.ndarray, step: float, shares: np.ndarray) -> np.ndarray:
    """Divide at these shares the output intervals that are shorter than the step (s), where outputs shorten steps."""
    gaps = np.diff(times)
    short = np.flatnonzero(gaps < step * (1.0 - ON_GRID))
    parts = [times[short] + gaps[short] * share for share in shares]
    return np.unique(np.concatenate((times, *parts)))


def _advanced(system: System, plan: Plan, planned: list[LegPlan], run: Progress, y: np.ndarray) -> list[Leg]:
    """Integrate leg by leg, up to the first that does not reach its end."""
    legs: list[Leg] = []
    for leg in planned:
        system.set_mode_time(0.5 * (leg.times[0] + leg.times[-1]))
        run["t"], run["h"] = leg.times[0], 0.0
        legs.append(plan.integrator.advance(system, leg.options, run, y, leg.times))
        if legs[-1].status is not Status.SUCCESS:
            break
        y[:] = legs[-1].states[-1]
    return legs


def samples(planned: list[LegPlan], legs: list[Leg]) -> tuple[np.ndarray, np.ndarray]:
    """Return the states at the output times that were reached, and the compliance (m) of the steps up to each."""
    states, compliance, carried = [legs[0].states[:1]], [np.zeros(1)], 0.0
    for plan, leg in zip(planned, legs, strict=False):
        reached = plan.outputs[plan.outputs < leg.reached]
        largest, carried = _largest_between(leg.compliance[: leg.reached], reached, carried)
        states.append(leg.states[reached])
        compliance.append(largest)
    return np.concatenate(states), np.concatenate(compliance)


def _largest_between(compliance: np.ndarray, outputs: np.ndarray, carried: float) -> tuple[np.ndarray, float]:
    """Return the largest compliance (m) since the previous output, for each output, and that after the last one.

    `carried` (m) is the largest one after the last output of the previous leg.
    """
    last = outputs[-1] if len(outputs) else 0
    after = np.fmax.reduce(compliance[last + 1 :], initial=0.0)
    if not len(outputs):
        return np.zeros(0), max(carried, after)
    largest = np.fmax.reduceat(compliance[: last + 1], np.append(1, outputs[:-1] + 1))
    largest[0] = np.fmax(largest[0], carried)
    return largest, after


def reached(plan: Plan) -> str:
    """Return the sentence for a run that reached its end."""
    return f"reached t = {plan.times[-1]:g} s"


def _outcome(
    system: System, plan: Plan, last: Leg, run: Figures, y: np.ndarray, interrupted: bool
) -> tuple[Status, str]:
    """Return the status and the message, with the part or the cause where one is known."""
    stuck = run.t
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
        return Status.STEP_TOO_SMALL, f"at t = {stuck:.9g} s: rtol = {plan.options.rtol:.3g} is below roundoff"
    known = f"; known of {plan.integrator.name}: {plan.integrator.weakness}" if plan.integrator.weakness else ""
    return last.status, last.message + culprit(system, stuck, y) + deeper_cause(system, last.status, stuck, y) + known
