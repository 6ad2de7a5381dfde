"""Where along an axis does it break? Bisection over the listed values, then between two of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from cross_checks.extremes.judge import Fate, Point

Probe = Callable[[float], Point]


def bisect(values: Sequence[float], probe: Probe) -> list[Point]:
    """Return the points probed, mild first: both ends, and the last handled value found by halving.

    Where both ends are handled the middle is looked at too, because an axis need not be monotone.
    """
    points = {0: probe(values[0])}
    if not points[0].handled or len(values) == 1:
        return _ordered(points)
    last = len(values) - 1
    points[last] = probe(values[last])
    low, high = 0, last
    if points[last].handled:
        middle = last // 2
        points.setdefault(middle, probe(values[middle])) if middle not in points else None
        if points[middle].handled:
            return _ordered(points)
        high = middle
    while high - low > 1:
        middle = (low + high) // 2
        points[middle] = probe(values[middle])
        low, high = (middle, high) if points[middle].handled else (low, middle)
    return _ordered(points)


def scan(values: Sequence[float], probe: Probe, refine: int) -> list[Point]:
    """Return every listed value, and `refine` halvings (geometric) between the last handled and the first not."""
    points = [probe(value) for value in values]
    for _ in range(refine):
        k = broken(points)
        if k is None or k == 0 or not min(points[k].value, points[k - 1].value) > 0.0:
            break
        between = math.sqrt(points[k].value) * math.sqrt(points[k - 1].value)  # their product may overflow
        points.insert(k, probe(between))
    return points


def broken(points: Sequence[Point]) -> int | None:
    """Return the index of the first point that is not handled; None where all are."""
    return next((k for k, point in enumerate(points) if not point.handled), None)


def last_handled(points: Sequence[Point]) -> float | None:
    """Return the most extreme value up to which every point is handled; None where the mildest is not."""
    k = broken(points)
    if k == 0:
        return None
    return points[-1].value if k is None else points[k - 1].value


def fate_of(points: Sequence[Point]) -> Fate:
    """Return the worst that happened anywhere on the axis: silently wrong, degraded, stopped, survived."""
    order = (Fate.SILENTLY_WRONG, Fate.DEGRADED, Fate.STOPPED, Fate.SURVIVED, Fate.CANNOT)
    return next(fate for fate in order if any(point.fate is fate for point in points))


def _ordered(points: dict[int, Point]) -> list[Point]:
    return [points[k] for k in sorted(points)]
