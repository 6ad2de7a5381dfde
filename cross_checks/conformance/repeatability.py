"""Does a run give the same bits again: at once, in another process, in another order of runs, with another thread?"""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.conformance.cases import Case
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.isolation.workers import Report

WAYS = ("at once", "another process", "another order", "two threads")
PATIENCE = 60.0  # s of one run
Outcome = dict[str, np.ndarray] | str  # what a run gave, or why it gave nothing


def outcome(case: Case) -> Outcome:
    """Make one run; called in a child process."""
    run = engines.get(case.engine).run(case.built(), case.settings)
    if not run.ok:
        return run.message
    return {"times": run.times, "position": run.position, "orientation": run.orientation,
            "velocity": run.velocity, "angular velocity": run.angular_velocity}  # fmt: skip


def twice(case: Case) -> tuple[Outcome, Outcome]:
    """Make one run and at once the same again."""
    return outcome(case), outcome(case)


def measured(cases: Iterable[Case], report: Report | None = None) -> list[dict[str, Any]]:
    """Return for each case by how much a run differs each way: 0.0 are the same bits. One engine after the other."""
    every = list(cases)
    result = []
    for name in dict.fromkeys(case.engine for case in every):
        if report:
            report(len(result), len(every), name)
        result += _of_engine([case for case in every if case.engine == name])
    return result


def _of_engine(cases: list[Case]) -> list[dict[str, Any]]:
    """Run an engine's cases in four processes: each run twice, all once more, from last to first, with two threads."""
    first = _made(cases, twice)
    others = {
        "another process": _made(cases, outcome),
        "another order": _made(cases[::-1], outcome),
        "two threads": _made(cases, outcome, threads=2),
    }
    rows = []
    for case in cases:
        plain, again = (first[case.name],) * 2 if isinstance(first[case.name], str) else first[case.name]
        runs = {"at once": again} | {way: created[case.name] for way, created in others.items()}
        rows.append(_row(case, plain, runs))
    return rows


def _made(cases: list[Case], function: Callable[[Case], Any], threads: int = 1) -> dict[str, Any]:
    """Return what the function gives for every case, one after the other in one process; its words where it is lost."""
    result = {}
    with Isolated(timeout=PATIENCE, threads=threads) as call:
        for case in cases:
            try:
                result[case.name] = call(function, case)
            except Lost as error:
                result[case.name] = f"{error.status}: {error}"
    return result


def _row(case: Case, plain: Outcome, runs: dict[str, Outcome]) -> dict[str, Any]:
    about = {"engine": case.engine, "method": case.method, "scene": case.scene, "setting": case.setting}
    if isinstance(plain, str):
        return about | {"differs": {}, "stopped": plain}
    return about | {"differs": {way: difference(plain, run) for way, run in runs.items()}, "stopped": ""}


def difference(one: Outcome, other: Outcome) -> float | None:
    """Return 0.0 for the same bits, the largest difference over the largest value otherwise; None if one has no end."""
    if isinstance(one, str) or isinstance(other, str):
        return 0.0 if one == other else None
    if all(one[key].tobytes() == other[key].tobytes() for key in one):
        return 0.0
    if any(one[key].shape != other[key].shape for key in one):
        return None
    tiny = float(np.finfo(float).tiny)  # -0.0 is another bit than 0.0
    return max(tiny, *(_relative(one[key], other[key]) for key in one))


def _relative(one: np.ndarray, other: np.ndarray) -> float:
    size = float(np.max(np.abs(one), initial=0.0))
    return float(np.max(np.abs(one - other), initial=0.0)) / size if size > 0.0 else 0.0


def by_method(result: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each engine and method: runs, and for each way how many differ and by how much at most."""
    rows = []
    for engine, method in dict.fromkeys((one["engine"], one["method"]) for one in result):
        mine = [one for one in result if (one["engine"], one["method"]) == (engine, method) and not one["stopped"]]
        rows.append({"engine": engine, "method": method, "runs": len(mine), "ways": [_way(way, mine) for way in WAYS]})
    return rows


def _way(way: str, result: list[dict[str, Any]]) -> dict[str, Any]:
    sizes = [one["differs"][way] for one in result]
    known = [size for size in sizes if size is not None]
    return {"way": way, "differ": sum(size != 0.0 for size in sizes), "largest": max(known, default=None),
            "other_end": sizes.count(None)}  # fmt: skip
