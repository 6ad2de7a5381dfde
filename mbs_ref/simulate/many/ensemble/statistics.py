"""Statistics of an ensemble: mean, spread and quantiles of every coordinate over time, with their standard errors."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbs_ref.scene import PointMass
from mbs_ref.simulate.many.ensemble.runs import Ensemble

QUANTILES = (0.05, 0.5, 0.95)
SHOWN = 0.1  # largest integration error over a spread at which the runs resolve the spread


class Coordinate(NamedTuple):
    """One coordinate of a body."""

    body: str
    name: str  # x, y, z or angle
    unit: str


@dataclass(frozen=True)
class Statistics:
    """Statistics of the successful runs at one point of the grids: coordinates over time, (n_t, n_coordinates) each.

    Standard errors are those of count - 1 independent samples, which a Latin hypercube's mean never exceeds
    (A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884).
    """

    count: int  # of runs
    mean: np.ndarray
    deviation: np.ndarray  # standard, of the runs: divided by count - 1
    quantiles: np.ndarray  # (3, n_t, n_coordinates): 5 %, 50 %, 95 %
    least: np.ndarray
    most: np.ndarray
    mean_error: np.ndarray  # standard error of the mean
    deviation_error: np.ndarray  # and of the standard deviation


def coordinates(ensemble: Ensemble) -> list[Coordinate]:
    """Return the coordinates in the order of `values_of`; a particle has no angle."""
    scene = ensemble.scene
    each = [("x", "m"), ("y", "m"), ("angle", "rad") if scene.dimension == 2 else ("z", "m")]
    every = [(body, Coordinate(body.name, *one)) for body in scene.bodies for one in each]
    return [one for body, one in every if one.name != "angle" or not isinstance(body, PointMass)]


def values_of(ensemble: Ensemble) -> np.ndarray:
    """Return all coordinates of all runs (n_runs, n_t, n_coordinates)."""
    place, angle = ensemble.samples.position, ensemble.samples.orientation
    column = {"x": place[..., 0], "y": place[..., 1], "z": place[..., -1], "angle": angle}
    index = ensemble.scene.body_index
    return np.stack([column[one.name][:, :, index(one.body)] for one in coordinates(ensemble)], axis=2)


def statistics(ensemble: Ensemble) -> list[Statistics | None]:
    """Return the statistics at each point of the grids; None if no run succeeded there."""
    values, well = values_of(ensemble), ensemble.ended_well
    slices = [ensemble.design.runs_at(k) for k in range(len(ensemble.design.points))]
    return [_statistics(values[runs][well[runs]]) if well[runs].any() else None for runs in slices]


def _statistics(values: np.ndarray) -> Statistics:
    count, mean = len(values), values.mean(axis=0)
    unknown = np.full_like(mean, np.nan)
    deviation = values.std(axis=0, ddof=1) if count > 1 else unknown
    return Statistics(
        count, mean, deviation, np.quantile(values, QUANTILES, axis=0), values.min(axis=0), values.max(axis=0),
        mean_error=deviation / np.sqrt(count - 1) if count > 1 else unknown,
        deviation_error=_deviation_error(values - mean, deviation) if count > 3 else unknown,
    )  # fmt: skip


def _deviation_error(gaps: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return the standard error of a standard deviation s, of any law: the root of Var s^2 over 2 s.

    Var s^2 = (m4 - s^4 (n - 3)/(n - 1))/n (A. M. Mood, F. A. Graybill, D. C. Boes, Introduction to the Theory of
    Statistics, 1974, sec. VI.2).
    """
    count = len(gaps)
    variance = ((gaps**4).mean(axis=0) - deviation**4 * (count - 3) / (count - 1)) / count
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(deviation > 0.0, np.sqrt(np.maximum(variance, 0.0)) / (2.0 * deviation), 0.0)


def integration_error(ensemble: Ensemble) -> np.ndarray:
    """Return the largest estimated error of the runs (n_t, 2): m and rad; NaN where none was estimated.

    Estimates do not count whole turns: an error of half a turn or more may be any number of turns.
    """
    errors = ensemble.errors[ensemble.ended_well]
    known = np.where(np.isnan(errors), -np.inf, errors).max(axis=0, initial=-np.inf)
    known[known[:, 1] >= np.pi, 1] = np.inf
    return np.where(np.isneginf(known), np.nan, known)


def not_shown(ensemble: Ensemble, points: list[Statistics | None]) -> list[Coordinate]:
    """Return the coordinates whose spread at the end is not large compared with the integration error.

    The spread is the standard deviation at a point of the grids, or without random numbers half of the range over the
    grids. Coordinates that do not vary are omitted.
    """
    error = integration_error(ensemble)[-1]
    spread = _spreads(ensemble, points)
    names = coordinates(ensemble)
    unit = np.array([error[1 if one.unit == "rad" else 0] for one in names])
    is_hidden = np.any((spread > 0.0) & (unit > SHOWN * spread), axis=0)
    return [one for one, hidden in zip(names, is_hidden, strict=True) if hidden]


def _spreads(ensemble: Ensemble, points: list[Statistics | None]) -> np.ndarray:
    """Return the spread of each coordinate at the end (n_points, n_coordinates), or over all points (1, ...)."""
    there = [one for one in points if one is not None]
    if not there:
        return np.zeros((0, len(coordinates(ensemble))))
    if ensemble.design.is_random:
        return np.array([one.deviation[-1] for one in there])
    ends = np.array([one.mean[-1] for one in there])
    return np.ptp(ends, axis=0)[None] / 2.0
