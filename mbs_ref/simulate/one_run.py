"""simulate(scene, settings) -> Trajectory: a plan, a consistent start, the legs, an estimate of the error."""

import time

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.assembly import empty, sampled, trajectory, with_estimate
from mbs_ref.simulate.legs import Run, finite_part, run_legs, start_run
from mbs_ref.simulate.linearised import unstable_step
from mbs_ref.simulate.method_choice import after_first_steps, choose_plan, without
from mbs_ref.simulate.plan import Plan
from mbs_ref.simulate.start.consistent import consistent_start, rank_at_start, redundancy
from mbs_ref.simulate.start.soundness import ambiguous_start, check_starts, require_sound
from mbs_ref.trajectory import Status, Timing, Trajectory

BROKEN_DOWN = frozenset({Status.NOT_CONVERGED, Status.NON_FINITE, Status.STEP_TOO_SMALL})  # the method failed


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
    """Return the run from a state y of `system.redundant`, as `simulate` does; `warm` if this plan has run before."""
    began, scene = time.perf_counter(), system.scene
    system.set_mode_time(0.0)
    system.set_baumgarte(0.0)
    repairs = consistent_start(system.redundant, y, plan.settings)
    y = system.reduced(y)
    rank = rank_at_start(system, y)
    notes = [*plan.notes, *repairs, *redundancy(system, rank)]
    if rank is not None and rank < system.n_constraints:
        branches = ambiguous_start(system, y, rank)
        if branches:
            return empty(scene, Status.SINGULAR, branches)
    start_run(system, plan, y)
    plan = after_first_steps(system, plan, y)
    refusal = unstable_step(system, plan, y)
    if refusal:
        return empty(scene, Status.REFUSED, refusal)
    if not warm:
        _first_call(system, plan, y)
    ready = time.perf_counter()
    run = _run(system, plan, y.copy())
    if plan.reason and run.status in BROKEN_DOWN and plan.integrator.name != DEFAULT:
        plan, system = without(scene, plan, run.message), system.twin()
        run = _run(system, plan, y)
    timing = Timing(build_s=build_s, first_call_s=ready - began, loop_s=run.loop_s)
    path = trajectory(system, plan, run, notes, timing, sampled(system, plan, [run])[0])
    return with_estimate(system, plan, run, path)


def _run(system: System, plan: Plan, y: np.ndarray) -> Run:
    """Return the run from y, which is overwritten by the state where it ends."""
    start_run(system, plan, y)
    return finite_part(system, run_legs(system, plan, y))


def _first_call(system: System, plan: Plan, y: np.ndarray) -> None:
    """Integrate a tiny leg on a copy: it compiles the method, or loads it from the cache, outside the timed loop."""
    span = min(1e-9, plan.times[1])
    with np.errstate(all="ignore"):
        options = plan.options._replace(max_steps=2)
        plan.integrator.advance(system, options, progress(0.0), y.copy(), np.array([0.0, span]))
