"""Many runs in one call: many starts of one scene, or many scenes, shared among threads or side by side in lanes."""

import threading
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.many.lanes import processors, scenes_in_lanes, shared, starts_in_lanes, why_not_in_lanes
from mbs_ref.simulate.one_run import compiled, or_empty, simulate, simulated
from mbs_ref.simulate.start_checks import check_starts
from mbs_ref.trajectory import Trajectory


def simulate_starts(
    scene: Scene,
    starts: Poses,
    settings: Settings | None = None,
    times: np.ndarray | None = None,
    threads: int | None = None,
    lanes: bool = False,
) -> list[Trajectory]:
    """Return a trajectory from each of n starts of one scene, as `simulate(scene, settings, times, start)` does.

    `starts` holds position (n, n_bodies, dimension) m, orientation (n, n_bodies) rad or (n, n_bodies, 4), velocity and
    angular velocity (rad/s) like them, as a Trajectory does. Tolerances follow the scene's own start. `threads` is the
    number of processors unless given. A start that violates a constraint has the status `inconsistent`. Raises
    ValueError for arrays of other shapes, and as `simulate` does.

    Every run is bitwise equal to the run alone: each thread has a system of its own, and a scene with contact modes has
    a new one for every run.

    With `lanes` each thread integrates several runs at once by packed instructions, many times faster, if scene and
    settings allow it (mbs_ref.simulate.many.lanes.why_not_in_lanes): all rigid bodies without a user's function or
    constraint, by DOP853 with tolerances. Trees of known joints use relative coordinates, whatever the settings are,
    and all take the steps of that run alone; sines and sums differ by roundoff. No run depends on the others. A note
    reports the use of lanes, or the reason against them.
    """
    check_starts(scene, starts)
    if not len(starts.position):
        return []
    settings = settings or Settings()
    reason = why_not_in_lanes(scene, settings) if lanes else ""
    if lanes and not reason:
        return starts_in_lanes(scene, starts, settings, times, processors(threads))
    plan, system, build_s = compiled(scene, settings, times)
    plan = replace(plan, notes=(*plan.notes, *_not_in_lanes(reason)))
    states, of_thread = system.redundant.states_of(starts), threading.local()

    def run(y: np.ndarray) -> Trajectory:
        if not hasattr(of_thread, "system") or system.event_sources:
            of_thread.system = system.twin()
        return simulated(of_thread.system, plan, y.copy(), build_s)

    return shared(lambda y: or_empty(scene, lambda: run(y)), list(states), threads)


def simulate_scenes(
    scenes: Iterable[Scene],
    settings: Settings | None = None,
    times: np.ndarray | None = None,
    threads: int | None = None,
    lanes: bool = False,
) -> list[Trajectory]:
    """Return the trajectory of each scene, as `simulate(scene, settings, times)` does.

    An unsound scene has the status `refused`, and one that violates a constraint `inconsistent`. With `lanes`, as in
    `simulate_starts`, scenes of one structure share lanes: the same bodies and joints in the same order and the same
    output times, with masses, places and gravity of their own.
    """
    scenes, settings = list(scenes), settings or Settings()
    reasons = [why_not_in_lanes(scene, settings) if lanes else "" for scene in scenes]

    def run(k: int) -> Trajectory:
        path = or_empty(scenes[k], lambda: simulate(scenes[k], settings, times))
        return replace(path, notes=(*path.notes, *_not_in_lanes(reasons[k])))

    alone = [k for k in range(len(scenes)) if reasons[k] or not lanes]
    paths = dict(zip(alone, shared(run, alone, threads), strict=True))
    others = [k for k in range(len(scenes)) if k not in paths]
    side_by_side = scenes_in_lanes([scenes[k] for k in others], settings, times, processors(threads))
    paths |= zip(others, side_by_side, strict=True)
    return [paths[k] for k in range(len(scenes))]


def _not_in_lanes(reason: str) -> tuple[str, ...]:
    return (f"not in lanes: {reason}",) if reason else ()
