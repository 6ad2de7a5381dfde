"""A leg in a multistep code of someone else's: where it is, what it has filled, and why it ends early."""

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbs_ref.cores.events import NOISE
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.crossing import is_near_singular, leap
from mbs_ref.integrators.loop.events import EVENT, H_NEXT, RETRY, event_tables, has_events, settle, watch
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

LOOK_EVERY = 2_000  # steps between looks at the pace
BEYOND = 0.2  # of the relative tolerance: what iterations leave of a state, and less than an error of a step
LAG = 1.0 / BEYOND  # of that: the tolerance, which the first steps after an event may err


Interpolant = Callable[[float], np.ndarray]  # state at a time (s)


def joined(
    between: Interpolant, rate: Interpolant, begin: tuple[float, np.ndarray, np.ndarray], end: float
) -> Interpolant:
    """Return an interpolant with the value and slope of `begin` (time, state, slope) where its step begins.

    That of a multistep code differs there by an error of the step: backward Euler's has the speed of the end from the
    start on. An event function would jump, and a contact just opened would close at once, thousands of times.
    """
    t0, y0, slope = begin
    step, missed, bend = end - t0, y0 - between(t0), slope - rate(t0)

    def join(t: float) -> np.ndarray:
        s = (t - t0) / step
        return between(t) + (1.0 - s) ** 2 * ((1.0 + 2.0 * s) * missed + s * step * bend)

    return join


