"""Many runs in vector lanes: of one scene from many starts, or of scenes of one build."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.relative.system import RelativePlanarSystem
from mbs_ref.cores.system import Poses
from mbs_ref.run.lanes import NOTE, Bunch, alike, pieces, runs_in_lanes
from mbs_ref.run.legs import Run
from mbs_ref.run.many import shared
from mbs_ref.run.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.self_checks.consistent_start import consistent_start
from mbs_ref.self_checks.error_estimate import all_beside, companion_plan
from mbs_ref.settings import Settings
from mbs_ref.simulate.assembly import or_stopped, sampled, trajectory, with_estimate
from mbs_ref.simulate.one_run import compiled
from mbs_ref.trajectory import Timing, Trajectory


class Case(NamedTuple):
    """A scene and the states that it is to start from."""

    system: RelativePlanarSystem
    plan: Plan
    told: np.ndarray  # (n, n_told) of the redundant system
    build_s: float


class Begun(NamedTuple):
    """A case whose starts have been looked at."""

    bunch: Bunch
    said: dict[int, list[str]]  # of the starts that keep the constraints: what was done to them
    stopped: dict[int, Trajectory]  # of the others


def starts_in_lanes(
    scene: Scene, starts: Poses, settings: Settings, times: np.ndarray | None, threads: int
) -> list[Trajectory]:
    """Return the trajectory from each of n starts (n, n_bodies, ...), in the scene's relative coordinates."""
    first = _case(scene, settings, times)
    told, of_thread = first.system.redundant.states_of(starts), threading.local()

    def piece(part: slice) -> list[Trajectory]:
        if not hasattr(of_thread, "system"):
            of_thread.system = first.system.twin()
        return _side_by_side([first._replace(system=of_thread.system, told=told[part].copy())])[0]

    work = pieces(len(told), threads, len(first.plan.times) * told.shape[1])
    return [path for paths in shared(piece, work, threads, alone=0) for path in paths]


def scenes_in_lanes(
    scenes: list[Scene], settings: Settings, times: np.ndarray | None, threads: int
) -> list[Trajectory]:
    """Return the trajectory of each scene from its own start, in relative coordinates."""

    def piece(part: slice) -> list[Trajectory]:
        cases = [or_stopped(scene, lambda scene=scene: _case(scene, settings, times)) for scene in scenes[part]]
        paths = iter(_side_by_side([case for case in cases if isinstance(case, Case)]))
        return [next(paths)[0] if isinstance(case, Case) else case for case in cases]

    outputs = settings.samples if times is None else len(times)
    size = outputs * max((6 * len(scene.bodies) for scene in scenes), default=1)
    work = pieces(len(scenes), threads, size)
    return [path for paths in shared(piece, work, threads, alone=0) for path in paths]


def _case(scene: Scene, settings: Settings, times: np.ndarray | None) -> Case:
    """Return a scene with its own start."""
    plan, system, build_s = compiled(scene, settings.model_copy(update={"coordinates": "relative"}), times)
    assert isinstance(system, RelativePlanarSystem)
    told = system.redundant.initial_state()[None]
    return Case(system, replace(plan, notes=(*plan.notes, NOTE)), told, build_s)


def _side_by_side(cases: list[Case]) -> list[list[Trajectory]]:
    """Return what `simulated` does from the states of each case, side by side."""
    began = time.perf_counter()
    begun = [_begun(case) for case in cases]
    bunches = [one.bunch for one in begun]
    for bunch in bunches[:1]:  # compiles, outside of what is timed
        runs_in_lanes([bunch._replace(starts=bunch.starts[:0])])
    ready = (time.perf_counter() - began) / max(1, sum(len(case.told) for case in cases))
    runs = _runs(bunches)
    companions = _companions(bunches)
    times = [Timing(build_s=case.build_s, first_call_s=ready, loop_s=0.0) for case in cases]
    return [_told(*one) for one in zip(begun, times, runs, companions, strict=True)]


def _begun(case: Case) -> Begun:
    system, settings = case.system, case.plan.settings
    found = [or_stopped(system.scene, lambda y=y: consistent_start(system.redundant, y, settings)) for y in case.told]
    said = {k: one for k, one in enumerate(found) if not isinstance(one, Trajectory)}
    halted = {k: one for k, one in enumerate(found) if isinstance(one, Trajectory)}
    return Begun(Bunch(system, case.plan, system.all_reduced(case.told[[*said]])), said, halted)


def _runs(bunches: list[Bunch], refine: int = 1) -> list[list[Run]]:
    """Return the runs of each bunch; those that are alike go side by side."""
    groups: dict[bytes, list[int]] = {}
    for k, bunch in enumerate(bunches):
        groups.setdefault(alike(bunch), []).append(k)
    runs: dict[int, list[Run]] = {}
    for places in groups.values():
        runs |= zip(places, runs_in_lanes([bunches[k] for k in places], refine), strict=True)
    return [runs[k] for k in range(len(bunches))]


def _companions(bunches: list[Bunch]) -> list[list[Run]] | list[None]:
    """Return the runs that the estimates of the errors need, where they are asked for."""
    if not bunches or bunches[0].plan.settings.estimate == "off":
        return [None] * len(bunches)
    finer = [companion_plan(bunch.system, bunch.plan) for bunch in bunches]
    others = [bunch._replace(plan=plan) for bunch, (plan, _) in zip(bunches, finer, strict=True)]
    return _runs(others, refine=finer[0][1])


def _told(begun: Begun, timing: Timing, runs: list[Run], others: list[Run] | None) -> list[Trajectory]:
    """Return the trajectories of a case, in the order of its starts."""
    (system, plan, _), paths = begun.bunch, dict(begun.stopped)
    samples = sampled(system, plan, runs)
    seen = [sample.poses for sample in samples]
    companions = [None] * len(runs) if others is None else all_beside(system, seen, runs, others)
    for (k, said), run, companion, sample in zip(begun.said.items(), runs, companions, samples, strict=True):
        spent = replace(timing, loop_s=run.loop_s)
        path = trajectory(system, plan, run, [*plan.notes, *said], spent, sample)
        paths[k] = with_estimate(system, plan, run, path, companion)
    return [paths[k] for k in range(len(paths))]
