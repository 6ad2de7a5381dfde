"""What every nightly job measured: JSON lines, grouped into series over time with their change points."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from cross_checks.prices.pick import pick, setting
from cross_checks.records.record import Record, loop_time

EFFECT = 1.05  # a level that changes by less is no change
CHANCE = 0.01  # of a permutation doing as well
SHUFFLES = 500
LEAST = 4  # entries on either side of a change
ACCURACIES = ("error", "error_mps2")  # of a benchmark's extra_info


@dataclass(frozen=True)
class Entry:
    """One figure of one job."""

    job: str  # entries of one job were measured on one machine within one run
    made: str  # UTC, ISO 8601
    commit_id: str
    machine: str
    series: str  # what is followed over time
    value: float  # a ratio to the job's own baseline where unit is 1, else s
    unit: str
    verdict: str = ""
    error: float | None = None  # of the scene, the accuracy at which it was timed; m/s^2 of a right-hand side


def series(entries: Iterable[Entry], name_contains: str = "") -> dict[str, list[Entry]]:
    """Return every series whose name holds the text, each in the order of time."""
    chosen = sorted((e for e in entries if name_contains in e.series), key=lambda e: (e.series, e.made))
    return {name: list(own) for name, own in groupby(chosen, key=lambda e: e.series)}


def change_points(values: Sequence[float], seed: int = 0) -> list[int]:
    """Return where the level of positive values changes: indices of the first value of each new level.

    Binary segmentation on log values; a split counts when its t statistic beats all but CHANCE of random
    permutations (Matteson & James 2014 use the same test) and the levels differ by EFFECT.
    """
    logs = np.log(np.asarray(values, dtype=float))
    return sorted(_split(logs, 0, np.random.default_rng(seed)))


def _split(x: np.ndarray, offset: int, random: np.random.Generator) -> list[int]:
    place, strength = _strongest(x)
    if place == 0:
        return []
    if abs(np.median(x[place:]) - np.median(x[:place])) < np.log(EFFECT):
        return []
    by_chance = [_strongest(random.permutation(x))[1] for _ in range(SHUFFLES)]
    if np.mean(np.array(by_chance) >= strength) > CHANCE:
        return []
    return [offset + place, *_split(x[:place], offset, random), *_split(x[place:], offset + place, random)]


def _strongest(x: np.ndarray) -> tuple[int, float]:
    """Return the best place to split, and its t statistic; place 0 where there is none."""
    best, where = 0.0, 0
    for k in range(LEAST, len(x) - LEAST + 1):
        a, b = x[:k], x[k:]
        spread = np.sqrt(a.var() / len(a) + b.var() / len(b)) + 1e-12
        strength = abs(a.mean() - b.mean()) / spread
        if strength > best:
            best, where = float(strength), k
    return where, best


def from_benchmarks(data: dict[str, Any], job: str, made: str, commit_id: str, machine: str) -> list[Entry]:
    """Return the entries of a pytest-benchmark file, with loop time and accuracy where a suite tells one of each."""
    entries = []
    for item in data["benchmarks"]:
        text = item["extra_info"]
        loop = text.get("loop_s")
        seconds = float(loop if isinstance(loop, int | float) else item["stats"]["min"])
        accuracy = next((text[key] for key in ACCURACIES if key in text), None)
        entries.append(Entry(job, made, commit_id, machine, f"bench {item['name']}", seconds, "s", "", accuracy))
    return entries


def from_records(
    records: Sequence[Record], label: str, error: float, job: str, made: str, commit_id: str, machine: str
) -> list[Entry]:
    """Return each engine's cheapest loop time within an error of one scene; none for an engine that missed it."""
    entries = []
    for engine in dict.fromkeys(record.engine for record in records):
        best = pick([record for record in records if record.engine == engine], error).best
        if best is not None and best.error is not None:
            series = f"loop {label} {engine} within {error:g} of the scene"
            text = setting(best)
            entries.append(Entry(job, made, commit_id, machine, series, loop_time(best), "s", text, best.error.bound))
    return entries


def new_levels(series: dict[str, list[Entry]], last: int = LEAST) -> dict[str, Entry]:
    """Return the first entry of a new level, for each series whose level changed within its `last` entries but one."""
    recent = {}
    for name, entries in series.items():
        places = change_points([entry.value for entry in entries])
        if places and places[-1] >= len(entries) - last - 1:
            recent[name] = entries[places[-1]]
    return recent