def beyond_remainders(advance: leg.Advance) -> leg.Advance:
    """Return the driver of a leg that locates events as far beyond their roots as what its iterations leave.

    Only where constraints hold contacts. Those open without speed, and errors of the steps that follow would close them
    again, hundreds of times. They therefore close only beyond the tolerance, until the gap has once been as wide.
    """

    @wraps(advance)
    def beyond(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
        held = any(contact.holds for contact in system.scene.contacts)
        factor = 2.0 ** max(0.0, np.ceil(np.log2(BEYOND * options.rtol / NOISE))) if held else 1.0  # divides exactly
        system.spread_events(factor, LAG if held else 0.0)
        try:
            return advance(system, options, run, y, times)
        finally:
            system.spread_events(1.0 / factor)

    return beyond


class Ending(NamedTuple):
    """Why a leg ends before its last time."""

    status: Status
    message: str


class ContactEvents:
    """Watches the event functions of a system along the steps of a multistep code."""

    def __init__(self, system: "System", options: leg.Options, run: leg.Progress) -> None:
        self.system, self.most, self.run = system, options.max_events, run
        self.search, self.table = event_tables(system.model)
        self.watched, self.at_event = bool(has_events(self.table)), False
        self.slope: np.ndarray | None = None  # dy/dt where the last step ended, if the code goes on from there

    def settle(self, t: float, y: np.ndarray) -> int:
        """Change modes, and y at impacts, until all hold; return RUNNING, STOP_EVENT or ENDLESS_EVENTS."""
        if not self.watched:
            return leg.RUNNING
        return settle(self.system.model, self.system.work, t, y, self.table, self.run, self.most)

    def locate(
        self, before: float, then: np.ndarray, solver: Any, slope: np.ndarray | None = None
    ) -> tuple[float, np.ndarray]:
        """Return where a step from (before, then) ends: at its end, or just past its first event (then `at_event`).

        `slope` is dy/dt at its end, if the code knows it.
        """
        self.at_event = False
        if not self.watched:
            return solver.t, solver.y
        interpolant, start, t, y = None, before, solver.t, solver.y
        model, work, slopes = self.system.model, self.system.work, np.empty((2, len(then)))
        begin, is_known = np.ascontiguousarray(then), self.slope is not None
        slopes[0] = 0.0 if self.slope is None else self.slope
        while True:
            ends = step_ends(begin, slopes[0], np.ascontiguousarray(y), slopes[1])
            ends.known[:] = is_known, slope is not None and t >= solver.t
            if ends.known[1]:
                slopes[1] = slope
            verdict = watch(model, work, start, t - start, ends, self.run, self.search, self.table)
            self.at_event = verdict == EVENT
            if self.at_event or (verdict != RETRY and t >= solver.t):
                self.slope = slopes[1] if ends.known[1] and not self.at_event else None
                return t, np.ascontiguousarray(y)
            is_known = ends.known[0]
            if verdict == RETRY:
                t = start + self.search[H_NEXT]
            else:  # a look inside the step has shown nothing: go on to its end
                start, begin, t, is_known = t, ends.y_new, solver.t, ends.known[1]
                slopes[0] = slopes[1]
            interpolant = interpolant or solver.dense_output()
            y = solver.y if t >= solver.t else interpolant(t)


class MultistepLeg:
    """A leg under way."""

    def __init__(
        self, system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray
    ) -> None:
        self.system, self.options, self.run, self.y, self.times = system, options, run, y, times
        self.states, self.worst = np.empty((len(times), len(y))), np.zeros(len(times))
        self.states[0] = y
        self.t, self.now, self.reached = float(times[0]), y.copy(), 1  # s, state, outputs filled
        self.longest = float(times[-1] - times[0]) / leg.FEWEST  # s, step
        run.span = times[-1] - times[0]
        self.events = ContactEvents(system, options, run)
        self.loops = system.n_closure_rows > 0
        self.drift = 0.0  # |C| at the last step, over the scene's length
        self.pace = leg.Pace(self.t, float(times[-1]), options.max_steps, LOOK_EVERY)
        self.ending: Ending | None = None
        self._settle()

    def goes_on(self) -> bool:
        return self.ending is None and self.reached < len(self.times)

    def stop(self, status: Status, words: str) -> None:
        self.ending = Ending(status, f"at t = {self.t:.9g} s {words}")

    def arrive(self, t: float, now: np.ndarray, step: float) -> bool:
        """Count a step (s) that ended at (t, now), and watch |C| there; return whether the leg goes on."""
        run, self.t, self.now = self.run, t, now
        run.steps += 1
        gap, _ = self.system.compliance(t, now)
        run.compliance, self.drift = max(run.compliance, gap), gap / float(self.options.units[0])
        if self.options.stop_on_compliance and gap >= step:
            self.stop(Status.COMPLIANCE, f"|C| = {gap:.3g} is not below h = {step:.3g}")
        return self.ending is None

    def keeps_pace(self) -> bool:
        """Return whether the end is within reach of the steps that are left."""
        steps = int(self.run.steps)
        if self.pace.is_hopeless(self.t, steps):
            self.stop(*leg.ENDS[leg.STALLED])
        elif steps >= self.options.max_steps:
            self.stop(*leg.ENDS[leg.TOO_MANY_STEPS])
        return self.ending is None

    def record(self, state: np.ndarray) -> None:
        """Keep the next output, and the largest |C| since the one before."""
        self.states[self.reached], self.worst[self.reached] = state, self.run.compliance
        self.run.compliance = 0.0
        self.reached += 1

    def jumps(self, event: bool) -> bool:
        """Pass the event or the singular pose that the step came to; return whether the code must start afresh."""
        if self.reached == len(self.times):
            return False
        if event:
            self._settle()
        elif self.loops and is_near_singular(self.system, self.t, self.now):
            if not self.options.project:
                self._stop_where_branches_meet()
                return False
            self._leap()
        else:
            return False
        self.events.slope = None
        return True

    def _settle(self) -> None:
        """Change modes, and the state at impacts, until all hold."""
        code = self.events.settle(self.t, self.now)
        if code != leg.RUNNING:
            self.stop(*leg.ENDS[code])

    def _leap(self) -> None:
        """Pass a singular pose."""
        landing = leap(self.system, self.options, self.run, self.t, self.now, self.times, self.reached, self.states)
        self.t, self.now, self.reached = landing.t, landing.y, landing.reached
        if landing.failed is not None:
            self.ending = Ending(landing.failed.status, landing.failed.message)

    def _stop_where_branches_meet(self) -> None:
        """Stop where the drift off the constraints decides on the branch.

        There C looks like x y, with x and y along the two branches: a motion on x y = |C| leaves its branch where it
        is as near as sigma = sqrt |C|, and the relative closure pivot is sigma^2.
        """
        if self.system.regularity() < max(self.drift, float(np.finfo(float).eps)):
            status, words = leg.ENDS[leg.SINGULAR]
            drift = f"|C| has drifted to {self.drift:.2g} of the scene's length"
            self.stop(status, f"{words}: {drift}; stabilization = 'projection' carries it past")

    def finish(self) -> leg.Leg:
        """Leave clock and state where the leg ended, and return it."""
        self.run.t = self.t
        self.y[:] = self.now
        status, message = self.ending or (Status.SUCCESS, "")
        return leg.Leg(self.states, self.worst, self.reached, status, message)
