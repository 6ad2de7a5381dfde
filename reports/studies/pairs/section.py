"""Every pair of a solver of our own and a peer, at equal error relative to the scene."""

from __future__ import annotations

from typing import Any

from cross_checks.judge.vocabulary import ANSWERS
from reports.drawing.numbers import ABSENT, duration, joules, metres, setting, short
from reports.drawing.section import Section
from reports.facts.cheapest import loop_time
from reports.facts.report_data import ReportData
from reports.studies.pairs.facts import Pair, PairsFacts, Places, Row

LEAD = (
    "The pairs that this project sets out to compare, one table each. Every engine enters all of its methods. A row "
    "shows the cheapest setting that meets a target error over the scene's own scales: its constraint violation, its "
    "energy drift, and its time in interleaved runs, also as a multiple of our cheapest."
)
NO_ROWS = "no rows"  # to comply with
HEAD = ("scene", "engine and method", "target", "setting", "error", "largest |C|", "energy drift", "time", "over ours")


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(PairsFacts)
    if facts is None:
        return {"pairs": None}
    return {
        "pairs": [_table(pair) for pair in facts.pairs],
        "head": HEAD,
        "astropy": [_places(p) for p in facts.astropy],
    }


def _table(pair: Pair) -> dict[str, Any]:
    return {"title": pair.title, "note": pair.note, "rows": [_cells(row) for row in pair.rows]}


def _cells(row: Row) -> list[str]:
    entry, run = row.entry, row.entry.best
    head = [row.scene, f"{entry.engine} {entry.method}".rstrip(), _target(row)]
    if run is None or run.error is None:
        return [*head, f"{ANSWERS[entry.answer][0]}: {entry.reason}".rstrip(": ")]
    drift = run.measure("energy_drift")
    return [
        *head, setting(run.settings), short(run.error.value),
        short(run.measure("compliance_position")) if row.constrained else NO_ROWS,
        "worked on" if drift is None else joules(drift), duration(loop_time(run)), short(row.ratio, 3),
    ]  # fmt: skip


def _target(row: Row) -> str:
    return ABSENT if row.target is None else f"{row.target:g}"


def _places(places: Places) -> dict[str, Any]:
    unit = metres if places.unit == "m" else lambda value: f"{short(value)} {places.unit}"
    cells = [(name, unit(apart), f"{places.figures[name]:.1f}") for name, apart in places.apart.items()]
    return {"title": f"{places.what}, day {places.days:g}", "rows": cells}


SECTION = Section("pairs", "Every pair at equal error", LEAD, context)
