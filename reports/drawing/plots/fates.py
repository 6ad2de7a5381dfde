"""Where along an axis each method survives, degrades, stops or lies: a row a method, a mark a run."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

from cross_checks.extremes.cell import Cell
from cross_checks.extremes.extreme import Axis
from reports.drawing.numbers import short
from reports.drawing.plots.palette import style_of

LEFT, WIDTH, ROW, TOP, RIGHT = 250, 560, 19, 8, 34  # px: names, axis, row height, margins


@dataclass(frozen=True)
class Mark:
    """One run."""

    x: float
    fate: str
    text: str


def chart(cells: list[Cell], axis: Axis) -> dict[str, Any] | None:
    """Return what the template draws; the axis shows the listed values, mild to extreme, evenly."""
    asked = [cell for cell in cells if cell.points]
    if not asked:
        return None
    values = _values(asked, axis)
    rows = [_row(cell, k, axis, values) for k, cell in enumerate(asked)]
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


def _row(cell: Cell, k: int, axis: Axis, values: tuple[float, ...]) -> dict[str, Any]:
    marks = [
        Mark(place(p.value, values), str(p.fate), f"{axis.name} {axis.label(p.value)}: {p.fate}. {p.reason}")
        for p in cell.points
    ]
    end = None if cell.last is None else place(cell.last, values)
    y = TOP + ROW * k + ROW // 2
    return {"engine": cell.engine, "method": cell.method, "y": y, "end": end, "marks": marks,
            "colour": style_of(cell.engine).colour}  # fmt: skip
