"""Run the matrix, each run in a child process, and search along each axis up to where runs are handled.

The next run of a search is where it changes the answer most. The axis has evenly spaced places. Runs are handled but
for one failing stretch of places, up to the end of the axis as a rule; an axis that is not monotone recovers behind it.
A run agrees with that with the odds 1 - LAPSE, and with its own odds that it is handled. Wanted is where the stretch
begins. Two children run at a time, cell after cell.
"""

import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from cross_checks import engines as registry
from cross_checks.engine import Engine, Method, output_times
from cross_checks.extremes import QUICK, UNCHECKED, Extreme, named, settings_for
from cross_checks.extremes.fate import Cell, Fate, Point, judge, made_of
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.isolation.workers import Report, each
from cross_checks.judge.one_run import checked_run
from cross_checks.records.record import MISSING

LAPSE = 0.02  # probability that a run contradicts its place
MONOTONE = 0.95  # probability that nothing is handled beyond the first failure
BETWEEN = 3  # halvings between two listed values, where they are finely searched
TELLS = {False: 0.08, True: 0.02}  # nats that a run must be expected to tell, by `full`


def search(values: Sequence[float], probe: Callable[[float], Point], full: bool) -> list[Point]:
    """Return the runs, mild first: at both ends, and where the boundary is sought."""
    places = refined(values) if full else list(values)
    n, points = len(places), dict[int, Point]()
    first, end = np.triu_indices(n + 1)  # the failing stretch is first <= place < end; none where first = end
    single, at_end = first == end, end == n
    weight = np.where(at_end, MONOTONE / (n + 1), np.where(single, 0.0, (1.0 - MONOTONE) / max(n * (n - 1) / 2, 1)))
    place = np.arange(n)
    fails = (first[:, None] <= place) & (place < end[:, None])
    handled = np.where(fails, LAPSE, 1.0 - LAPSE)  # (hypotheses, places)
    choice: int | None = 0
    while choice is not None:
        points[choice] = point = probe(places[choice])
        weight = weight * (point.odds * handled[:, choice] + (1.0 - point.odds) * (1.0 - handled[:, choice]))
        weight /= weight.sum()
        choice = (
            n - 1 if len(points) == 1 < n and point.handled else _most_telling(weight, first, handled, points, full)
        )
    return [points[k] for k in sorted(points)]


def refined(values: Sequence[float]) -> list[float]:
    """Return the values with geometric steps between those that are positive."""
    parts = np.arange(2**BETWEEN) / 2**BETWEEN
    fine: list[float] = []
    for low, high in pairwise(values):
        fine += [low] if min(low, high) <= 0.0 else [low] + [low * (high / low) ** float(part) for part in parts[1:]]
    return [*fine, values[-1]]


def _most_telling(
    weight: np.ndarray, first: np.ndarray, handled: np.ndarray, points: dict[int, Point], full: bool
) -> int | None:
    """Return the place whose run is expected to tell most of where failures begin; None where none tells enough."""
    starts = np.eye(first.max() + 1)[first].T  # (starts, hypotheses)
    share = starts @ weight
    given = (starts @ (weight[:, None] * handled)) / np.maximum(share, 1e-300)[:, None]
    gain = _entropy(share @ given) - share @ _entropy(given)
    gain[list(points)] = 0.0
    return int(np.argmax(gain)) if gain.max() > TELLS[full] else None


def _entropy(p: np.ndarray) -> np.ndarray:
    """Return the entropy of a yes or no in nats."""
    p = np.clip(p, 1e-12, 1.0 - 1e-12)
    return -p * np.log(p) - (1.0 - p) * np.log1p(-p)


CHILDREN = 2
FIRST = 60.0  # s for the mildest value of a cell, which loads what the others need
LOADING = 30.0  # s for a new child, which has everything to load
PATIENCE = {False: 2.0, True: 60.0}  # s for any other run, by `full`
MEMORY = 2 * 2**30  # bytes of one child

Task = tuple[str, str, Extreme]  # engine, method (empty where the engine is not installed), extreme


