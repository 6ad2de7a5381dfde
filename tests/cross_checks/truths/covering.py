"""Variants of every scene that cover all pairs of parameter values, each run by the solver and its truth.

    python -m tests.cross_checks.truths.covering [--part k/n] [--scene NAME] [-o FILE]

A scene without a truth at some parameters is run by two methods instead, and the beginning of a run alone where the
whole run takes too long. Printed are every variant that is wrong, has a traceback or ends without a result, and the
counts. With -o every outcome is appended to a file of JSON lines as soon
as it is known, and variants that the file already holds are read from it.
"""

from __future__ import annotations

import argparse
import inspect
import itertools
import json
import time
import typing
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from cross_checks.isolation.parent import Caller, Isolated, Lost
from cross_checks.metrics.metric import from_truth
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth, time_limit
from mbs_ref import scenes
from mbs_ref.observables.distance import largest, relative, units_of
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

FACTOR = 3.0  # of the default, where an end of the range is further away or there is none
FARTHEST = 100.0  # of the default: an end of the range beyond is not run
INSIDE = 1e-3  # of the range, between an excluded end and the value beside it
RTOL, OTHER_RTOL = 1e-9, 1e-8
METHODS = ("dop853", "lsodar")
WRONG = 1e-5  # of the scene's scales ...
ESTIMATES = 30.0  # ... and of the run's own estimate: a difference above both is an error of one of the two
SLOW_S = 10.0  # s of processor time for one truth
LIMIT_S = 60.0  # s of processor time for one variant
BEGINNING = 0.02  # of the run: compared where the whole variant takes longer
ENDED = ("success", "stop-event")
KINDS = ("compared", "two methods", "no truth", "refused", "wrong", "traceback", "no result")
FAULTS = ("wrong", "traceback", "no result")
Row = dict[str, Any]


class Outcome(NamedTuple):
    """What became of one variant: without a truth it is "two methods", or "no truth" where the second fails."""

    kind: Literal["compared", "two methods", "no truth", "refused", "wrong", "traceback", "no result"]
    message: str = ""
    truth_s: float = 0.0


def values(name: str) -> dict[str, list[Any]]:
    """Return the values to combine for every parameter of a scene: each choice, the default, both ends."""
    builder = scenes.builder_of(name)
    hints = typing.get_type_hints(builder, include_extras=True)
    defaults = {p.name: p.default for p in inspect.signature(builder).parameters.values()}
    return {key: _values(hints[key], default) for key, default in defaults.items()}


def _values(hint: Any, default: Any) -> list[Any]:
    kind = typing.get_args(hint)[0] if typing.get_origin(hint) is typing.Annotated else hint
    if isinstance(default, bool | str):
        others = (not default,) if isinstance(default, bool) else typing.get_args(kind)
        return [default, *(choice for choice in others if choice != default)]
    if typing.get_origin(kind) is Literal:
        return [default, *(choice for choice in typing.get_args(kind) if choice != default)]
    (bottom, bottom_open), (top, top_open) = _ends(hint)
    size, margin = abs(default) or 1.0, INSIDE * (top - bottom) if np.isfinite(top - bottom) else 0.0

    def reached(end: float, is_open: bool, inwards: float, otherwise: float) -> float:
        value = end + inwards * margin if is_open else end
        is_far = abs(value) > FARTHEST * size or (is_open and not margin) or (value - default) * inwards > 0.0
        return otherwise if is_far else value

    low, high = sorted((default / FACTOR, default * FACTOR)) if default else (-1.0, 1.0)
    found = reached(bottom, bottom_open, 1.0, max(low, bottom)), reached(top, top_open, -1.0, min(high, top))
    return list(dict.fromkeys(type(default)(x) for x in (default, *found)))


def _ends(hint: Any) -> list[tuple[float, bool]]:
    """Return both ends of a range, and whether each is excluded."""
    marks = [mark for one in typing.get_args(hint)[1:] for mark in getattr(one, "metadata", [one])]
    found = [(-np.inf, True), (np.inf, True)]
    for mark, (key, place) in itertools.product(marks, (("ge", 0), ("gt", 0), ("le", 1), ("lt", 1))):
        if getattr(mark, key, None) is not None:
            found[place] = float(getattr(mark, key)), key in ("gt", "lt")
    return found


def pairwise(choices: dict[str, list[Any]]) -> list[Row]:
    """Return rows of values in which every pair of values of two parameters occurs; the first row holds the defaults.

    Each row starts from a pair that is missing, and every further value covers as many missing pairs as it can.
    """
    names = list(choices)
    if len(names) < 2:
        return [dict(zip(names, row, strict=True)) for row in itertools.product(*choices.values())]
    items = [(key, k) for key in names for k in range(len(choices[key]))]
    missing = {frozenset(pair): None for pair in itertools.combinations(items, 2) if pair[0][0] != pair[1][0]}
    rows, row = [], dict.fromkeys(names, 0)
    while True:
        rows.append({key: choices[key][place] for key, place in row.items()})
        for pair in itertools.combinations(row.items(), 2):
            missing.pop(frozenset(pair), None)
        if not missing:
            return rows
        row = dict(sorted(next(iter(missing))))  # a set has no order of its own
        for key in names:
            pairs = [[frozenset((item, (key, k))) for item in row.items()] for k in range(len(choices[key]))]
            gains = [sum(pair in missing for pair in some) for some in pairs]
            row.setdefault(key, int(np.argmax(gains)))


