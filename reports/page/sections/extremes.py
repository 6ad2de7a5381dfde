"""Extremes: up to where each engine's methods can be trusted, and who goes wrong without a word."""

import math
from bisect import bisect_right
from collections import Counter
from itertools import groupby
from typing import Any

from cross_checks.extremes import Axis, Extreme, every
from cross_checks.extremes.fate import Cell, Fate
from cross_checks.judge.bounds import RESOLVED, TARGETS
from cross_checks.judge.vocabulary import OURS
from cross_checks.records.numbers import short
from cross_checks.records.plots import style_of
from reports.facts.report_data import ReportData, Section

LEAD = "Up to here you can trust an engine's method: scenes driven from mild to hopeless, and what became of each."


def context(data: ReportData) -> dict[str, Any]:
    cells = sorted(data.extremes, key=lambda c: (c.engine != OURS, c.engine, c.method))
    result = {extreme.name: [c for c in cells if c.extreme == extreme.name] for extreme in every()}
    shown = [extreme for extreme in every() if any(c.points for c in result[extreme.name])]
    families = [
        {"name": family, "extremes": [_extreme(e, result[e.name]) for e in group]}
        for family, group in groupby(shown, key=lambda e: e.family)
    ]
    ran = dict.fromkeys((c.engine, c.method) for c in cells if c.points)
    made = sorted({c.made for c in cells if c.made})
    return {
        "families": families,
        "fates": (Fate.SURVIVED, Fate.STOPPED, Fate.DEGRADED, Fate.SILENTLY_WRONG, Fate.CANNOT),
        "table": [_table_row(e, [c for c in result[e.name] if (c.engine, c.method) in ran]) for e in shown],
        "engines": list(dict.fromkeys(engine for engine, _ in ran)),
        "counts": {family: _by_engine(cells, family) for family in dict.fromkeys(e.family for e in shown)},
        "made": " to ".join(dict.fromkeys((*made[:1], *made[-1:]))),
        "tally": [_tally(*own, cells) for own in ran],
        "silent": _silent(cells),
        "good": f"{TARGETS[0]:g}",
        "wrong": f"{RESOLVED:g}",
    }


def _extreme(extreme: Extreme, cells: list[Cell]) -> dict[str, Any]:
    shown = [cell for cell in cells if cell.points]
    return {
        "name": extreme.name,
        "title": extreme.title,
        "chart": chart(cells, extreme.axis),
        "advice": [_advice(extreme, engine, list(own)) for engine, own in groupby(shown, lambda c: c.engine)],
    }


def _advice(extreme: Extreme, engine: str, cells: list[Cell]) -> dict[str, str]:
    """Return how far an engine's furthest method goes, and what fails next."""
    best = max(cells, key=lambda c: _reach(extreme, c))
    tied = [c.method for c in cells if _reach(extreme, c) == _reach(extreme, best)]
    lying = [c.method for c in cells if c.fate is Fate.SILENTLY_WRONG]
    names = ", ".join(tied)
    if best.last is None:
        text = f"none of its methods is right even at {_value(extreme, extreme.axis.values[0])}: {best.first_failure}"
    elif best.last == best.points[-1].value:
        end = ", which is rightly refused" if best.points[-1].fate is Fate.STOPPED else ""
        text = f"trust {names} over the whole axis, to {_value(extreme, best.last)}{end}"
    else:
        text = f"trust {names} up to {_value(extreme, best.last)}; beyond, {best.first_failure}"
    warning = f"wrong without a word somewhere on the axis: {', '.join(lying)}" if lying else ""
    return {"engine": engine, "text": text, "warning": warning}


def _reach(extreme: Extreme, cell: Cell) -> float:
    """Return how far along the axis a method is right, as a place in the list of values; -1 for nowhere."""
    if cell.last is None:
        return -1.0
    values = extreme.values(True)
    rising = values[-1] > values[0]
    return float(sum(v <= cell.last if rising else v >= cell.last for v in values))


def _value(extreme: Extreme, value: float) -> str:
    axis = extreme.axis
    return axis.label(value) if axis.labels else f"{tick(axis, value)} {axis.unit}".rstrip()


def _table_row(extreme: Extreme, cells: list[Cell]) -> dict[str, Any]:
    """Return an extreme's methods by their fate and engine."""
    fates: dict[str, dict[str, list[dict[str, str]]]] = {fate: {} for fate in Fate}
    for cell in cells:
        last = "nowhere right" if cell.last is None else f"to {_value(extreme, cell.last)}"
        figure = "" if cell.fate in (Fate.SURVIVED, Fate.CANNOT) else last
        method = {"name": cell.method, "figure": figure, "reason": cell.reason}
        fates[cell.fate].setdefault(cell.engine, []).append(method)
    return {"name": extreme.name, "title": extreme.title, "fates": fates}


