"""Runs of scenes, each computed once: what the store lacks is computed in this process or another, and stored."""

import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.engines.elsewhere import processor_time
from cross_checks.isolation.parent import Caller, Lost, direct
from cross_checks.judge.ladder import grid
from cross_checks.judge.measure import error_of, unjudged
from cross_checks.judge.one_run import complete, judged_run, without_run
from cross_checks.metrics.errors import COMPONENTS
from cross_checks.metrics.metric import Judged, figures, from_truth
from cross_checks.records.record import BUSY, WARMED, Record, loop_time, machine
from cross_checks.records.store import Run, Store, run_name, truth_name
from cross_checks.truths import LIMIT_S, seek_truth
from cross_checks.truths.truth import NO_ERROR, NoTruth, Truth, time_limit
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.observables.distance import largest, relative, units_of
from mbs_ref.scene.scales import scales_of

PASSING = frozenset({"timeout", "out-of-memory"})  # the machine's doing: the next one may see the run come back
NOT_COMPARED = NoTruth("runs are stored without a truth, which may become known later")


@dataclass
class Runs:
    """The runs that a store holds or gets."""

    store: Store = field(default_factory=Store)
    call: Caller = direct  # makes the runs; cross_checks.isolation.parent survives engines that do not come back
    computed: int = 0  # runs that were not in the store
    times: np.ndarray | None = None  # (n_t,) s of every run; the judges' grid unless given
    longest: float = np.inf  # s of processor time that a search may spend on a run for a target alone
    time_left: float = np.inf  # s, from when questions are put (answers.py): no run is begun after that

    def grid(self, scene: Scene) -> np.ndarray:
        """Return the times of a scene's runs (n_t,), s."""
        return grid(scene) if self.times is None else self.times

    def judged(self, scene: Scene, engine: str, settings: Settings, truth: Truth | NoTruth) -> Record:
        """Return the record of a run on the judges' grid, compared with a truth."""
        run = self.run(scene, engine, settings)
        return against(scene, run, truth)

    def run(self, scene: Scene, engine: str, settings: Settings, seconds: float = 0.0) -> Run:
        """Return the run; computed unless the store holds it, or it is expected to compute for longer than it may."""
        try:
            held = self.held(scene, engine, settings)
        except engines.EngineMissing as missing:
            return Run(without_run(scene, engine, settings, "engine-missing", str(missing)), None)
        if held is not None:
            return held
        self.computed += 1
        try:
            getattr(self.call, "expect", lambda seconds: None)(seconds)
            run = self.call(make, scene, engine, settings, self.grid(scene))
        except Lost as lost:
            run = Run(without_run(scene, engine, settings, lost.status, str(lost)), None)
        if run.record.status not in PASSING:
            self._keep(run_name(scene, engines.get(engine), settings, self.grid(scene)), run)
        return run

    def _keep(self, name: str, run: Run) -> None:
        """Store a run, and the time of a long loop that had a processor to itself."""
        self.store.keep_run(name, run)
        loop_s = loop_time(run.record)
        if run.host and loop_s > WARMED and run.record.times["cpu_share"] >= BUSY:
            self.store.keep_timings(name, run.host, [loop_s])

    def held(self, scene: Scene, engine: str, settings: Settings) -> Run | None:
        """Return the run that the store holds, under the name that the scene has here: physics alone decided it."""
        stored = self.store.run(run_name(scene, engines.get(engine), settings, self.grid(scene)))
        if stored is None:
            return None
        return replace(stored, record=replace(stored.record, scene=scene.name, parameters=dict(scene.parameters)))

    def truth(self, scene: Scene, times: np.ndarray | None = None) -> Truth | NoTruth:
        """Return the scene's truth at `times` (s; the judges' grid unless given): stored, or computed and stored.

        Return the reason where there is none. One that was stored within a shorter limit of time is computed again.
        """
        requested = self.grid(scene) if times is None else times
        key = truth_name(scene, requested)
        stored = self.store.arrays(key)
        with time_limit(LIMIT_S) as limit:
            if stored is not None and stored[0].get("limit_s", limit) >= limit:
                given: dict[str, Any] = {**stored[0], **stored[1]}
                return NoTruth(**given) if "reason" in given else Truth(**given)
        truth = getattr(self.call, "patient", self.call)(seek_truth, scene, requested)
        self.store.keep_arrays(key, *_parts(truth))
        return truth


def make(scene: Scene, engine: str, settings: Settings, times: np.ndarray) -> Run:
    """Execute a run without comparing it with a truth; one that Ctrl-C cut short is none."""
    wall, cpu = time.perf_counter(), processor_time()
    record, path = complete(judged_run(scene, engine, settings, times, truth=NOT_COMPARED))
    share = (processor_time() - cpu) / max(time.perf_counter() - wall, 1e-9)
    return Run(replace(record, times=record.times | {"cpu_share": share}), path, machine() if path else "")


def against(scene: Scene, run: Run, truth: Truth | NoTruth) -> Record:
    """Return the run's record with its error from a truth."""
    record, path = run.record, run.path
    if path is None or not len(path.times) or isinstance(truth, NoTruth):
        why = (NO_ERROR + truth.reason,) if isinstance(truth, NoTruth) else ()
        return replace(record, notes=(*record.notes, *why))
    judged = Judged(scene, path, truth)
    error, curve = error_of(judged)
    history = record.history | ({} if curve is None else {"error": curve})
    parts = figures({metric.name: metric.curve(judged) for metric in COMPONENTS})
    parts["measures"] = record.measures | parts["measures"]
    return replace(record, error=error, history=history, notes=(*record.notes, *unjudged(error)), **parts)


def gap(scene: Scene, truth: Truth | NoTruth, first: Trajectory | None, second: Trajectory | Truth | None) -> float:
    """Return how far two motions are apart, over the scene's scales; NaN where one of them has no samples.

    What the truth knows counts, as in the error of a run; without a truth every component does.
    """
    if first is None or second is None or not len(first.position) or not len(second.position):
        return np.nan
    if isinstance(truth, NoTruth):
        apart = float(largest(relative(scene, first, second)))
    else:
        apart = float(largest(from_truth(scene, first, truth, second).counted / units_of(scales_of(scene))))
    return apart if np.isfinite(apart) else np.nan


def _parts(truth: Truth | NoTruth) -> tuple[dict, dict[str, np.ndarray]]:
    plain = {key: value for key, value in vars(truth).items() if value is not None}
    arrays = {key: value for key, value in plain.items() if isinstance(value, np.ndarray)}
    return {key: value for key, value in plain.items() if key not in arrays}, arrays
