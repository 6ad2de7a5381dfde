"""simulate(scene, settings) -> Trajectory: a plan, a consistent start, the legs, an estimate of the error."""

import itertools
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import touching
from mbs_ref.settings import Settings
from mbs_ref.simulate import start_checks as checks
from mbs_ref.simulate.diagnosis import singular_passage, unseen_forces
from mbs_ref.simulate.error_estimate import ENDED, estimated
from mbs_ref.simulate.legs import Run, finite_part, run_legs, start_run
from mbs_ref.simulate.linearised import unstable_passage, unstable_step
from mbs_ref.simulate.method_choice import after_first_steps, choose_plan, without
from mbs_ref.simulate.plan import Plan
from mbs_ref.trajectory import Estimate, Status, Timing, Trajectory

BROKEN_DOWN = frozenset({Status.NOT_CONVERGED, Status.NON_FINITE, Status.STEP_TOO_SMALL})  # the method failed


_begun: set[tuple[str, tuple[str, ...], str]] = set()  # cores, their answers and methods that are compiled


class Samples(NamedTuple):
    """Poses and forces at the outputs of a run."""

    poses: Poses
    reactions: dict[str, np.ndarray]
    contacts: dict[str, np.ndarray]
    pivots: np.ndarray | None = None  # (n_t,) smallest relative pivot of the closures, if it was computed

    def at(self, place: slice) -> "Samples":
        """Return those at some outputs."""
        poses = Poses(*(part[place] for part in self.poses))
        reactions, contacts = ({name: part[place] for name, part in forces.items()} for forces in self[1:3])
        return Samples(poses, reactions, contacts, None if self.pivots is None else self.pivots[place])


def all_samples(systems: list[System], plan: Plan, runs: list[Run]) -> list[Samples]:
    """Return the samples of the last run of each system, evaluated for all runs at once where they share one."""
    if not runs:
        return []
    system, ends = systems[0], np.cumsum([0, *(len(run.times) for run in runs)]).tolist()
    places = list(itertools.starmap(slice, itertools.pairwise(ends)))
    full = system.all_full(np.concatenate([run.states for run in runs]))
    poses = system.redundant.poses(full)
    if system.event_sources:
        each, every = zip(systems, runs, places, strict=True), Samples(poses, {}, {})
        return [sampled(own, plan, run.times, full[part], every.at(part).poses) for own, run, part in each]
    every = sampled(system, plan, np.concatenate([run.times for run in runs]), full, poses, len(runs) >= WIDTH)
    return [every.at(place) for place in places]


def sampled(
    system: System, plan: Plan, times: np.ndarray, full: np.ndarray, poses: Poses, in_lanes: bool = False
) -> Samples:
    """Return the samples at the states `full` (n_t, n_full) of the last run, as `system.redundant` has them."""
    if not plan.settings.reactions:
        return Samples(poses, {}, {})
    own = system.redundant
    own.set_baumgarte(0.0)
    contacts, pivots = own.contact_forces(times, full) if own.scene.contacts else {}, np.empty(len(times))
    return Samples(poses, own.reactions_over(times, full, pivots, in_lanes), contacts, pivots)


def is_estimated(plan: Plan, run: Run) -> bool:
    """Return whether the error of a run is to be estimated."""
    return run.status in ENDED and plan.settings.estimate == "on"


