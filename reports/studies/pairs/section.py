"""Every pair of a solver of our own and a peer, at equal error relative to the scene."""

from __future__ import annotations

from typing import Any

from reports.drawing.numbers import ABSENT, duration, joules, metres, short
from reports.drawing.section import Section
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
    name = f"{row.engine} {row.method}".rstrip()
    if row.answer != "reached":
        return [row.scene, name, _target(row), f"{row.answer}: {row.reason}".rstrip(": ")]
    kept = NO_ROWS if row.compliance is None else short(row.compliance)
    energy = "worked on" if row.energy is None else joules(row.energy)
    return [
        row.scene, name, _target(row), row.setting, short(row.error), kept, energy, duration(row.loop_s),
        ABSENT if row.ratio is None else f"{row.ratio:.3g}",
    ]  # fmt: skip


def _target(row: Row) -> str:
    return ABSENT if row.target is None else f"{row.target:g}"


def _places(places: Places) -> dict[str, Any]:
    unit = metres if places.unit == "m" else lambda value: f"{short(value)} {places.unit}"
    cells = [(name, unit(apart), f"{places.figures[name]:.1f}") for name, apart in places.apart.items()]
    return {"title": f"{places.what}, day {places.days:g}", "rows": cells}


SECTION = Section("pairs", "Every pair at equal error", LEAD, context)
