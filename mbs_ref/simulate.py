"""simulate(scene, settings) -> Trajectory: a plan, a consistent start, the legs, an estimate of the error."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.relative.system import RelativePlanarSystem
from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.run.lanes import NOTE, pieces, runs_in_lanes, why_not_in_lanes
from mbs_ref.run.legs import Run, finite_part, run_legs
from mbs_ref.run.many import check_shapes, processors, shared, stopped
from mbs_ref.run.method_choice import choose_plan, without
from mbs_ref.run.plan import Plan, integration_options
from mbs_ref.scene import Scene
from mbs_ref.self_checks.consistent_start import (
    InconsistentScene,
    consistent_start,
    rank_at_start,
    redundancy,
    unstable_step,
)
from mbs_ref.self_checks.error_estimate import ENDED, companion_plan, estimated
from mbs_ref.self_checks.first_steps import after_first_steps
from mbs_ref.self_checks.rank_watch import singular_passage
from mbs_ref.self_checks.soundness import UnsoundScene, ambiguous_start, require_sound
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Timing, Trajectory

BROKEN_DOWN = frozenset({Status.NOT_CONVERGED, Status.NON_FINITE, Status.STEP_TOO_SMALL})  # a method, not the scene
__all__ = ["InconsistentScene", "integration_options", "simulate", "simulate_scenes", "simulate_starts"]


def simulate(
    scene: Scene, settings: Settings | None = None, times: np.ndarray | None = None, start: Poses | None = None
) -> Trajectory:
    """Integrate a scene with the in-house solver.

    `times` (n_t,) in s start at 0 and increase; without them an even grid follows from the settings, on
    multiples of the step for fixed-step methods. `start` are poses and velocities at t = 0 (one sample of each) in
    place of the scene's own; joints stay where the scene has them on the bodies. Raises ValueError for settings that
    make no sense, UnsoundScene for parts that make none and InconsistentScene where the initial conditions break a
    constraint (unless they are to be projected). Everything later is a status with a sentence; Ctrl-C keeps
    what was computed.

    A run that ends well is made again with half of its step, or a tenth of its tolerances: what the two differ by
    estimates the error (self_checks/error_estimate.py). It is `unresolved` where no output after the start has a digit
    that holds. The second run's time is outside of `timing`; estimate = 'off' leaves it out.

    method = 'auto' leaves the method to what the scene contains and to what its first steps tell; the trajectory says
    which it was and why. Where a method so chosen breaks down, the default makes the run again.
    """
    plan, system, build_s = compiled(scene, settings or Settings(), times)
    own = system.redundant
    y = own.initial_state() if start is None else own.states_of(start)[0]
    return simulated(system, plan, y, build_s)


def compiled(scene: Scene, settings: Settings, times: np.ndarray | None) -> tuple[Plan, System, float]:
    """Return the plan, the system and the time to build it (s), as `simulate` begins."""
    require_sound(scene)
    plan = choose_plan(scene, settings, times)
    started = time.perf_counter()
    return plan, compile_scene(scene, settings.coordinates), time.perf_counter() - started


def simulated(system: System, plan: Plan, y: np.ndarray, build_s: float = 0.0, warm: bool = False) -> Trajectory:
    """Return what `simulate` does from a state y of `system.redundant`; `warm` where this plan has been run before."""
    began, settings = time.perf_counter(), plan.settings
    system.set_mode_time(0.0)
    system.set_baumgarte(0.0)
    repairs = consistent_start(system.redundant, y, settings)
    y = system.reduced(y)
    rank = rank_at_start(system, y)
    notes = [*plan.notes, *repairs, *redundancy(system, rank)]
    if rank is not None and rank < system.n_constraints and settings.ambiguous == "stop":
        branches = ambiguous_start(system, y, rank)
        if branches:
            return _refused(system, branches, Status.SINGULAR)
    system.set_baumgarte(plan.baumgarte_gain)
    system.start_contacts(0.0, y, settings.events != "none")
    plan = after_first_steps(system, plan, y)
    refusal = unstable_step(system, plan, y)
    if refusal:
        return _refused(system, refusal)
    if not warm:
        _first_call(system, plan, y)
    ready = time.perf_counter()
    run = _run(system, plan, y.copy())
    if plan.reason and run.status in BROKEN_DOWN and plan.integrator.name != DEFAULT:
        plan, system = without(system.scene, plan, run.message), system.twin()
        run = _run(system, plan, y)
    timing = Timing(build_s=build_s, first_call_s=ready - began, loop_s=run.loop_s)
    path = _trajectory(system, plan, run, notes, timing, _sampled(system, plan, [run])[0])
    return _with_estimate(system, plan, run, path)


def _run(system: System, plan: Plan, y: np.ndarray) -> Run:
    """Make the run from y, which is left where it ends."""
    system.set_mode_time(0.0)
    system.set_baumgarte(plan.baumgarte_gain)
    system.start_contacts(0.0, y, plan.settings.events != "none")
    return finite_part(system, run_legs(system, plan, y))


def simulate_starts(
    scene: Scene,
    starts: Poses,
    settings: Settings | None = None,
    times: np.ndarray | None = None,
    threads: int | None = None,
    lanes: bool = False,
) -> list[Trajectory]:
    """Return a trajectory from each of n starts of one scene, as `simulate(scene, settings, times, start)` makes it.

    `starts` holds position (n, n_bodies, dimension) m, orientation (n, n_bodies) rad or (n, n_bodies, 4), velocity and
    angular velocity (rad/s) like them, as a Trajectory does. Tolerances follow the scene's own start. `threads` is the
    number of processors unless given. A start that breaks a constraint gives the status `inconsistent`; ValueError
    where the arrays are not such ones, or as `simulate` raises it.

    Every run is to the bit as it is alone: each thread has a system of its own, and a scene whose runs leave contact
    modes behind gets a new one for every run.

    With `lanes` each thread makes several runs side by side by packed instructions, many times faster, where scene and
    settings allow it (mbs_ref.run.lanes.why_not_in_lanes): planar trees under gravity alone, by DOP853 with tolerances.
    They are in relative coordinates then, whatever the settings say, and take the steps of such a run alone, but sines
    and sums are rounded otherwise in the last digit. What a run gives does not depend on the others. Its note says that
    it was made so; where lanes cannot be, all is as without them, and the note says why.
    """
    check_shapes(scene, starts)
    if not len(starts.position):
        return []
    settings = settings or Settings()
    reason = why_not_in_lanes(scene, settings) if lanes else ""
    if lanes and not reason:
        return _starts_in_lanes(scene, starts, settings, times, processors(threads))
    plan, system, build_s = compiled(scene, settings, times)
    if reason:
        plan = replace(plan, notes=(*plan.notes, f"not in lanes: {reason}"))
    states, of_thread = system.redundant.states_of(starts), threading.local()

    def run(y: np.ndarray) -> Trajectory:
        warm = hasattr(of_thread, "system")
        if not warm or system.event_sources:
            of_thread.system = system.twin()
        return simulated(of_thread.system, plan, y.copy(), build_s, warm)

    return shared(lambda y: _or_stopped(scene, lambda: run(y)), list(states), threads)


def _starts_in_lanes(
    scene: Scene, starts: Poses, settings: Settings, times: np.ndarray | None, threads: int
) -> list[Trajectory]:
    plan, first, build_s = compiled(scene, settings.model_copy(update={"coordinates": "relative"}), times)
    plan, of_thread = replace(plan, notes=(*plan.notes, NOTE)), threading.local()
    told = first.redundant.states_of(starts)
    runs_in_lanes(_in_plane(first), plan, np.zeros((0, len(first.initial_state()))))  # compiles

    def piece(part: slice) -> list[Trajectory]:
        if not hasattr(of_thread, "system"):
            of_thread.system = _in_plane(first.twin())
        return _side_by_side(of_thread.system, plan, told[part].copy(), build_s)

    work = pieces(len(told), threads, plan, told.shape[1])
    return [path for paths in shared(piece, work, threads, alone=0) for path in paths]


def _in_plane(system: System) -> RelativePlanarSystem:
    assert isinstance(system, RelativePlanarSystem)
    return system


def _side_by_side(system: RelativePlanarSystem, plan: Plan, told: np.ndarray, build_s: float) -> list[Trajectory]:
    """Return what `simulated` does from redundant states (n, n_told), side by side."""
    began = time.perf_counter()
    paths, said = {}, {}
    for k, y in enumerate(told):
        try:
            said[k] = consistent_start(system.redundant, y, plan.settings)
        except InconsistentScene as error:
            paths[k] = stopped(system.scene, Status.INCONSISTENT, str(error))
    starts = system.all_reduced(told[[*said]])
    ready = (time.perf_counter() - began) / max(1, len(told))
    runs = runs_in_lanes(system, plan, starts)
    companions: list[Run | None] = [None] * len(runs)
    if plan.settings.estimate == "on":
        finer, refine = companion_plan(system, plan)
        companions = [*runs_in_lanes(system, finer, starts, refine)]
    for k, run, companion, samples in zip(said, runs, companions, _sampled(system, plan, runs), strict=True):
        timing = Timing(build_s=build_s, first_call_s=ready, loop_s=run.loop_s)
        path = _trajectory(system, plan, run, [*plan.notes, *said[k]], timing, samples)
        paths[k] = _with_estimate(system, plan, run, path, companion)
    return [paths[k] for k in range(len(told))]


def simulate_scenes(
    scenes: Iterable[Scene],
    settings: Settings | None = None,
    times: np.ndarray | None = None,
    threads: int | None = None,
) -> list[Trajectory]:
    """Return the trajectory of each scene, as `simulate(scene, settings, times)` makes it.

    A scene that is unsound or breaks a constraint gives the status `refused` or `inconsistent`.
    """
    return shared(lambda scene: _or_stopped(scene, lambda: simulate(scene, settings, times)), list(scenes), threads)


def _or_stopped(scene: Scene, run: Callable[[], Trajectory]) -> Trajectory:
    try:
        return run()
    except InconsistentScene as error:
        return stopped(scene, Status.INCONSISTENT, str(error))
    except UnsoundScene as error:
        return stopped(scene, Status.REFUSED, str(error))


def _refused(system: System, reason: str, status: Status = Status.REFUSED) -> Trajectory:
    none = system.poses(np.zeros((0, len(system.initial_state()))))
    return Trajectory(times=np.zeros(0), **none._asdict(), status=status, message=reason)


def _first_call(system: System, plan: Plan, y: np.ndarray) -> None:
    """Make one tiny leg on a copy: it compiles the method, or loads it from the cache, outside the timed loop."""
    span = min(1e-9, plan.times[1])
    with np.errstate(all="ignore"):
        options = plan.options._replace(max_steps=2)
        plan.integrator.advance(system, options, progress(0.0), y.copy(), np.array([0.0, span]))


class Samples(NamedTuple):
    """What the states of a run say."""

    poses: Poses
    reactions: dict[str, np.ndarray]


def _sampled(system: System, plan: Plan, runs: list[Run]) -> list[Samples]:
    """Return what the states of each run say, asked of all of them at once: of scenes without events."""
    ends = np.cumsum([len(run.times) for run in runs])[:-1]
    if not runs:
        return []
    times, states = np.concatenate([run.times for run in runs]), np.concatenate([run.states for run in runs])
    poses = [np.split(part, ends) for part in system.poses(states)]
    reactions = {name: np.split(part, ends) for name, part in _reactions(system, plan, times, states).items()}
    return [
        Samples(Poses(*(part[k] for part in poses)), {name: part[k] for name, part in reactions.items()})
        for k in range(len(runs))
    ]


def _trajectory(system: System, plan: Plan, run: Run, notes: list[str], timing: Timing, samples: Samples) -> Trajectory:
    times, states, counts = run.times, run.states, run.counts
    contacts = system.contact_forces(times, states) if system.scene.contacts and plan.settings.reactions else {}
    return Trajectory(
        times=times,
        **samples.poses._asdict(),
        status=run.status,
        message=run.message,
        steps=counts.steps,
        rejected_steps=counts.rejected_steps,
        rhs_calls=counts.rhs_calls,
        events=counts.events,
        method_switches=counts.switches if plan.integrator.switches else None,
        timing=timing,
        step_compliance=np.column_stack((times, run.compliance)),
        notes=(*_chosen(plan), *notes, *_other_ways(plan, run), *singular_passage(system, times, states)),
        method=plan.integrator.name,
        reason=plan.reason,
        used=_used(plan, run),
        contacts=contacts,
        event_times=system.contact_events() if system.event_sources else None,
        event_names=system.event_sources,
        reactions=samples.reactions,
    )


def _with_estimate(system: System, plan: Plan, run: Run, path: Trajectory, companion: Run | None = None) -> Trajectory:
    """Add the estimate of its error to a run that ended well, and say what it is worth."""
    if run.status not in ENDED or plan.settings.estimate == "off":
        return path
    estimate = estimated(system, plan, run, companion)
    if estimate is None:
        reason = "interrupted while a second run estimated the error of this one, which is complete"
        return replace(path, status=Status.INTERRUPTED, message=reason)
    remark = estimate.remark()
    if estimate.is_void:
        return replace(path, estimate=estimate, status=Status.UNRESOLVED, message=f"no output has a digit: {remark}")
    return replace(path, estimate=estimate, notes=(*path.notes, remark) if remark else path.notes)


def _chosen(plan: Plan) -> tuple[str, ...]:
    """Say which method ran and why, where that was left to us."""
    return (f"method auto is {plan.integrator.name}: {plan.reason}",) if plan.reason else ()


def _other_ways(plan: Plan, run: Run) -> tuple[str, ...]:
    """Say how often the method changed its family, and for what share of the time another went on in its place."""
    name, families, share = plan.integrator.name, plan.integrator.switches, run.carried_share
    changed = (f"{name} changed {run.counts.switches} times between {families}",) if families else ()
    carried = (f"DOP853 carried {name} past singular poses, for {share:.2g} of the time",) if share else ()
    return changed + carried


def _used(plan: Plan, run: Run) -> dict[str, float]:
    """Return the settings that the run had, defaults included, and what share of the time another method made."""
    options = plan.options
    accuracy = {"step": options.step} if options.step else {"rtol": options.rtol, "atol": float(options.atol[0])}
    restored = {"projection_tolerance": options.projection_tolerance} if options.project else {}
    damped = {"baumgarte_gain": plan.baumgarte_gain} if plan.baumgarte_gain else {}
    carried = {"carried_share": run.carried_share} if run.carried_share else {}
    return accuracy | restored | damped | carried | {"samples": len(plan.times)}


def _reactions(system: System, plan: Plan, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
    """Evaluate joint reactions at the output times."""
    if not plan.settings.reactions:
        return {}
    system.set_baumgarte(0.0)
    return system.reactions_over(times, states)
