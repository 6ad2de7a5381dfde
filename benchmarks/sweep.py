"""Work-precision sweeps: every method's ladder, accuracy judged and the loop timed alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

from cross_checks import engines as registry
from cross_checks import ladder
from cross_checks.compare import evaluate
from cross_checks.engine import Method
from cross_checks.record import Record
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

REPEATS = 5  # timed runs of a setting, of which the fastest counts
REPEAT_BUDGET = 0.5  # s of loop time after which no more repeats are made
LONGEST = 5.0  # s of loop time after which a ladder climbs no further
HOPELESS = frozenset({"cannot", "engine-missing"})

Progress = Callable[[int, int, str], None]  # (methods done, of how many, what comes next)


def sweep(
    scene: Scene,
    engines: Collection[str] | None = None,
    methods: Collection[str] | None = None,
    progress: Progress | None = None,
) -> Iterator[Record]:
    """Yield a record for every rung of every method's ladder; runs are serial, because they are timed.

    The first run of a setting warms up and is judged; the fastest of the repeats is its loop time.
    ValueError where an engine or a method is unknown.
    """
    tasks = _tasks(engines, methods)
    for done, (engine, method) in enumerate(tasks):
        if progress is not None:
            progress(done, len(tasks), f"{engine} {method.name if method else ''}".strip())
        if method is None:
            yield evaluate(scene, engine, Settings())
        else:
            yield from _climb(scene, engine, method)
    if progress is not None:
        progress(len(tasks), len(tasks), "")


def _tasks(engines: Collection[str] | None, methods: Collection[str] | None) -> list[tuple[str, Method | None]]:
    found: list[tuple[str, Method | None]] = []
    for engine in registry.names() if engines is None else engines:
        try:
            offered = registry.get(engine).methods()
        except registry.EngineMissing:
            found.append((engine, None))
            continue
        found += [(engine, method) for method in offered if methods is None or method.name in methods]
    known = {method.name for _, method in found if method is not None}
    unknown = sorted(set(methods or ()) - known)
    if unknown:
        raise ValueError(f"method = {', '.join(unknown)} is offered by none of the engines asked")
    return found


def _climb(scene: Scene, engine: str, method: Method) -> Iterator[Record]:
    times = ladder.grid(scene)
    for settings in ladder.rungs(method, scene):
        record = evaluate(scene, engine, settings, times)
        yield _timed(scene, record, settings)
        if record.status in HOPELESS or record.times.get("loop_s", 0.0) > LONGEST:
            return


def _timed(scene: Scene, record: Record, settings: Settings) -> Record:
    """Repeat the run without judging it and keep the fastest loop."""
    if record.status != "success":
        return record
    engine, times = registry.get(record.engine), ladder.grid(scene)
    loops: list[float] = []
    while len(loops) < REPEATS and sum(loops) < REPEAT_BUDGET:
        loops.append(engine.run(scene, settings, times).timing.loop_s)
        if loops[-1] <= 0.0:  # an engine that measures nothing would repeat for nothing
            break
    spread = {"loop_s": min(loops), "loop_median_s": sorted(loops)[len(loops) // 2], "loop_runs": float(len(loops))}
    return replace(record, times=record.times | spread)
