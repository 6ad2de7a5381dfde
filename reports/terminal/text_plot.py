"""Small plots in characters, for a terminal."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

WIDTH, HEIGHT = 72, 16  # characters of the field
MARKS = "ox+*#@%&"


def text_plot(
    lines: Mapping[str, tuple[ArrayLike, ArrayLike]], x_label: str, y_label: str,
    log_x: bool = False, log_y: bool = False,
) -> str:  # fmt: skip
    """Return a plot of every line's (x, y), each with a mark of its own; empty where there is nothing to draw.

    Points that are not finite, or not positive on a logarithmic axis, are left out.
    """
    points = {name: _on_axes(*line, log_x, log_y) for name, line in lines.items()}
    points = {name: line for name, line in points.items() if len(line)}
    if not points:
        return ""
    every = np.concatenate(list(points.values()))
    low, high = every.min(axis=0), every.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    field = [[" "] * WIDTH for _ in range(HEIGHT)]
    for mark, line in zip(_marks(len(points)), points.values(), strict=True):
        columns, rows = np.round((line - low) / span * (WIDTH - 1, HEIGHT - 1)).astype(int).T
        for column, row in zip(columns, rows, strict=True):
            field[HEIGHT - 1 - row][column] = mark
    return "\n".join(_framed(field, _ends(low, high, 1, log_y), _ends(low, high, 0, log_x), x_label, y_label, points))


def _on_axes(x: ArrayLike, y: ArrayLike, log_x: bool, log_y: bool) -> np.ndarray:
    """Return the points (n, 2) that can be drawn, in the axes' own measure."""
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = [np.log10(v) if log else np.asarray(v, float) for v, log in ((x, log_x), (y, log_y))]
    result = np.column_stack(columns)
    return result[np.all(np.isfinite(result), axis=1)]


def _marks(number: int) -> str:
    return (MARKS * (number // len(MARKS) + 1))[:number]


def _ends(low: np.ndarray, high: np.ndarray, axis: int, log: bool) -> tuple[str, str]:
    ends = (low[axis], high[axis])
    return tuple(f"{10.0**end if log else end:.3g}" for end in ends)  # type: ignore[return-value]


def _framed(
    field: list[list[str]], y_ends: tuple[str, str], x_ends: tuple[str, str], x_label: str, y_label: str,
    names: Mapping[str, object],
) -> list[str]:  # fmt: skip
    """Return the field with axes, their ends and the legend."""
    margin = max(len(end) for end in y_ends)
    sides = [y_ends[1], *[""] * (len(field) - 2), y_ends[0]]
    rows = [f"{side:>{margin}} |{''.join(row).rstrip()}" for side, row in zip(sides, field, strict=True)]
    axis = f"{'':>{margin}} +{'-' * WIDTH}"
    ends = f"{'':>{margin}}  {x_ends[0]}{x_ends[1]:>{WIDTH - len(x_ends[0])}}"
    legend = "   ".join(f"{mark} {name}" for mark, name in zip(_marks(len(names)), names, strict=True))
    return [y_label, *rows, axis, ends, f"{'':>{margin}}  {x_label}", f"{'':>{margin}}  {legend}"]
