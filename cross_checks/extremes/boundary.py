"""Up to where along an axis are runs handled? The next run is where it changes the answer most.

The axis has evenly spaced places. Runs are handled but for one failing stretch of places, up to the end of the axis
as a rule; an axis that is not monotone recovers behind it. A run agrees with that with the odds 1 - LAPSE, and with
its own odds that it is handled. Wanted is where the stretch begins.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from cross_checks.extremes.fate import Point

LAPSE = 0.02  # probability that a run contradicts its place
MONOTONE = 0.95  # probability that nothing is handled beyond the first failure
BETWEEN = 3  # halvings between two listed values, where they are finely searched
TELLS = {False: 0.08, True: 0.02}  # nats that a run must be expected to tell, by `full`


def search(values: Sequence[float], probe: Callable[[float], Point], full: bool) -> list[Point]:
    """Return the runs, mild first: at both ends, and where the boundary is sought."""
    places = refined(values) if full else list(values)
    n, points = len(places), dict[int, Point]()
    first, end = np.triu_indices(n + 1)  # the failing stretch is first <= place < end; none where first = end
    single, at_end = first == end, end == n
    weight = np.where(at_end, MONOTONE / (n + 1), np.where(single, 0.0, (1.0 - MONOTONE) / max(n * (n - 1) / 2, 1)))
    place = np.arange(n)
    fails = (first[:, None] <= place) & (place < end[:, None])
    handled = np.where(fails, LAPSE, 1.0 - LAPSE)  # (hypotheses, places)
    choice: int | None = 0
    while choice is not None:
        points[choice] = point = probe(places[choice])
        weight = weight * (point.odds * handled[:, choice] + (1.0 - point.odds) * (1.0 - handled[:, choice]))
        weight /= weight.sum()
        choice = (
            n - 1 if len(points) == 1 < n and point.handled else _most_telling(weight, first, handled, points, full)
        )
    return [points[k] for k in sorted(points)]


def refined(values: Sequence[float]) -> list[float]:
    """Return the values with geometric steps between those that are positive."""
    parts = np.arange(2**BETWEEN) / 2**BETWEEN
    fine: list[float] = []
    for low, high in pairwise(values):
        fine += [low] if min(low, high) <= 0.0 else [low] + [low * (high / low) ** float(part) for part in parts[1:]]
    return [*fine, values[-1]]


def _most_telling(
    weight: np.ndarray, first: np.ndarray, handled: np.ndarray, points: dict[int, Point], full: bool
) -> int | None:
    """Return the place whose run is expected to tell most of where failures begin; None where none tells enough."""
    starts = np.eye(first.max() + 1)[first].T  # (starts, hypotheses)
    share = starts @ weight
    given = (starts @ (weight[:, None] * handled)) / np.maximum(share, 1e-300)[:, None]
    gain = _entropy(share @ given) - share @ _entropy(given)
    gain[list(points)] = 0.0
    return int(np.argmax(gain)) if gain.max() > TELLS[full] else None


def _entropy(p: np.ndarray) -> np.ndarray:
    """Return the entropy of a yes or no in nats."""
    p = np.clip(p, 1e-12, 1.0 - 1e-12)
    return -p * np.log(p) - (1.0 - p) * np.log1p(-p)
