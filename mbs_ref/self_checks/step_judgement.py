"""Was a step short, a tolerance tight enough? The finished run judged by single steps and by a second run.

A fixed step promises nothing, and is always looked at: the second run takes half of it. A tolerance bounds the error
of a step alone; what that adds up to shows in a second run with a TENTH of it. It is made for COARSE tolerances, for
LONG runs, where errors have room to grow, and where the energy says that the motion went ASTRAY, as it may in a close
pass. Other runs are taken at their word, as everywhere.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import System
from mbs_ref.integrators.loop.leg import Options
from mbs_ref.run.legs import Run, run_legs
from mbs_ref.run.plan import ON_GRID, Plan
from mbs_ref.self_checks.energy_watch import phase_error
from mbs_ref.self_checks.resolution import resolution
from mbs_ref.self_checks.second_run import SEEN, Size, disagreement, least_size, size_of
from mbs_ref.trajectory import Status

COARSE = 1e-5  # relative tolerance from which on a run is made again
LONG = 1_000_000  # steps from which on it is made again, too
ASTRAY = 0.1 * SEEN  # rad: what the energy tells of the phase from which on it is made again, too
TIGHTEST = 1e-12  # relative tolerance that has a TENTH above roundoff
TENTH = 0.1  # of the tolerance, for the second run
MORE_STEPS = 4  # times those allowed may a run with a TENTH take, which needs the square root of ten at order 2
LOOKS = 16  # at the second run, where outputs are no more
GOLDEN = 0.618033988749895  # golden ratio: its multiples lie nowhere near each other
LOOSE = 5.0  # times the relative tolerance: what a whole run may err where that is more than SEEN
ADVICE = {
    "step": "take a shorter step or an adaptive method, or unresolved = 'keep'",
    "tolerance": "take a tighter tolerance, or unresolved = 'keep'",
}


def judged(system: System, plan: Plan, run: Run) -> Run:
    """Return the finished run, `unresolved` where its step or tolerance leaves another motion than the true one."""
    found = None
    if plan.settings.unresolved == "stop":
        against = _against_half if plan.options.step else _against_tenth
        found = against(system, plan, run)
    return run._replace(status=found[0], message=found[1]) if found else run


class _Doubt(NamedTuple):
    """Why a run within a tolerance is made again."""

    serious: bool  # enough for a second run
    grave: bool  # and to hold it against the first where the second does not end, though they agreed so far


def _doubt(system: System, plan: Plan, run: Run) -> _Doubt:
    rtol, steps = plan.options.rtol, run.counts.steps
    if rtol < TIGHTEST:
        return _Doubt(False, False)
    if rtol >= COARSE or steps >= LONG:
        return _Doubt(True, True)
    phase = phase_error(system, run.times, run.states, steps)
    return _Doubt(phase.at_most > ASTRAY, phase.about > ASTRAY)


def _damped(system: System, plan: Plan, run: Run, seen: np.ndarray) -> tuple[Status, str] | None:
    """Judge single steps, where methods damp or alias fast motions; contact switches in the middle of a step."""
    if system.scene.contacts:
        return None
    found = resolution(system, plan.integrator, plan.options, run.times, run.states, seen)
    if not found.lost:
        return None
    return Status.UNRESOLVED, (
        f"{_subject(plan)} does not resolve the motion: steps of half its size move body "
        f"{found.body!r} elsewhere, most at t = {found.time:.6g} s, and over the run that adds up to "
        f"{found.share:.2g} of the whole motion; {ADVICE['step']}"
    )


def _against_half(system: System, plan: Plan, run: Run) -> tuple[Status, str] | None:
    """Judge the run by its single steps, and by a second one with half the step."""
    options = plan.options._replace(max_steps=2 * plan.options.max_steps)
    other = _repeated(system, plan, options, run.states[0], refine=2)
    damped = None if other.status is Status.INTERRUPTED else _damped(system, plan, run, other.states)
    order = 1 if system.scene.contacts or system.scene.events else plan.integrator.order
    return damped or _compared(system, plan, run, other, _Second("half", 2.0**order, SEEN, Size(), must_end=True))


def _against_tenth(system: System, plan: Plan, run: Run) -> tuple[Status, str] | None:
    """Judge a doubtful run by a second one with a tenth of the tolerances."""
    doubt = _doubt(system, plan, run)
    if not doubt.serious:
        return None
    rtol = plan.options.rtol
    options = plan.options._replace(
        rtol=TENTH * rtol, atol=TENTH * plan.options.atol, max_steps=MORE_STEPS * plan.options.max_steps
    )
    other = _repeated(system, plan, options, run.states[0], refine=1)
    bound = max(SEEN, LOOSE * rtol)
    least = least_size(system.scene, plan.options.atol, bound)
    return _compared(system, plan, run, other, _Second("a tenth", 1.0 / TENTH, bound, least, doubt.grave))


class _Second(NamedTuple):
    """How a second run judges the first."""

    part: str  # of the first one's step or tolerance
    smaller: float  # so many times its error is
    bound: float  # of the motion's size: what the first may err
    least: Size  # of the motion
    must_end: bool  # or the first is unresolved


def _compared(system: System, plan: Plan, run: Run, other: Run, how: _Second) -> tuple[Status, str] | None:
    if other.status is Status.INTERRUPTED:
        return other.status, f"{other.message} of the second run that judges the first, which is complete"
    scene, count = system.scene, int(np.searchsorted(run.times, other.times[-1], side="right"))
    same = np.searchsorted(other.times, run.times[:count])
    first, second = system.poses(run.states[:count]), system.poses(other.states[same])
    size = size_of(how.least, first, system.poses(other.states))
    found = disagreement(first, second, size, how.smaller, how.bound)
    if found.first is None and (other.status is Status.SUCCESS or not how.must_end):
        return None
    good = count - 1 if found.first is None else max(found.first - 1, 0)
    why = (
        f"with {how.part} of it the run does not end: {other.message}" if found.first is None else
        f"{how.part} of it takes body {scene.bodies[found.body].name!r} elsewhere, beyond the bound at "
        f"t = {run.times[found.first]:.6g} s and by an estimated {found.share:.2g} of the whole motion at worst"
    )  # fmt: skip
    return Status.UNRESOLVED, (
        f"{_subject(plan)} does not resolve the motion: {why}; the last good output is at "
        f"t = {run.times[good]:.9g} s; {ADVICE['step' if plan.options.step else 'tolerance']}"
    )


def _subject(plan: Plan) -> str:
    options = plan.options
    return f"the step of {options.step:g} s" if options.step else f"the relative tolerance of {options.rtol:g}"


def _repeated(system: System, plan: Plan, options: Options, start: np.ndarray, refine: int) -> Run:
    """Repeat the run with other options, on a system of its own, and look often enough to see how far it goes."""
    other, y = compile_scene(system.scene), start.copy()
    other.set_mode_time(0.0)
    other.set_baumgarte(plan.baumgarte_gain)
    other.start_contacts(0.0, y, plan.settings.events != "none")
    again = replace(plan, times=_looks(plan), options=options._replace(stop_on_compliance=False))
    return run_legs(other, again, y, refine=refine)


def _looks(plan: Plan) -> np.ndarray:
    """Return the output times; where they are few, LOOKS more.

    Errors are measured by the motion, and a few outputs once a period show none.
    """
    times, k = plan.times, np.arange(LOOKS)
    if len(times) > LOOKS:
        return times
    before = k * (len(times) - 1) // LOOKS
    start, length = times[before], np.diff(times)[before]
    inside = (0.1 + 0.8 * np.mod((k + 1) * GOLDEN, 1.0)) * length
    if plan.options.step:
        inside = np.round(inside / plan.options.step) * plan.options.step
    more = (start + inside)[(inside > 0.0) & (inside < length * (1.0 - ON_GRID))]
    return np.unique(np.concatenate((times, more)))
