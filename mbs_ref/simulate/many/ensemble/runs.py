"""Run an ensemble in portions, and store its samples."""

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.integrators import STIFF
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate, simulate_scenes, simulate_starts
from mbs_ref.simulate.error_estimate import ENDED
from mbs_ref.simulate.legs import start_run
from mbs_ref.simulate.many.ensemble.design import Design
from mbs_ref.simulate.many.ensemble.variants import Variants, own_start
from mbs_ref.simulate.many.lanes import NOTE, processors, shared, why_not_in_lanes
from mbs_ref.simulate.method_choice import AUTO, after_first_steps
from mbs_ref.simulate.one_run import compiled, or_empty
from mbs_ref.trajectory import Status, Trajectory

LARGEST = 2 * 2**30  # bytes of samples that are stored
QUICK_S = 2.0  # s; a shorter portion is followed by one four times larger, which sets the pace of progress reports
Report = Callable[[int, int], None]  # runs done, of how many


@dataclass(frozen=True)
class Ensemble:
    """Many runs of one scene; n_runs is the number of completed runs.

    Samples are NaN after a declared event ended a run, and for failed runs.
    """

    scene: Scene  # without variations
    design: Design
    settings: Settings
    times: np.ndarray  # (n_t,) s
    samples: Poses  # (n_runs, n_t, n_bodies, ...) as a Trajectory has them
    statuses: tuple[Status, ...]
    messages: tuple[str, ...]
    methods: tuple[str, ...]
    reached: np.ndarray  # (n_runs,) s, the time of the last sample, an event's own included; NaN if there is none
    errors: np.ndarray  # (n_runs, n_t, 2) m and rad, by each run's own estimate; NaN if there is none
    corrections: np.ndarray  # (n_runs, 2) largest corrections of projected starts: m or rad, m/s or rad/s
    how: tuple[str, ...]  # notes on the use of lanes, or the reason against them
    marks: tuple[tuple[int, float], ...]  # completed runs, and s since the beginning, after each portion

    @property
    def wall_s(self) -> float:
        """Seconds of all runs, with their error estimates."""
        return self.marks[-1][1] if self.marks else 0.0

    @property
    def runs_per_s(self) -> float:
        """The pace after the first portion, which loads the solver; of all runs if there is one portion."""
        first, begun = self.marks[0] if len(self.marks) > 1 else (0, 0.0)
        return (len(self.statuses) - first) / (self.wall_s - begun) if self.marks else 0.0

    @property
    def is_complete(self) -> bool:
        return len(self.statuses) == self.design.n_runs

    @property
    def ended_well(self) -> np.ndarray:
        """Which runs reached every output time (n_runs,); the statistics use these."""
        return np.array([status is Status.SUCCESS for status in self.statuses], dtype=bool)

    @property
    def counts(self) -> dict[str, int]:
        """The number of runs of each status, most first."""
        return dict(Counter(str(status) for status in self.statuses).most_common())


def run_ensemble(
    variants: Variants, design: Design, settings: Settings, threads: int | None = None, report: Report | None = None
) -> Ensemble:
    """Run a design; after Ctrl-C the result holds the completed runs.

    Runs of one scene, or of scenes with one structure, use vector lanes if they can. The default method is DOP853 in
    lanes, and else "auto" for each run, as it is where the scene's own run is stiff. ValueError if the samples do not
    fit into memory, and as `simulate` raises it for settings.
    """
    reason = why_not_in_lanes(variants.source.scene, settings) or _why_stiff(variants.source.scene, settings)
    settings, times = _settled(variants.source.scene, settings, may_choose=bool(reason))
    store = _Store(variants.source.scene, design, settings, times, reason)
    values, began = design.values, time.perf_counter()
    marks: list[tuple[int, float]] = []
    try:
        for portion in _portions(design.n_runs, 8 * processors(threads)):
            jobs = _jobs(variants, values[portion])
            paths = _paths(variants, jobs, settings, threads, lanes=not reason)
            if any(path.status is Status.INTERRUPTED for path in paths):
                break
            store.add(portion.start, paths, jobs)
            marks.append((portion.stop, time.perf_counter() - began))
            if report is not None:
                report(portion.stop, design.n_runs)
    except KeyboardInterrupt:
        pass
    return store.ensemble(tuple(marks))


def _why_stiff(scene: Scene, settings: Settings) -> str:
    """Return why a run is cheaper by an implicit method, if the method is not set, or nothing."""
    if settings.method is not None:
        return ""
    chosen = settings.model_copy(update={"method": AUTO, "t_end": settings.t_end or scene.duration})
    plan, system, _ = compiled(scene, chosen, None)
    y = system.initial_state()
    start_run(system, plan, y)
    plan = after_first_steps(system, plan, y)
    return plan.reason if plan.integrator.name == STIFF else ""


def _settled(scene: Scene, settings: Settings, may_choose: bool) -> tuple[Settings, np.ndarray]:
    """Return settings and output times of all runs; the method is "auto" if none is set and `may_choose`."""
    common = {"t_end": settings.t_end or scene.duration, "reactions": False}
    method = AUTO if settings.method is None and may_choose else settings.method
    settled = settings.model_copy(update=common | {"method": method})
    return settled, compiled(scene, settled, None)[0].times