def trajectory(
    system: System, plan: Plan, run: Run, notes: list[str], timing: Timing, samples: Samples,
    estimate: Estimate | None = None,
) -> Trajectory:  # fmt: skip
    """Return the trajectory of a run with the estimate of its error, if that `is_estimated`, and notes on both."""
    times, states, poses, status, message = run.times, run.states, samples.poses, run.status, run.message
    remarks = singular_passage(system, times, states, samples.pivots)
    if status in ENDED:
        remarks += unstable_passage(system, plan, times, states)
        if is_estimated(plan, run):
            remarks += unseen_forces(system, times, poses)
            status, message, remark = _judged(run, estimate)
            remarks += (remark,) if remark else ()
    chosen = (f"method auto is {plan.integrator.name}: {plan.reason}",) if plan.reason else ()
    return Trajectory(
        times=times, **poses._asdict(), reactions=samples.reactions, contacts=samples.contacts,
        status=status, message=message,
        **{name: count for name, count in run.counts._asdict().items() if name != "switches"},
        method_switches=run.counts.switches if plan.integrator.switches else None, timing=timing,
        step_compliance=np.column_stack((times, run.compliance)),
        notes=(*chosen, *notes, *_other_methods(plan, run), *remarks), method=plan.integrator.name,
        reason=plan.reason, used=_used(plan, run), estimate=estimate,
        event_times=system.contact_events() if system.event_sources else None, event_names=system.event_sources,
    )  # fmt: skip


def _judged(run: Run, estimate: Estimate | None) -> tuple[Status, str, str]:
    """Return the status and the message of a run with this estimate, and a note if it is large."""
    if estimate is None:
        reason = "interrupted while a second run estimated the error of this one, which is complete"
        return Status.INTERRUPTED, reason, ""
    remark = estimate.remark()
    if estimate.is_void:
        return Status.UNRESOLVED, f"no output has a digit: {remark}", ""
    return run.status, run.message, remark


def _other_methods(plan: Plan, run: Run) -> tuple[str, ...]:
    """Return notes on changes of the method's family, and on the share of the time that DOP853 integrated."""
    name, families, share = plan.integrator.name, plan.integrator.switches, run.carried_share
    changed = (f"{name} changed {run.counts.switches} times between {families}",) if families else ()
    carried = (f"DOP853 carried {name} past singular poses, for {share:.2g} of the time",) if share else ()
    return changed + carried


def _used(plan: Plan, run: Run) -> dict[str, float]:
    """Return the settings in use, defaults included, and the share of the time that another method integrated."""
    options = plan.options
    accuracy = {"step": options.step} if options.step else {"rtol": options.rtol, "atol": float(options.atol[0])}
    restored = {"projection_tolerance": options.projection_tolerance} if options.project else {}
    damped = {"baumgarte_gain": plan.baumgarte_gain} if plan.baumgarte_gain else {}
    carried = {"carried_share": run.carried_share} if run.carried_share else {}
    return accuracy | restored | damped | carried | {"samples": len(plan.times)}


def empty(scene: Scene, status: Status, message: str) -> Trajectory:
    """Return the trajectory of a run that did not start."""
    return Trajectory.empty(len(scene.bodies), scene.dimension, status, message)


def or_empty[T](scene: Scene, make: Callable[[], T], refusal: type[ValueError] = checks.UnsoundScene) -> T | Trajectory:
    """Return make(), or a trajectory without samples: `inconsistent` for InconsistentScene, `refused` for `refusal`."""
    try:
        return make()
    except checks.InconsistentScene as error:
        return empty(scene, Status.INCONSISTENT, str(error))
    except refusal as error:
        return empty(scene, Status.REFUSED, str(error))


def simulate(
    scene: Scene, settings: Settings | None = None, times: np.ndarray | None = None, start: Poses | None = None
) -> Trajectory:
    """Integrate a scene with the in-house solver.

    `times` (n_t,) in s start at 0 and increase; without them the settings define an even grid, of multiples of the step
    for fixed-step methods. `start` replaces the scene's own poses and velocities at t = 0 (one sample of each); joints
    stay where the scene has them on the bodies. Raises ValueError for contradictory settings or an invalid start,
    UnsoundScene for invalid parts, and InconsistentScene if the initial conditions violate a constraint (unless
    `project_initial` is set). Every later failure is a status with a message; Ctrl-C returns the samples so far.

    A run that ends well is repeated with steps of another size or a tenth of its tolerances, to estimate its error
    (simulate/error_estimate.py). Its status is `unresolved` if no output after the start has a correct digit. The
    second run is outside of `timing`; estimate = 'off' omits it.

    With method = 'auto' the scene's parts and the first steps determine the method; the trajectory states it and the
    reason. If the chosen method fails, the default method repeats the run.
    """
    if start is not None:
        checks.check_starts(scene, start, count=1)
    settings = settings or Settings()
    plan, system, build_s = compiled(scene, settings, times)
    own = system.redundant
    y = own.initial_state() if start is None else own.states_of(start)[0]
    path = simulated(system, plan, y, build_s)
    if not (system.event_sources or system.calls_users or touching(scene)):
        _reset(system)
        _idle[scene.dimension] = scene, settings.coordinates, system
    return path


