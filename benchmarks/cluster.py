"""The accuracy matrix as independent tasks: in this process, over processes, or over a dask cluster.

A task is one run of the plan; its record does not depend on when, where or after what it ran, so that a
lost worker costs the time of its tasks alone and any scheduler gives the same records.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from cross_checks import engines as registry
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.judge import ladder
from cross_checks.judge.one_run import without_run
from cross_checks.judge.runs import Runs, against, make
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from mbs_ref import scenes
from mbs_ref.settings import Settings

QUICK = (("pendulum", {}), ("pendulum_chain", {"links": 3}), ("n_four_bar", {"loops": 1}))
FULL = (
    *QUICK, ("double_pendulum", {}), ("pendulum_chain", {"links": 10}), ("n_four_bar", {"loops": 2}),
    ("slider_crank", {}), ("driven_pendulum", {}), ("spring_pendulum", {}),
)  # fmt: skip
QUICK_RUNGS = 2  # of each ladder, the coarsest
RETRIES = 5  # times a task may lose its worker


@dataclass(frozen=True)
class Task:
    """One run, in plain data that any machine can rebuild."""

    scene: str
    parameters: tuple[tuple[str, Any], ...]
    engine: str
    settings: tuple[tuple[str, Any], ...]


def plan(quick: bool = False, engines: Sequence[str] | None = None) -> list[Task]:
    """Return every run of the matrix, in an order that is always the same."""
    tasks = []
    for scene, parameters in QUICK if quick else FULL:
        made = scenes.make(scene, **parameters)
        for engine in registry.names() if engines is None else engines:
            for settings in _settings(engine, made, QUICK_RUNGS if quick else None):
                chosen = tuple(settings.model_dump(exclude_none=True, exclude_defaults=True).items())
                tasks.append(Task(scene, tuple(parameters.items()), engine, chosen))
    return tasks


def _settings(engine: str, scene, most: int | None) -> list[Settings]:
    try:
        methods = registry.get(engine).methods()
    except registry.EngineMissing:
        return [Settings()]
    return [settings for method in methods for settings in ladder.rungs(method, scene)[:most]]


def shard[T](tasks: Sequence[T], index: int, count: int) -> list[T]:
    """Return part `index` of `count` (1-based); the parts are disjoint and together everything."""
    if not 1 <= index <= count:
        raise ValueError(f"shard = {index}/{count} must be i/n with 1 <= i <= n")
    return list(tasks[index - 1 :: count])


def _planned(task: Task, status: str, message: str) -> Record:
    scene = scenes.make(task.scene, **dict(task.parameters))
    return without_run(scene, task.engine, Settings(**dict(task.settings)), status, message)


def run_task(task: Task) -> Run:
    """Make one run; the whole task's wall time is times['task_s'], its processor time times['cpu_s']."""
    wall, cpu = time.perf_counter(), time.process_time()
    scene, settings = scenes.make(task.scene, **dict(task.parameters)), Settings(**dict(task.settings))
    run = make(scene, task.engine, settings, ladder.grid(scene))
    spent = {"task_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
    return replace(run, record=replace(run.record, times=run.record.times | spent))


def isolated_task(task: Task, call: Isolated) -> Run:
    """Make one run in another process; a run that is lost there is a status."""
    try:
        return call(run_task, task)
    except Lost as lost:
        return Run(_planned(task, lost.status, str(lost)), None)


def serial(tasks: Iterable[Task], timeout: float) -> Iterator[tuple[Task, Run]]:
    """Yield each task's run, one after the other."""
    with Isolated(timeout=timeout) as call:
        for task in tasks:
            yield task, isolated_task(task, call)


def kept(runs: Runs, task: Task, run: Run) -> Record:
    """Keep a task's run in the store, and return its record held against the scene's truth."""
    scene = scenes.make(task.scene, **dict(task.parameters))
    runs.keep(scene, task.engine, Settings(**dict(task.settings)), run)
    return against(scene, run, runs.truth(scene))


def held(runs: Runs, task: Task) -> Record | None:
    """Return the record of a task whose run the store holds."""
    scene = scenes.make(task.scene, **dict(task.parameters))
    run = runs.held(scene, task.engine, Settings(**dict(task.settings)))
    return None if run is None else against(scene, run, runs.truth(scene))
