"""Integrate several runs at once, in vector lanes and in threads.

Lanes hold runs of one scene from many starts, or of scenes with one structure. The compiled loops of DOP853, Radau,
Gauss and generalized-alpha release the GIL.
"""

import itertools
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.choice import core_name
from mbs_ref.cores.in_lanes import build_of, figures_of, handles_of
from mbs_ref.cores.relative import no_tree
from mbs_ref.cores.system import Poses, System
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.lanes import Runs, advance_in_lanes, begin_all, next_leg, room_beside, runs_from
from mbs_ref.integrators.stages.tableau import DOP853
from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import traits
from mbs_ref.settings import Settings
from mbs_ref.simulate.error_estimate import Companion, Request, companions, estimating
from mbs_ref.simulate.legs import Counts, LegPlan, Run, planned_legs, reached, run_legs, samples, start_run
from mbs_ref.simulate.one_run import Samples, all_samples, compiled, is_estimated, or_empty, simulated, trajectory
from mbs_ref.simulate.plan import Plan
from mbs_ref.simulate.start_checks import ambiguous_start, consistent_start, rank_at_start, redundancy
from mbs_ref.trajectory import Estimate, Status, Timing, Trajectory

NOTE = f"integrated in {WIDTH} lanes, or alone after a failure there"
MAX_NUMBERS = 4_000_000  # entries of states in one piece of work: 32 MB
PIECES = 4  # pieces of work for each thread, which balances the threads
ROUNDS = 8  # least number of runs of a lane in a piece; lanes are idle at the end of a piece


def processors(threads: int | None) -> int:
    """Return the number of threads: the number of processors unless given."""
    return threads or len(os.sched_getaffinity(0))


