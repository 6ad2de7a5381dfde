"""simulate(scene, settings) -> Trajectory: a plan, a consistent start, the legs, an estimate of the error."""

from __future__ import annotations

import time

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.run.legs import Run, finite_part, run_legs
from mbs_ref.run.many import check_starts
from mbs_ref.run.method_choice import choose_plan, without
from mbs_ref.run.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.self_checks.consistent_start import consistent_start, rank_at_start, redundancy, unstable_step
from mbs_ref.self_checks.first_steps import after_first_steps
from mbs_ref.self_checks.soundness import ambiguous_start, require_sound
from mbs_ref.settings import Settings
from mbs_ref.simulate.assembly import sampled, trajectory, with_estimate
from mbs_ref.trajectory import Status, Timing, Trajectory

BROKEN_DOWN = frozenset({Status.NOT_CONVERGED, Status.NON_FINITE, Status.STEP_TOO_SMALL})  # a method, not the scene


def simulate(
    scene: Scene, settings: Settings | None = None, times: np.ndarray | None = None, start: Poses | None = None
) -> Trajectory:
    """Integrate a scene with the in-house solver.

    `times` (n_t,) in s start at 0 and increase; without them an even grid follows from the settings, on
    multiples of the step for fixed-step methods. `start` are poses and velocities at t = 0 (one sample of each) in
    place of the scene's own; joints stay where the scene has them on the bodies. Raises ValueError for settings or a
    start that make no sense, UnsoundScene for parts that make none and InconsistentScene where the initial conditions
    break a constraint (unless they are to be projected). Everything later is a status with a sentence; Ctrl-C keeps
    what was computed.

    A run that ends well is made again with half of its step, or a tenth of its tolerances: what the two differ by
    estimates the error (self_checks/error_estimate.py). It is `unresolved` where no output after the start has a digit
    that holds. The second run's time is outside of `timing`; estimate = 'off' leaves it out.

    method = 'auto' leaves the method to what the scene contains and to what its first steps tell; the trajectory says
    which it was and why. Where a method so chosen breaks down, the default makes the run again.
    """
    if start is not None:
        check_starts(scene, start, count=1)
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
    path = trajectory(system, plan, run, notes, timing, sampled(system, plan, [run])[0])
    return with_estimate(system, plan, run, path)


def _run(system: System, plan: Plan, y: np.ndarray) -> Run:
    """Make the run from y, which is left where it ends."""
    system.set_mode_time(0.0)
    system.set_baumgarte(plan.baumgarte_gain)
    system.start_contacts(0.0, y, plan.settings.events != "none")
    return finite_part(system, run_legs(system, plan, y))


def _refused(system: System, reason: str, status: Status = Status.REFUSED) -> Trajectory:
    none = system.poses(np.zeros((0, len(system.initial_state()))))
    return Trajectory(times=np.zeros(0), **none._asdict(), status=status, message=reason)


def _first_call(system: System, plan: Plan, y: np.ndarray) -> None:
    """Make one tiny leg on a copy: it compiles the method, or loads it from the cache, outside the timed loop."""
    span = min(1e-9, plan.times[1])
    with np.errstate(all="ignore"):
        options = plan.options._replace(max_steps=2)
        plan.integrator.advance(system, options, progress(0.0), y.copy(), np.array([0.0, span]))