def _reset(system: System) -> None:
    """Undo what a run without events sets."""
    system.set_mode_time(0.0)
    system.set_baumgarte(0.0)


_idle: dict[int, tuple[Scene, str, System]] = {}  # dimension -> the last scene, compiled, if its runs change no more


def compiled(scene: Scene, settings: Settings, times: np.ndarray | None) -> tuple[Plan, System, float]:
    """Return the plan, the system and the time to build it (s), as `simulate` begins."""
    checks.require_sound(scene)
    plan = choose_plan(scene, settings, times)
    started = time.perf_counter()
    known, its, system = _idle.pop(scene.dimension, (None, "", None))
    if system is None or known is not scene or its != settings.coordinates:
        system = compile_scene(scene, settings.coordinates)
    return plan, system, time.perf_counter() - started


def simulated(system: System, plan: Plan, y: np.ndarray, build_s: float = 0.0) -> Trajectory:
    """Return the run from a state y of `system.redundant`, as `simulate` does."""
    began, scene = time.perf_counter(), system.scene
    _reset(system)
    repairs = checks.consistent_start(system.redundant, y, plan.settings)
    y = system.reduced(y)
    rank = checks.rank_at_start(system, y)
    notes = [*plan.notes, *repairs, *checks.redundancy(system, rank)]
    if rank is not None and rank < system.n_constraints:
        branches = checks.ambiguous_start(system, y, rank)
        if branches:
            return empty(scene, Status.SINGULAR, branches)
    start_run(system, plan, y)
    plan = after_first_steps(system, plan, y)
    refusal = unstable_step(system, plan, y)
    if refusal:
        return empty(scene, Status.REFUSED, refusal)
    plan.integrator.prepare(system)
    begun = system.CORE, system.answered, plan.integrator.name
    if begun not in _begun:
        _first_call(system, plan, y)
        _begun.add(begun)
    ready = time.perf_counter()
    run, full, poses = _run(system, plan, y.copy())
    if plan.reason and run.status in BROKEN_DOWN and plan.integrator.name != DEFAULT:
        plan, system = without(scene, plan, run.message), system.twin()
        run, full, poses = _run(system, plan, y)
    timing = Timing(build_s=build_s, first_call_s=ready - began, loop_s=run.loop_s)
    samples = sampled(system, plan, run.times, full, poses)
    estimate = estimated(system, plan, run, poses) if is_estimated(plan, run) else None
    return trajectory(system, plan, run, notes, timing, samples, estimate)


def _run(system: System, plan: Plan, y: np.ndarray) -> tuple[Run, np.ndarray, Poses]:
    """Return the run from y, which is overwritten by the state where it ends; states of `redundant` and poses."""
    start_run(system, plan, y)
    run = run_legs(system, plan, y)
    with np.errstate(all="ignore"):
        full = system.all_full(run.states)
        poses = system.redundant.poses(full)
    run = finite_part(run, poses)
    count = len(run.times)
    return run, full[:count], Poses(*(part[:count] for part in poses))


def _first_call(system: System, plan: Plan, y: np.ndarray) -> None:
    """Integrate a tiny leg on a copy: it compiles the method, or loads it from the cache, outside the timed loop."""
    span = min(1e-9, plan.times[1])
    with np.errstate(all="ignore"):
        options = plan.options._replace(max_steps=2)
        plan.integrator.advance(system, options, progress(0.0), y.copy(), np.array([0.0, span]))