def pieces(count: int, threads: int, numbers: int) -> list[slice]:
    """Divide `count` runs, with so many `numbers` of states each, into pieces of work for threads."""
    even = max(ROUNDS * WIDTH, -(-count // (PIECES * threads)))
    most = max(WIDTH, MAX_NUMBERS // (2 * numbers))
    size = min(even, most)
    return [slice(k, min(k + size, count)) for k in range(0, count, size)]


def shared[T, R](run: Callable[[T], R], work: list[T], threads: int | None, alone: int = 1) -> list[R]:
    """Return the result of each piece of work; the first `alone` pieces run first, because they compile.

    Ctrl-C cancels the remaining pieces.
    """
    first = [run(piece) for piece in work[:alone]]
    with ThreadPoolExecutor(processors(threads)) as pool:
        later = [pool.submit(run, piece) for piece in work[alone:]]
        try:
            return first + [one.result() for one in later]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


class Bunch(NamedTuple):
    """Runs of one scene from several states: of the redundant system as given, of the relative one once checked."""

    system: System
    plan: Plan
    starts: np.ndarray  # (n, n_state)
    systems: list[System]  # of each run: one of its own where it has modes of its own, else the same one
    build_s: float = 0.0

    def beside(self, plan: Plan, places: list[int]) -> "Bunch":
        """Return companions of some runs."""
        return Bunch(self.system, plan, self.starts[places], [self.system.beside() for _ in places])


def why_not_in_lanes(scene: Scene, settings: Settings) -> str:
    """Return why runs cannot use lanes, or nothing.

    Lanes support all rigid bodies but those with a user's function or constraint, by DOP853 with tolerances.
    """
    return "; ".join(_reasons(scene, settings))


def _reasons(scene: Scene, settings: Settings) -> Iterator[str]:
    if others := sorted(traits(scene) & {"user-constraint", "user-force"}):
        yield f"scene {scene.name!r} has a {' and a '.join(others)}, which lanes cannot evaluate"
    if settings.method not in (None, DEFAULT) or settings.step is not None:
        yield f"lanes are for {DEFAULT} with tolerances"
    if settings.outputs == "dense":
        yield "outputs = 'dense': lanes end steps at outputs"
    if settings.stabilization == "baumgarte":
        yield "stabilization = 'baumgarte': lanes project"
    if core_name(scene) == "particles":
        yield "particles have a core of their own"


def alike(bunch: Bunch) -> bytes:
    """Return a key that is equal for bunches of one structure and the same times of outputs and breakpoints."""
    return build_of(bunch.system) + bunch.plan.times.tobytes() + np.array(bunch.system.scene.breakpoints()).tobytes()


def runs_in_lanes(bunches: Sequence[Bunch], refine: int = 1) -> list[list[Run]]:
    """Return the runs of bunches with the same key, equal to those of `run_legs`.

    A run that fails is repeated alone, which gives its message. `loop_s` is the mean over the runs.
    """
    planned = planned_legs(bunches[0].system, bunches[0].plan, refine)
    began = time.perf_counter()
    legs = _advanced(bunches, planned)
    loop_s = (time.perf_counter() - began) / max(1, len(legs[-1].code))
    finite = [np.isfinite(one.states).all(axis=(1, 2)) for one in legs]
    succeeded = np.all([legs[-1].code == leg.DONE, *finite], axis=0)
    whole = [leg.Leg(one.states, one.compliance, one.states.shape[1], Status.SUCCESS) for one in legs]
    states, compliance = samples(planned, whole)

    def run(bunch: Bunch, system: System, k: int) -> Run:
        if succeeded[k]:
            return _complete(bunch.plan, legs[-1].now[k], states[k], compliance[k], loop_s)
        return _alone(system, bunch.plan, legs[0].states[k, 0], refine)

    return [[run(bunch, *one) for one in zip(bunch.systems, range(first, last), strict=True)]
            for bunch, (first, last) in zip(bunches, _places(bunches), strict=True)]  # fmt: skip


def _alone(system: System, plan: Plan, start: np.ndarray, refine: int) -> Run:
    y = start.copy()
    start_run(system, plan, y)
    return run_legs(system, plan, y, refine)


def _places(bunches: Sequence[Bunch]) -> list[tuple[int, int]]:
    """Return the first and the last index of each bunch among all runs."""
    ends = np.cumsum([0, *(len(bunch.starts) for bunch in bunches)]).tolist()
    return list(itertools.pairwise(ends))


def _advanced(bunches: Sequence[Bunch], planned: list[LegPlan]) -> list[Runs]:
    """Return the runs after each leg."""
    runs, legs = _started(bunches), list[Runs]()
    room, options = bunches[0].system.room, bunches[0].plan.options
    systems = [system for bunch in bunches for system in bunch.systems]
    n_roots = max((int(system.redundant.groups.contact_modes.roots[0]) for system in systems), default=0)
    side = room_beside(room.figures, room.beside, runs.atol.shape[1], len(DOP853.b), n_roots)
    with np.errstate(all="ignore"):
        for times, *_ in planned:
            runs = next_leg(runs, len(times))
            for system in systems:
                system.set_mode_time(0.5 * (times[0] + times[-1]))
            for bunch, (first, last) in zip(bunches, _places(bunches), strict=True):
                begin_all(bunch.plan.options, runs, first, last, times, DOP853.order)
            advance_in_lanes(room.model, room.work, DOP853, options, runs, side, times, 0, len(runs.code))
            legs.append(runs)
    return legs


def _started(bunches: Sequence[Bunch]) -> Runs:
    """Return the runs at their starts, with the systems in the modes that they have there."""
    for bunch in bunches:
        for system, y in zip(bunch.systems, bunch.starts, strict=True):
            start_run(system, bunch.plan, y)
    handles = np.array([handles_of(system) for bunch in bunches for system in bunch.systems], np.int64)
    figures = np.stack([figures_of(bunch.system) for bunch in bunches])
    atol = np.stack([bunch.plan.options.atol for bunch in bunches])
    scene = np.repeat(np.arange(len(bunches)), [len(bunch.starts) for bunch in bunches])
    tolerance = np.array([bunch.plan.options.projection_tolerance for bunch in bunches])
    starts = np.concatenate([bunch.starts for bunch in bunches])
    return runs_from(handles.reshape(-1, 4), figures, atol, tolerance, scene, starts)


def _complete(plan: Plan, run: leg.Progress, states: np.ndarray, compliance: np.ndarray, loop_s: float) -> Run:
    """Return a run that reached its end."""
    now = leg.figures_of(run)
    counts = Counts(now.steps, now.rejected, now.cut, now.rhs_calls, now.events, 0)
    near = bool(now.near_singular)
    return Run(plan.times, states, compliance, counts, Status.SUCCESS, reached(plan), loop_s, 0.0, near)


class Checked(NamedTuple):
    """A bunch whose starts have been checked."""

    bunch: Bunch  # the consistent starts
    notes: dict[int, list[str]]  # on the corrections of these
    others: dict[int, Trajectory]  # in place of the others: runs alone, and starts that break constraints


def starts_in_lanes(
    scene: Scene, starts: Poses, settings: Settings, times: np.ndarray | None, threads: int
) -> list[Trajectory]:
    """Return the trajectory from each of n starts (n, n_bodies, ...)."""
    first = _case(scene, settings, times)
    states, of_thread = first.system.redundant.states_of(starts), threading.local()

    def piece(part: slice) -> list[Trajectory]:
        if not hasattr(of_thread, "system"):
            of_thread.system = first.system.twin()
        own, some = of_thread.system, states[part].copy()
        systems = [own.twin() if own.event_sources else own for _ in some]
        return _side_by_side([first._replace(system=own, starts=some, systems=systems)])[0]

    work = pieces(len(states), threads, len(first.plan.times) * states.shape[1])
    return [path for paths in shared(piece, work, threads, alone=0) for path in paths]


def scenes_in_lanes(
    scenes: list[Scene], settings: Settings, times: np.ndarray | None, threads: int
) -> list[Trajectory]:
    """Return the trajectory of each scene from its own start."""

    def piece(part: slice) -> list[Trajectory]:
        cases = [or_empty(scene, lambda scene=scene: _case(scene, settings, times)) for scene in scenes[part]]
        paths = iter(_side_by_side([case for case in cases if isinstance(case, Bunch)]))
        return [next(paths)[0] if isinstance(case, Bunch) else case for case in cases]

    outputs = settings.samples if times is None else len(times)
    size = outputs * max((13 * len(scene.bodies) for scene in scenes), default=1)
    work = pieces(len(scenes), threads, size)
    return [path for paths in shared(piece, work, threads, alone=0) for path in paths]


def _case(scene: Scene, settings: Settings, times: np.ndarray | None) -> Bunch:
    """Return a scene with its own start; a tree of known joints is in relative coordinates."""
    coordinates, note = ("cartesian", NOTE) if [*no_tree(scene)] else ("relative", f"{NOTE}, in relative coordinates")
    plan, system, build_s = compiled(scene, settings.model_copy(update={"coordinates": coordinates}), times)
    start, plan = system.redundant.initial_state()[None], replace(plan, notes=(note, *plan.notes))
    return Bunch(system, plan, start, [system], build_s)


def _side_by_side(cases: list[Bunch]) -> list[list[Trajectory]]:
    """Return the trajectories of each case, as `simulated` computes them."""
    began = time.perf_counter()
    checked = [_checked(case) for case in cases]
    bunches = [one.bunch for one in checked]
    for bunch in bunches[:1]:  # compiles, outside of the timing
        runs_in_lanes([bunch._replace(starts=bunch.starts[:0], systems=[])])
    ready = (time.perf_counter() - began) / max(1, sum(len(case.starts) for case in cases))
    runs = _runs(bunches)
    samples = [all_samples(one.systems, one.plan, own) for one, own in zip(bunches, runs, strict=True)]
    estimates = _estimates(bunches, runs, samples)
    times = [Timing(build_s=case.build_s, first_call_s=ready, loop_s=0.0) for case in cases]
    return [_trajectories(*one) for one in zip(checked, times, runs, samples, estimates, strict=True)]


def _estimates(
    bunches: list[Bunch], runs: list[list[Run]], samples: list[list[Samples]]
) -> list[dict[int, Estimate | None]]:
    """Return the estimate of each run's error; companions with the same share of the tolerance are side by side."""
    result: list[dict[int, Estimate | None]] = [{} for _ in bunches]
    waiting = {
        (k, i): estimating(bunch.systems[i], bunch.plan, run, samples[k][i].poses)
        for k, bunch in enumerate(bunches) for i, run in enumerate(runs[k]) if is_estimated(bunch.plan, run)
    }  # fmt: skip
    asked = {place: next(one) for place, one in waiting.items()}
    while asked:
        requests, asked = asked, dict[tuple[int, int], Request]()
        for (k, i), companion in _companions(bunches, runs, samples, requests):
            try:
                asked[k, i] = waiting[k, i].send(companion)
            except StopIteration as end:
                result[k][i] = end.value
    return result


def _companions(
    bunches: list[Bunch], runs: list[list[Run]], samples: list[list[Samples]], requests: dict[tuple[int, int], Request]
) -> Iterator[tuple[tuple[int, int], Companion]]:
    """Yield the companion of each run (bunch, place there) that has a request."""
    shares: dict[str, dict[int, list[int]]] = {}
    for (k, i), request in requests.items():
        shares.setdefault(request.share, {}).setdefault(k, []).append(i)
    for asked in shares.values():
        first = [requests[k, places[0]] for k, places in asked.items()]
        again = [bunches[k].beside(one.plan, places) for one, (k, places) in zip(first, asked.items(), strict=True)]
        found = _runs(again, first[0].refine)
        for request, (k, places), others in zip(first, asked.items(), found, strict=True):
            own, poses = [runs[k][i] for i in places], [samples[k][i].poses for i in places]
            made = companions(bunches[k].system, request, own, poses, others)
            yield from zip(((k, i) for i in places), made, strict=True)


def _checked(case: Bunch) -> Checked:
    system, scene = case.system, case.system.scene
    checks = [or_empty(scene, lambda y=y: _start(case, y)) for y in case.starts]
    notes = {k: one for k, one in enumerate(checks) if not isinstance(one, Trajectory)}
    others = {k: one for k, one in enumerate(checks) if isinstance(one, Trajectory)}
    starts, systems = system.all_reduced(case.starts[[*notes]]), [case.systems[k] for k in notes]
    return Checked(Bunch(system, case.plan, starts, systems), notes, others)


def _start(case: Bunch, y: np.ndarray) -> list[str] | Trajectory:
    """Make a start consistent, and return notes on it; where constraint rows are redundant, the run alone."""
    system, plan = case.system, case.plan
    before, notes = y.copy(), consistent_start(system.redundant, y, plan.settings)
    rank = rank_at_start(system, y)
    if rank is None or rank == system.n_constraints:
        return notes
    missing = system.n_constraints - rank
    if missing == system.n_spare_rows and not ambiguous_start(system, y, rank):
        return [*notes, *redundancy(system, rank)]
    why = f"not in lanes: {missing} constraint rows are redundant"
    return simulated(system.twin(), replace(plan, notes=(why, *plan.notes[1:])), before, case.build_s)


def _runs(bunches: list[Bunch], refine: int = 1) -> list[list[Run]]:
    """Return the runs of each bunch; bunches with the same key share lanes. Other methods' runs go alone."""
    if any(bunch.plan.integrator.name != DEFAULT for bunch in bunches):
        return [[_alone(system, bunch.plan, y, refine) for system, y in zip(bunch.systems, bunch.starts, strict=True)]
                for bunch in bunches]  # fmt: skip
    groups: dict[bytes, list[int]] = {}
    for k, bunch in enumerate(bunches):
        groups.setdefault(alike(bunch), []).append(k)
    runs: dict[int, list[Run]] = {}
    for places in groups.values():
        runs |= zip(places, runs_in_lanes([bunches[k] for k in places], refine), strict=True)
    return [runs[k] for k in range(len(bunches))]


def _trajectories(
    checked: Checked, timing: Timing, runs: list[Run], samples: list[Samples], estimates: dict[int, Estimate | None]
) -> list[Trajectory]:
    """Return the trajectories of a case, in the order of its starts."""
    (_, plan, _, systems, _), paths = checked.bunch, dict(checked.others)
    each = enumerate(zip(checked.notes.items(), systems, runs, samples, strict=True))
    for i, ((k, notes), own, run, sample) in each:
        spent = replace(timing, loop_s=run.loop_s)
        paths[k] = trajectory(own, plan, run, [*plan.notes, *notes], spent, sample, estimates.get(i))
    return [paths[k] for k in range(len(paths))]