def _portions(count: int, first: int) -> Iterator[slice]:
    """Yield portions of the runs, growing while they are quick."""
    done, size = 0, first
    while done < count:
        began, stop = time.perf_counter(), min(done + size, count)
        yield slice(done, stop)
        done, size = stop, 4 * size if time.perf_counter() - began < QUICK_S else size


class _Job(NamedTuple):
    """The scene and the start of a run."""

    scene: Scene
    start: Poses | None  # one sample of each; None where it is the scene's own


def _jobs(variants: Variants, values: np.ndarray) -> list[_Job | Trajectory]:
    """Return the jobs of a portion; an impossible one is replaced by a trajectory without samples, with the reason."""
    scene = variants.source.scene
    if not variants.is_one_scene:

        def job(one: np.ndarray) -> _Job:
            varied = variants.scene(one)
            return _Job(varied, variants.start(varied, one) if variants.moves else None)

        return [or_empty(scene, lambda one=one: job(one), ValueError) for one in values]
    together = variants.starts(values)
    return [_Job(scene, Poses(*(part[k : k + 1] for part in together))) for k in range(len(values))]


def _paths(
    variants: Variants, jobs: list[_Job | Trajectory], settings: Settings, threads: int | None, lanes: bool
) -> list[Trajectory]:
    there = {k: job for k, job in enumerate(jobs) if isinstance(job, _Job)}
    starts = [job.start for job in there.values() if job.start is not None]
    if variants.is_one_scene:
        together = Poses(*(np.concatenate(parts) for parts in zip(*starts, strict=True)))
        done = simulate_starts(variants.source.scene, together, settings, None, threads, lanes)
    elif lanes and not starts:
        done = simulate_scenes([job.scene for job in there.values()], settings, None, threads, lanes)
    else:

        def path(job: _Job) -> Trajectory:
            return or_empty(job.scene, lambda: simulate(job.scene, settings, None, job.start), ValueError)

        done = shared(path, list(there.values()), threads)
    stand_in = {k: job for k, job in enumerate(jobs) if isinstance(job, Trajectory)}
    paths = stand_in | dict(zip(there, done, strict=True))
    return [paths[k] for k in range(len(jobs))]


class _Store:
    """Arrays for the samples of all runs."""

    def __init__(self, scene: Scene, design: Design, settings: Settings, times: np.ndarray, reason: str) -> None:
        self.scene, self.design, self.settings, self.times = scene, design, settings, times
        shape = (design.n_runs, len(times))
        parts = [part.shape[1:] for part in own_start(scene)]
        numbers = shape[0] * shape[1] * (2 + sum(math.prod(part) for part in parts))
        if 8 * numbers > LARGEST:
            raise ValueError(
                f"the samples of {shape[0]} runs at {shape[1]} times would take {8 * numbers / 2**30:.1f} GiB; "
                f"allowed: {LARGEST / 2**30:g} GiB, by fewer runs or --samples"
            )
        self.samples = Poses(*(np.full((*shape, *part), np.nan) for part in parts))
        self.errors, self.corrections = np.full((*shape, 2), np.nan), np.zeros((shape[0], 2))
        self.reached = np.full(shape[0], np.nan)
        self.ends: list[tuple[Status, str, str]] = []  # status, message and method
        self.how = {f"not in lanes: {reason}": None} if reason else {}

    def add(self, first: int, paths: Sequence[Trajectory], jobs: Sequence[_Job | Trajectory]) -> None:
        """Store the samples of a portion of the runs."""
        for k, (path, job) in enumerate(zip(paths, jobs, strict=True), first):
            self.ends.append((path.status, path.message, path.method))
            self.how |= dict.fromkeys(note for note in path.notes if note.startswith((NOTE, "not in lanes")))
            if path.status in ENDED:
                self._store(k, path)
                if self.settings.project_initial and isinstance(job, _Job):
                    apart = farthest(job.scene, path, job.start or own_start(job.scene))
                    self.corrections[k] = np.fmax(apart[::2], apart[1::2])

    def _store(self, k: int, path: Trajectory) -> None:
        self.reached[k] = path.times[-1]
        count = int(np.sum(self.times <= path.times[-1]))  # a later one is an event's own sample
        for samples, part in zip(self.samples, Poses.of(path), strict=True):
            samples[k, :count] = part[:count]
        if path.estimate is not None:
            components = path.estimate.components[:count, :2]
            self.errors[k, :count] = components * (path.estimate.length, 1.0)

    def ensemble(self, marks: tuple[tuple[int, float], ...]) -> Ensemble:
        """Return the ensemble of the completed runs."""
        done = marks[-1][0] if marks else 0
        statuses, messages, methods = zip(*self.ends[:done], strict=True) if done else ((), (), ())
        return Ensemble(
            self.scene, self.design, self.settings, self.times, Poses(*(part[:done] for part in self.samples)),
            statuses, messages, methods, self.reached[:done], self.errors[:done], self.corrections[:done],
            tuple(self.how), marks,
        )  # fmt: skip
