"""An ensemble in the terminal: its figures at the end, by body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.table import Table

from mbs_ref.simulate.many.ensemble import Ensemble, Statistics, coordinates
from reports.terminal.console import number, table

MOST_ROWS = 60


def end_table(ensemble: Ensemble, found: list[Statistics | None]) -> tuple[Table, int]:
    """Return the figures at the end, and how many rows of them there is no room for."""
    title = f"\nAt t = {ensemble.times[-1]:g} s"
    grids = tuple(ensemble.design.grids)
    if ensemble.design.is_random:
        columns = ("mean", "std. error", "std. deviation", "std. error", "5 %", "median", "95 %", "smallest", "largest")
        rows = list(_spreads(ensemble, found))
        listing = table(title, *grids, "body", "", *columns)
    else:
        rows = list(_ends(ensemble, found))
        listing = table(title, *grids, "body", *(("x, m", "y, m", "z, m")[: ensemble.scene.dimension]),
                        *(["angle, rad"] if ensemble.scene.dimension == 2 else []))  # fmt: skip
    for row in rows[:MOST_ROWS]:
        listing.add_row(*row)
    return listing, max(0, len(rows) - MOST_ROWS)


def _spreads(ensemble: Ensemble, found: list[Statistics | None]) -> Iterator[tuple[str, ...]]:
    """Yield a row a point of the grids and coordinate."""
    for at, one in _points(ensemble, found):
        if one is None:
            yield *at, "no run ended well"
            continue
        for k, place in enumerate(coordinates(ensemble)):
            spread, middle = one.deviation[-1, k], one.mean[-1, k]
            figures = _figures(middle, spread)
            values = (middle, *one.quantiles[:, -1, k], one.least[-1, k], one.most[-1, k])
            mean, *others = (_digits(value, figures) for value in values)
            yield (
                *at, place.body, f"{place.name}, {place.unit}", mean, number(one.mean_error[-1, k]),
                _digits(spread), number(one.deviation_error[-1, k]), *others,
            )  # fmt: skip


def _ends(ensemble: Ensemble, found: list[Statistics | None]) -> Iterator[tuple[str, ...]]:
    """Yield a row a point of the grids and body, of a single run each."""
    for (at, one), status in zip(_points(ensemble, found), ensemble.statuses, strict=False):
        if one is None:
            yield *at, str(status)
            continue
        ends: dict[str, list[str]] = {}
        for place, value in zip(coordinates(ensemble), one.mean[-1], strict=True):
            ends.setdefault(place.body, []).append(_digits(value, 9))
        yield from ((*at, body, *values) for body, values in ends.items())


def _points(ensemble: Ensemble, found: list[Statistics | None]) -> Iterator[tuple[list[str], Statistics | None]]:
    for at, one in zip(ensemble.design.points, found, strict=True):
        yield [f"{value:.6g}" for value in at], one


def _figures(value: float, spread: float) -> int:
    """Return how many figures of a value show its spread with two, six at least."""
    if not spread > 0.0 or value == 0.0:
        return 6
    return int(np.clip(np.ceil(np.log10(abs(value) / spread)) + 2, 6, 12))


def _digits(value: float, count: int = 6) -> str:
    return f"{value:.{count}g}"