def variants(only: str | None = None) -> list[tuple[str, Row]]:
    """Return scene and parameters of the whole covering set, in a fixed order."""
    named = [name for name in scenes.names() if only in (None, name)]
    return [(name, scenes.applicable(name, row)) for name in named for row in pairwise(values(name))]


def outcome(name: str, parameters: Row, t_end: float | None = None, share: float = 1.0) -> Outcome:
    """Run a share of one variant and its truth, or a second method where there is none."""
    try:
        scene = scenes.make(name, **parameters)
    except ValueError as error:
        return Outcome("refused", str(error))
    try:
        end = share * min(t_end or scene.duration, scene.duration)
        run = _run(scene, None, RTOL, end)
        if str(run.status) not in ENDED or len(run.times) < 2:
            return Outcome("no result", f"{run.status}: {run.message}")
        began = time.thread_time()
        with time_limit(SLOW_S):
            truth = seek_truth(scene, run.times)
        spent = time.thread_time() - began
        if isinstance(truth, Truth):
            sizes = largest(from_truth(scene, run, truth).sizes, -2) / units_of(scales_of(scene))
            return _judged(run, sizes, "compared", truth.how, spent)
        if truth.kind == "defect":
            return Outcome("traceback", truth.reason)
        return _by_two_methods(scene, run, end, spent, truth.reason)
    except Exception as error:
        return Outcome("traceback", f"{type(error).__name__}: {error}")


def _by_two_methods(scene: Scene, run: Trajectory, end: float, spent: float, reason: str) -> Outcome:
    other = next((one for one in METHODS if one != run.method), METHODS[0])
    second = _run(scene, other, OTHER_RTOL, end)
    if str(second.status) not in ENDED or len(second.times) != len(run.times):
        return Outcome("no truth", f"{other} has {second.status}: {second.message}; {reason}", spent)
    return _judged(second, relative(scene, run, second), "two methods", reason, spent)


def _run(scene: Scene, method: str | None, rtol: float, t_end: float) -> Trajectory:
    return simulate(scene, Settings(method=method, rtol=rtol, t_end=t_end, samples=21))


def _judged(run: Trajectory, sizes: np.ndarray, kind: Any, how: str, spent: float) -> Outcome:
    worst = float(np.nanmax(sizes, initial=0.0))
    stated = np.inf if run.estimate is None else run.estimate.value
    is_wrong = worst > max(WRONG, ESTIMATES * stated)
    return Outcome("wrong" if is_wrong else kind, f"{worst:.1e} off, estimate {stated:.1e}; {how}", spent)


def outcomes(
    todo: list[tuple[str, Row]], t_end: float | None, file: Path | None, call: Caller
) -> Iterator[tuple[str, Outcome]]:
    """Yield the label and the outcome of every variant; read those that `file` holds, and append the others to it."""
    lines = file.read_text().splitlines() if file is not None and file.exists() else []
    known = {label: Outcome(*rest) for label, *rest in map(json.loads, lines)}
    for name, row in todo:
        label = scenes.label(name, row)
        if label not in known:
            known[label] = _isolated(call, name, row, t_end)
            if file is not None:
                with file.open("a") as out:
                    out.write(json.dumps([label, *known[label]]) + "\n")
        yield label, known[label]


def _isolated(call: Caller, name: str, row: Row, t_end: float | None, share: float = 1.0) -> Outcome:
    try:
        return call(outcome, name, row, t_end, share)
    except Lost as lost:
        if lost.status != "timeout" or share < 1.0:
            return Outcome("no result", str(lost))
    found = _isolated(call, name, row, t_end, BEGINNING)
    return found._replace(message=f"the first {BEGINNING:.0%} of it: {found.message}")


def main() -> None:
    """Run a part of the covering set, print its counts, and exit with 1 where a variant is wrong or has a traceback."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", default="1/1", help="k/n: every n-th variant from the k-th on")
    parser.add_argument("--scene", choices=scenes.names())
    parser.add_argument("--t-end", type=float, help="s, the longest run")
    parser.add_argument("-o", type=Path, dest="file", help="JSON lines of outcomes, continued where it exists")
    given = parser.parse_args()
    k, n = map(int, given.part.split("/"))
    counts: Counter[str] = Counter()
    with Isolated(LIMIT_S) as call:
        for label, found in outcomes(variants(given.scene)[k - 1 :: n], given.t_end, given.file, call):
            counts[found.kind] += 1
            counts["slow truth"] += found.truth_s >= SLOW_S
            if found.kind in FAULTS or found.truth_s >= SLOW_S:
                print(f"{found.kind}: {label}: {found.message} ({found.truth_s:.1f} s)", flush=True)
    total = counts.total() - counts["slow truth"]
    print(f"{total} variants; " + ", ".join(f"{kind}: {counts[kind]}" for kind in (*KINDS, "slow truth")))
    raise SystemExit(1 if counts["wrong"] or counts["traceback"] else 0)


if __name__ == "__main__":
    from tests.cross_checks.truths import covering  # a child process imports its functions from there

    covering.main()
