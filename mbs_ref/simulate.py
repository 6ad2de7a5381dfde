"""simulate(scene, settings) -> Trajectory: consistency, legs between breakpoints, outcome in a sentence."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass, replace

import numpy as np

from mbs_ref.contact import ConstraintLaw, FloresLaw, LankaraniNikraveshLaw, RigidLaw, StickSlip
from mbs_ref.cores import compile_scene
from mbs_ref.diagnosis import deeper_cause
from mbs_ref.halved_step import disagreement
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.leg import (
    CLOCK_H,
    CLOCK_T,
    COUNT_CONTACT,
    COUNT_EVENTS,
    COUNT_OWN,
    COUNT_REJECTED,
    COUNT_RHS,
    COUNT_STEPS,
    Integrator,
    Options,
    Progress,
    progress,
)
from mbs_ref.interrupts import Interrupts
from mbs_ref.rank_watch import singular_passage
from mbs_ref.resolution import resolution
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.soundness import ambiguous_start, culprit, require_sound
from mbs_ref.system import System
from mbs_ref.traits import traits
from mbs_ref.trajectory import Status, Timing, Trajectory
from mbs_ref.trouble import may_be_stiff, stiffness

DEFAULT_TOLERANCE = 1e-8  # rtol, and atol in m, rad, m/s, rad/s
PROJECTION_TOLERANCE = 1e-14  # of the scene's size in metres (at least 1 m): a little above roundoff
EPS = float(np.finfo(float).eps)
CHUNK = 20_000  # steps between looks at the keyboard
FEWEST = 4  # steps in a leg between declared breakpoints, however short: a pulse is not one step's business
ON_GRID = 1e-9  # of a step: how far an asked time may be from a multiple of the step


class InconsistentScene(ValueError):
    """Initial conditions break a constraint; names the joint and the gap."""


@dataclass(frozen=True)
class _Plan:
    """Settings resolved against a scene and an integrator."""

    integrator: Integrator
    settings: Settings
    times: np.ndarray  # (n_t,) s
    options: Options
    baumgarte_gain: float
    notes: tuple[str, ...]


def simulate(scene: Scene, settings: Settings | None = None, times: np.ndarray | None = None) -> Trajectory:
    """Integrate a scene with the in-house solver.

    `times` (n_t,) in s start at 0 and increase; without them an even grid follows from the settings, on
    multiples of the step for fixed-step methods. Raises ValueError for settings that make no sense,
    UnsoundScene for parts that make none and InconsistentScene where the initial conditions break a
    constraint (unless they are to be projected). Everything later is a status with a sentence; Ctrl-C keeps
    what was computed.

    A fixed-step run is made twice, the second time with half the step, and is `unresolved` where the two part
    (mbs_ref.halved_step). That costs twice the run more, outside of `timing`; unresolved = 'keep' leaves it out.
    """
    settings = settings or Settings()
    plan = _plan(scene, settings, times)
    require_sound(scene)
    started = time.perf_counter()
    system = compile_scene(scene)
    y = system.initial_state()
    built = time.perf_counter()
    system.set_mode_time(0.0)
    repairs = _consistent_start(system, y, settings)
    rank = _rank(system, y)
    notes = [*plan.notes, *repairs, *_redundancy(system, rank)]
    if rank is not None and rank < system.n_constraints and settings.ambiguous == "stop":
        branches = ambiguous_start(system, y, rank)
        if branches:
            return _refused(system, branches, Status.SINGULAR)
    system.set_baumgarte(plan.baumgarte_gain)
    located = settings.events != "none"
    system.start_contacts(0.0, y, located)
    refusal = _unstable(system, plan, y)
    if refusal:
        return _refused(system, refusal)
    _first_call(system, plan, y)
    system.start_contacts(0.0, y, located)
    ready = time.perf_counter()
    times, states, compliance, counts, status, message = _run_legs(system, plan, y)
    ended = time.perf_counter()
    if status is Status.SUCCESS:
        status, message = _resolved(system, plan, times, states, message)
    timing = Timing(build_s=built - started, first_call_s=ready - built, loop_s=ended - ready)
    return _trajectory(system, plan, times, states, compliance, counts, status, message, notes, timing)


def integration_options(scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Options:
    """Return what `simulate` hands to its integrator: for callers that time the bare integrator."""
    return _plan(scene, settings, times).options


# --- before the run -------------------------------------------------------------------------------


def _plan(scene: Scene, settings: Settings, times: np.ndarray | None) -> _Plan:
    known = integrators()
    name = settings.method or DEFAULT
    if name not in known:
        raise ValueError(f"method = {name!r} is unknown to mbs_ref; allowed: {', '.join(known)}")
    integrator = known[name]
    missing = integrator.requires - traits(scene)
    if missing:
        raise ValueError(f"method = {name!r} needs a scene that is {', '.join(sorted(missing))}; {scene.name!r} is not")
    fixed = _wants_fixed_step(integrator, settings)
    notes: tuple[str, ...] = ()
    if times is None:
        t_end = settings.t_end if settings.t_end is not None else scene.duration
        times = _even_grid(t_end, settings.samples, settings.step if fixed else None)
    times = _checked_times(times)
    if fixed and settings.step is not None:
        notes = _off_grid_notes(times, settings.step)
    stabilization = settings.stabilization or integrator.stabilization
    if stabilization not in integrator.stabilizations:
        allowed = ", ".join(integrator.stabilizations)
        raise ValueError(f"stabilization = {stabilization!r} does not go with method {name!r}; allowed: {allowed}")
    _check_events(scene, settings, integrator)
    rtol = settings.rtol or DEFAULT_TOLERANCE
    size = max([1.0, *(abs(x) for body in scene.bodies for x in body.position)])
    options = Options(
        step=float(settings.step or 0.0) if fixed else 0.0,
        rtol=float(rtol),
        atol=float(settings.atol or rtol),
        project=stabilization == "projection",
        stop_on_compliance=settings.stop_on_compliance,
        max_steps=settings.max_steps,
        max_events=settings.max_events,
        projection_tolerance=PROJECTION_TOLERANCE * size,
        chunk=CHUNK,
    )
    gain = settings.baumgarte_gain if stabilization == "baumgarte" else 0.0
    return _Plan(integrator, settings, times, options, gain, notes)


def _check_events(scene: Scene, settings: Settings, integrator: Integrator) -> None:
    if settings.events == "none" and scene.events:
        raise ValueError(f"events = 'none' cannot run {scene.events[0].name}: a declared event must be located")
    if (scene.contacts or scene.events) and settings.events != "none" and not integrator.locates_events:
        raise ValueError(f"method {integrator.name!r} locates no events; give events = 'none', or another method")
    impulsive = RigidLaw | ConstraintLaw
    needs = [c.name for c in scene.contacts if isinstance(c.law, impulsive) or isinstance(c.friction, StickSlip)]
    if settings.events == "none" and needs:
        raise ValueError(f"events = 'none' cannot run {', '.join(needs[:8])}: impacts and sticking are events")
    needs = [c.name for c in scene.contacts if isinstance(c.law, LankaraniNikraveshLaw | FloresLaw)]
    if settings.events == "none" and needs:
        raise ValueError(f"events = 'none' cannot run {', '.join(needs[:8])}: the law needs the speed at touch-down")


def _wants_fixed_step(integrator: Integrator, settings: Settings) -> bool:
    if integrator.kind == "fixed" and settings.step is None:
        raise ValueError(f"method {integrator.name!r} has a fixed step; give step (s), not tolerances")
    if integrator.kind == "adaptive" and settings.step is not None:
        raise ValueError(f"method {integrator.name!r} is adaptive; give rtol and atol, not step = {settings.step}")
    return settings.step is not None


def _even_grid(t_end: float, samples: int, step: float | None) -> np.ndarray:
    if step is None:
        return np.linspace(0.0, t_end, samples)
    whole = int(np.floor(t_end / step * (1.0 + ON_GRID)))
    picks = np.unique(np.linspace(0, whole, min(samples, whole + 1)).round().astype(int))
    times = picks * step
    if t_end - times[-1] > ON_GRID * step:
        return np.append(times, t_end)
    times[-1] = t_end
    return times


def _checked_times(times: np.ndarray) -> np.ndarray:
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or len(times) < 2 or times[0] != 0.0 or not np.all(np.diff(times) > 0.0):
        raise ValueError(f"times must start at 0 and increase, with two entries at least; got {times!r}")
    if not np.all(np.isfinite(times)):
        raise ValueError("times must be finite")
    return times


def _off_grid_notes(times: np.ndarray, step: float) -> tuple[str, ...]:
    ratio = times / step
    off = np.abs(ratio - ratio.round()) > ON_GRID * np.maximum(1.0, ratio)
    if not off.any():
        return ()
    first = times[off][0]
    return (f"{off.sum()} of {len(times)} output times are no multiple of the step {step:g} s (first: {first:g} s); "
            "the last step before each is shorter",)  # fmt: skip


def _consistent_start(system: System, y: np.ndarray, settings: Settings) -> list[str]:
    """Check the initial conditions; repair them when asked for and say by how much."""
    gaps = [
        f"joint {name!r}: {what} gap {np.abs(values).max():.3g}"
        for name, pair in system.residuals(0.0, y).items()
        for what, values in zip(("position", "velocity"), pair, strict=True)
        if not np.abs(values).max() <= settings.initial_tolerance
    ]
    if not gaps:
        return []
    if not settings.project_initial:
        raise InconsistentScene(
            f"initial conditions break {len(gaps)} constraint(s) by more than {settings.initial_tolerance:g}: "
            f"{'; '.join(gaps[:8])}. Mend the scene, or ask for projection (project_initial)"
        )
    before = y.copy()
    left = system.project(0.0, y)
    if not left <= settings.initial_tolerance:
        raise InconsistentScene(f"the initial positions cannot be projected: {left:.3g} left; {'; '.join(gaps[:8])}")
    half = system.n_positions
    moved, kicked = np.abs(y - before)[:half].max(), np.abs(y - before)[half:].max()
    return [f"initial conditions were projected: largest correction {moved:.3g} m or rad, {kicked:.3g} m/s or rad/s"]


_RANK_CHECK_LIMIT = 600  # rows; a dense SVD beyond takes seconds and a tree without closures is regular


def _rank(system: System, y: np.ndarray) -> int | None:
    """Return the rank of C_q at the start; None where it is not looked at."""
    if system.n_closure_rows == 0 or system.n_constraints > _RANK_CHECK_LIMIT:
        return None
    return system.rank(0.0, y)


def _redundancy(system: System, rank: int | None) -> list[str]:
    """Report dependent constraint rows at the start."""
    rows = system.n_constraints
    if rank is None or rank == rows:
        return []
    freedom = system.n_coordinates - rank
    return [
        f"{rows - rank} of {rows} constraint rows are redundant at t = 0 (rank {rank}, {freedom} degrees of freedom); "
        "multipliers are the minimum-norm ones"
    ]


def _unstable(system: System, plan: _Plan, y: np.ndarray) -> str:
    """Return why an explicit fixed step cannot work from the start on, or nothing."""
    asked = plan.options.step
    if not (asked and plan.integrator.stability and plan.settings.refuse_unstable and may_be_stiff(system.scene)):
        return ""
    found = stiffness(system, 0.0, y)
    limit = found.step_limit(plan.integrator.stability)
    if asked <= limit:
        return ""
    return (f"step = {asked:g} s is beyond what {plan.integrator.name} can bear: the fastest motion has |lambda| = "
            f"{found.fastest:.4g} 1/s and needs a step of at most {limit:.3g} s; take that, an implicit or adaptive "
            "method, or refuse_unstable = False")  # fmt: skip


def _refused(system: System, reason: str, status: Status = Status.REFUSED) -> Trajectory:
    none = system.poses(np.zeros((0, len(system.initial_state()))))
    return Trajectory(times=np.zeros(0), **none._asdict(), status=status, message=reason)


def _resolved(system: System, plan: _Plan, times: np.ndarray, states: np.ndarray, message: str) -> tuple[Status, str]:
    """Return success, or that the fixed step is too long for the motion that was to be followed."""
    if not plan.options.step or plan.settings.unresolved == "keep":
        return Status.SUCCESS, message
    found = _damped(system, plan, states) or _against_half(system, plan, times, states)
    return found or (Status.SUCCESS, message)


def _damped(system: System, plan: _Plan, states: np.ndarray) -> tuple[Status, str] | None:
    """Judge single steps, where methods damp or alias fast motions; contact switches in the middle of a step."""
    if system.scene.contacts:
        return None
    step = plan.options.step
    found = resolution(system, plan.integrator, plan.options, plan.times, states)
    if not found.lost:
        return None
    return Status.UNRESOLVED, (
        f"the step of {step:g} s does not resolve the motion: steps of half its size move body {found.body!r} "
        f"elsewhere, most at t = {found.time:.6g} s, and over the run that adds up to {found.share:.2g} of the "
        "whole motion; take a shorter step or an adaptive method, or unresolved = 'keep'"
    )


def _against_half(system: System, plan: _Plan, times: np.ndarray, states: np.ndarray) -> tuple[Status, str] | None:
    """Judge the run by a second one with half the step, made by a system of its own."""
    step, scene = plan.options.step, system.scene
    other = compile_scene(scene)
    y = states[0].copy()
    other.set_mode_time(0.0)
    other.set_baumgarte(plan.baumgarte_gain)
    other.start_contacts(0.0, y, plan.settings.events != "none")
    halved = replace(
        plan, options=plan.options._replace(max_steps=2 * plan.options.max_steps, stop_on_compliance=False)
    )
    reached, again, _, _, status, message = _run_legs(other, halved, y, refine=2)
    if status is Status.INTERRUPTED:
        return status, f"{message} of the second run that judges the step; the first is complete"
    count = min(len(times), len(reached))
    order = 1 if scene.contacts or scene.events else plan.integrator.order
    found = disagreement(system.poses(states[:count]), system.poses(again[:count]), order)
    if found.first is None and status is Status.SUCCESS:
        return None
    body = scene.bodies[found.body].name
    good = count - 1 if found.first is None else max(found.first - 1, 0)
    why = (
        f"with half of it the run does not end: {message}" if found.first is None else
        f"half of it takes body {body!r} elsewhere, beyond the bound at t = {times[found.first]:.6g} s and by an "
        f"estimated {found.share:.2g} of the whole motion at worst"
    )  # fmt: skip
    return Status.UNRESOLVED, (
        f"the step of {step:g} s does not resolve the motion: {why}; the last good output is at "
        f"t = {times[good]:.9g} s; take a shorter step or an adaptive method, or unresolved = 'keep'"
    )


# --- the run --------------------------------------------------------------------------------------


def _first_call(system: System, plan: _Plan, y: np.ndarray) -> None:
    """Make one tiny leg on a copy: it compiles the method, or loads it from the cache, outside the timed loop."""
    span = min(1e-9, plan.times[1])
    with np.errstate(all="ignore"):
        options = plan.options._replace(max_steps=2)
        plan.integrator.advance(system, options, progress(0.0), y.copy(), np.array([0.0, span]))


def _run_legs(system: System, plan: _Plan, y: np.ndarray, refine: int = 1):
    """Integrate up to the last time or the first trouble; say what went wrong, where, and what is still good.

    `refine` makes that many steps of each.
    """
    times = plan.times
    states = np.empty((len(times), len(y)))
    compliance = np.zeros(len(times))
    states[0] = y
    run = progress(0.0)
    with Interrupts(run.counts, plan.options.max_steps) as interrupts:
        filled, status, message = _legs(system, plan, run, y, states, compliance, refine)
    total = run.counts[[COUNT_STEPS, COUNT_REJECTED, COUNT_RHS, COUNT_EVENTS, COUNT_OWN]]
    total[0] = interrupts.steps
    if system.user_error is not None:
        status, message = Status.ENGINE_ERROR, f"a user force raised {system.user_error!r}"
    elif interrupts.asked and status is Status.TOO_MANY_STEPS:
        status, message = Status.INTERRUPTED, f"interrupted at t = {run.clock[CLOCK_T]:.9g} s"
    elif status is Status.ENDLESS_EVENTS:
        message += f"; {system.event_sources[run.counts[COUNT_CONTACT]]!r} was the last"
    elif status is Status.STOP_EVENT:
        states, compliance = np.vstack((states[:filled], y)), np.append(compliance[:filled], 0.0)
        times, filled = np.append(times[:filled], run.clock[CLOCK_T]), filled + 1
        message += f": {system.event_sources[run.counts[COUNT_CONTACT]]!r}"
    elif status is Status.SINGULAR and plan.options.rtol < EPS:
        status = Status.STEP_TOO_SMALL
        message = f"at t = {run.clock[CLOCK_T]:.9g} s rtol = {plan.options.rtol:.3g} asks for more than roundoff leaves"
    elif status is not Status.SUCCESS:
        stuck = float(run.clock[CLOCK_T])
        message += culprit(system, stuck, y) + deeper_cause(system, status, stuck, y)
    if status is Status.SUCCESS:
        message = message or f"reached t = {times[-1]:g} s"
    elif status is not Status.STOP_EVENT:
        message += f"; the last good output is at t = {times[filled - 1]:.9g} s"
    return times[:filled], states[:filled], compliance[:filled], total, status, message


def _legs(
    system: System, plan: _Plan, run: Progress, y: np.ndarray, states: np.ndarray, compliance: np.ndarray,
    refine: int,
) -> tuple[int, Status, str]:  # fmt: skip
    """Integrate leg by leg: a declared breakpoint ends one and starts the next. Return samples, status, message."""
    times, filled, carried, message = plan.times, 1, 0.0, ""
    inner = [t for t in system.scene.breakpoints() if 0.0 < t < times[-1]]
    for start, end in itertools.pairwise([0.0, *inner, float(times[-1])]):
        system.set_mode_time(0.5 * (start + end))
        inside = times[(times > start) & (times <= end)]
        leg_times = np.unique(np.concatenate(([start], inside, [end])))
        options = _leg_options(plan.options, end - start if inner else np.inf, refine)
        if refine > 1:
            leg_times = _refined(leg_times, refine * options.step, refine)
        run.clock[CLOCK_T], run.clock[CLOCK_H] = start, 0.0
        leg = plan.integrator.advance(system, options, run, y, leg_times)
        for k in range(1, leg.reached):
            carried = max(carried, leg.compliance[k])
            if filled < len(times) and leg_times[k] == times[filled]:
                states[filled], compliance[filled], carried = leg.states[k], carried, 0.0
                filled += 1
        if leg.status is not Status.SUCCESS:
            return filled, leg.status, leg.message
        y[:], message = leg.states[leg.reached - 1], leg.message
    return filled, Status.SUCCESS, message


def _leg_options(options: Options, length: float, refine: int) -> Options:
    """Return the options for a leg of `length` (s): FEWEST steps at least, each divided by `refine`."""
    return options._replace(step=min(options.step, length / FEWEST) / refine) if options.step else options


def _refined(times: np.ndarray, step: float, refine: int) -> np.ndarray:
    """Divide the intervals that are shorter than the step (s): outputs cut it there, and would cut its parts alike."""
    gaps = np.diff(times)
    short = np.flatnonzero(gaps < step * (1.0 - ON_GRID))
    parts = [times[short] + gaps[short] * k / refine for k in range(1, refine)]
    return np.unique(np.concatenate((times, *parts)))


def _trajectory(system, plan, times, states, compliance, counts, status, message, notes, timing) -> Trajectory:
    contacts = system.contact_forces(times, states) if system.scene.contacts and plan.settings.reactions else {}
    return Trajectory(
        times=times,
        **system.poses(states)._asdict(),
        status=status,
        message=message,
        steps=int(counts[0]),
        rejected_steps=int(counts[1]),
        rhs_calls=int(counts[2]),
        events=int(counts[3]),
        method_switches=int(counts[4]) if plan.integrator.switches else None,
        timing=timing,
        step_compliance=np.column_stack((times, compliance)),
        notes=(*notes, *_switching(plan, int(counts[4])), *singular_passage(system, times, states)),
        contacts=contacts,
        event_times=system.contact_events() if system.event_sources else None,
        event_names=system.event_sources,
        reactions=_reactions(system, plan, times, states),
    )


def _switching(plan: _Plan, count: int) -> tuple[str, ...]:
    if not plan.integrator.switches:
        return ()
    return (f"{plan.integrator.name} changed {count} times between {plan.integrator.switches}",)


def _reactions(system: System, plan: _Plan, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
    """Evaluate joint reactions at the output times."""
    if not plan.settings.reactions:
        return {}
    system.set_baumgarte(0.0)
    samples = []
    for t, y in zip(times, states, strict=True):
        system.set_mode_time(t)
        system.recall_modes(t)  # not the modes that the run ended in
        samples.append(system.reactions(t, y))
    return {name: np.array([sample[name] for sample in samples]) for name in samples[0]} if samples else {}