def _by_engine(cells: list[Cell], family: str) -> dict[str, dict[str, int]]:
    """Return how many extremes of a family each engine models, survives by a method, and gets wrong silently."""
    met = {(c.engine, c.extreme, c.fate) for c in cells if c.family == family and c.fate is not Fate.CANNOT}
    asked = {"of": set(Fate), "survived": {Fate.SURVIVED}, "wrong": {Fate.SILENTLY_WRONG}}
    return {engine: {word: len({extreme for name, extreme, fate in met if name == engine and fate in fates})
                     for word, fates in asked.items()} for engine, _, _ in met}  # fmt: skip


def _tally(engine: str, method: str, cells: list[Cell]) -> dict[str, Any]:
    own = [c for c in cells if (c.engine, c.method) == (engine, method)]
    counts = Counter(str(c.fate) for c in own)
    caught = sum(point.caught for c in own for point in c.points)
    return {"engine": engine, "method": method, "counts": counts, "caught": caught}


def _silent(cells: list[Cell]) -> list[dict[str, str]]:
    """Return the failures an engine did not mention at all and our checks caught, the first of each cell."""
    result = []
    for cell in cells:
        point = next((p for p in cell.points if p.caught), None)
        if point is not None:
            result.append({"engine": cell.engine, "method": cell.method, "extreme": cell.extreme,
                          "status": point.status, "reason": point.reason})  # fmt: skip
    return result


SECTION = Section("extremes", "Extremes", context, LEAD)


LEFT, WIDTH, ROW, TOP, RIGHT = 250, 560, 19, 8, 34  # px: names, axis, row height, margins


def chart(cells: list[Cell], axis: Axis) -> dict[str, Any] | None:
    """Return what the template draws; the axis shows the listed values, mild to extreme, evenly."""
    wanted = [cell for cell in cells if cell.points]
    if not wanted:
        return None
    values = _values(wanted, axis)
    rows = [_chart_row(cell, k, axis, values) for k, cell in enumerate(wanted)]
    height = TOP + ROW * len(rows)
    ticks = [{"x": place(value, values), "label": tick(axis, value)} for value in values]
    unit = f" ({axis.unit})" if axis.unit and not axis.labels else ""
    return {
        "rows": rows, "ticks": ticks, "axis": f"{axis.name}{unit}", "left": LEFT, "right": LEFT + WIDTH,
        "bottom": height, "height": height + 42, "width": LEFT + WIDTH + RIGHT, "row": ROW,
    }  # fmt: skip


def tick(axis: Axis, value: float) -> str:
    """Return a value for an axis's tick."""
    return axis.label(value) if axis.labels else short(value)


def place(value: float, values: tuple[float, ...]) -> float:
    """Return the x (px) of a value: listed ones stand evenly, others between by their logarithms."""
    span = max(1, len(values) - 1)
    return round(LEFT + WIDTH * _index(value, values) / span, 1)


def _index(value: float, values: tuple[float, ...]) -> float:
    if value in values:
        return float(values.index(value))
    rising = values[-1] > values[0]
    ordered = values if rising else values[::-1]
    k = min(max(bisect_right(ordered, value), 1), len(ordered) - 1)
    low, high = ordered[k - 1], ordered[k]
    share = math.log(value / low) / math.log(high / low) if low > 0.0 else (value - low) / (high - low)
    return k - 1 + share if rising else len(values) - k - share


def _values(cells: list[Cell], axis: Axis) -> tuple[float, ...]:
    return axis.values + axis.full if any(cell.full for cell in cells) else axis.values


def _chart_row(cell: Cell, k: int, axis: Axis, values: tuple[float, ...]) -> dict[str, Any]:
    marks = []
    for p in cell.points:
        text = f"{axis.name} {axis.label(p.value)}: {p.fate}. {p.reason}"
        marks.append({"x": place(p.value, values), "fate": str(p.fate), "text": text})
    end = None if cell.last is None else place(cell.last, values)
    y = TOP + ROW * k + ROW // 2
    return {"engine": cell.engine, "method": cell.method, "y": y, "end": end, "marks": marks,
            "colour": style_of(cell.engine).colour}  # fmt: skip