def run_point(extreme_name: str, value: float, engine_name: str, method_name: str) -> Point:
    """Make one run and judge it; called in a child."""
    began = time.perf_counter()
    extreme = named(extreme_name)
    engine = extreme.engine(engine_name)
    case, method = extreme.case(value), engine.method(method_name)
    settings = settings_for(case, method)
    if case.unchecked and not engine.checks_start:
        settings = settings.model_copy(update={"initial_tolerance": UNCHECKED})
    run = checked_run(engine, case.scene, settings, output_times(case.scene, settings, case.times))
    return replace(judge(case, method, value, run), seconds=time.perf_counter() - began)


def cannot(extreme: Extreme, engine: Engine, method: Method) -> str:
    """Return why a method has no say on an axis, or nothing."""
    if not extreme.takes(method):
        return "the axis is about fixed steps" if method.kind == "adaptive" else "it has no tolerance"
    return engine.refusal(extreme.case(extreme.axis.values[0]).scene, method)


def cell_of(extreme: Extreme, engine: Engine, method: Method, full: bool, call: Isolated) -> Cell:
    """Return one cell; runs that do not come back are stops with a reason."""
    if why := cannot(extreme, engine, method):
        return Cell(extreme.name, extreme.family, engine.name, method.name, full, Fate.CANNOT, None, (), why)

    def probe(value: float) -> Point:
        is_mildest = value == extreme.axis.values[0]  # it loads what others need, which run in copies of its process
        call.timeout = FIRST if is_mildest else PATIENCE[full] + (LOADING if call.fresh else 0.0)
        make, began = (call if is_mildest else call.apart), time.perf_counter()
        try:
            return make(run_point, extreme.name, value, engine.name, method.name)
        except Lost as error:
            seconds = time.perf_counter() - began
            return Point(value, Fate.STOPPED, 0.0, False, None, error.status, str(error), seconds)

    values = extreme.values(full)
    points = [probe(value) for value in values] if extreme.axis.labels else search(values, probe, full)
    return made_of(extreme.name, extreme.family, engine.name, method.name, full, points)


def tasks(extremes: Sequence[Extreme], engines: Collection[str], full: bool) -> list[Task]:
    """Return every extreme with every method, those of a method together; a few methods only unless `full`."""
    listed: list[Task] = []
    for name in engines:
        mine: list[Task] = []
        for extreme in extremes:
            try:
                offered = [method.name for method in extreme.engine(name).methods()]
            except registry.EngineMissing:
                offered = [""]
            few = [method for method in offered if full or not method or method in QUICK.get(name, offered)]
            mine += [(name, method, extreme) for method in few or offered]
        first = [task[1] for task in mine]
        listed += sorted(mine, key=lambda task: first.index(task[1]))
    return listed


def matrix(
    extremes: Sequence[Extreme],
    engines: Collection[str],
    *,
    full: bool = False,
    known: Collection[Cell] = (),
    progress: Report | None = None,
    children: int = CHILDREN,
    call: Isolated | None = None,
) -> Iterator[Cell]:
    """Yield every cell as soon as it is known; those of `known` are not run again. `call` is a cluster's caller."""
    before = {cell.key for cell in known}
    wanted = [task for task in tasks(extremes, engines, full) if (task[2].name, *task[:2], full) not in before]
    found = each(wanted, partial(_cell, full), 0 if call else children, memory=MEMORY, call=call)
    for done, (_, cell) in enumerate(found, 1):
        if progress is not None:
            progress(done, len(wanted), f"{cell.engine} {cell.method} {cell.extreme}")
        yield cell


def _cell(full: bool, call: Any, task: Task) -> Cell:
    name, method, extreme = task
    if not method:
        reason = f"{MISSING}: {name} is not installed"
        return Cell(extreme.name, extreme.family, name, "", full, Fate.CANNOT, None, (), reason)
    engine = extreme.engine(name)
    return cell_of(extreme, engine, engine.method(method), full, call.call)
