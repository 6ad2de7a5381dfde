"""Statistics of an ensemble over time with their standard errors, and the report on its runs."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.scene import PointMass
from mbs_ref.scene.base.attached import COORDINATES
from mbs_ref.simulate.many.ensemble.runs import Ensemble
from mbs_ref.trajectory import Status

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
    scene, units = ensemble.scene, {"angle": "rad"}
    each = [(name, units.get(name, "m")) for name in COORDINATES[scene.dimension]]
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


MAX_NAMED = 6  # coordinates with an unresolved spread that a sentence names


def account(ensemble: Ensemble, points: list[Statistics | None]) -> list[str]:
    """Return the sentences, the most important ones last."""
    return [*_method(ensemble), *_ends(ensemble), *_projected(ensemble), *_resolution(ensemble, points)]


def _method(ensemble: Ensemble) -> Iterator[str]:
    yield ensemble.design.sentence()
    methods = Counter(name for name in ensemble.methods if name).most_common()
    used = ", ".join(name if len(methods) == 1 else f"{name} ({count} runs)" for name, count in methods)
    yield "; ".join(filter(None, (used, *ensemble.how)))


def _ends(ensemble: Ensemble) -> Iterator[str]:
    """Yield how runs ended, with the first message of each kind of failure."""
    count = len(ensemble.statuses)
    if not ensemble.is_complete:
        yield f"interrupted after {count} of {ensemble.design.n_runs} runs"
    yield f"{count} runs: " + ", ".join(f"{of} {status}" for status, of in ensemble.counts.items())
    firsts = dict(zip(reversed(ensemble.statuses), reversed(ensemble.messages), strict=True))
    yield from (f"{status}: {message}" for status, message in firsts.items() if status is not Status.SUCCESS)
    ended = ensemble.reached[[status is Status.STOP_EVENT for status in ensemble.statuses]]
    if len(ended):
        spread = f", standard deviation {ended.std(ddof=1):.4g} s" if len(ended) > 1 else ""
        yield f"an event ended {len(ended)} runs, at {ended.mean():.6g} s on average{spread}, " + (
            f"from {ended.min():.6g} to {ended.max():.6g} s"
        )
    omitted = count - int(ensemble.ended_well.sum())
    if omitted:
        yield f"all figures omit {omitted} of {count} runs, which failed"


def _projected(ensemble: Ensemble) -> Iterator[str]:
    poses, rates = ensemble.corrections.max(axis=0, initial=0.0)
    tolerance = ensemble.settings.initial_tolerance
    count = int(np.sum(ensemble.corrections.max(axis=1) > tolerance))
    hint = "" if poses > tolerance else "; --keep fixes a velocity and fits the others"
    if count:
        yield (
            f"the starts of {count} runs were projected, by up to {poses:.3g} m or rad and {rates:.3g} m/s or rad/s: "
            f"the varied values differ from the requested ones there{hint}"
        )


def _resolution(ensemble: Ensemble, points: list[Statistics | None]) -> Iterator[str]:
    """Yield the integration error of the runs, and the coordinates whose spread it hides."""
    if not ensemble.ended_well.any():
        return
    metres, radians = integration_error(ensemble)[-1]
    if np.isnan(metres):
        yield "no run's integration error was estimated: whether it hides the spread is unknown"
        return
    if np.isinf(metres):
        yield "estimated integration error: some runs have no correct digit at their end; use a smaller --t-end"
        return
    angle = f"{radians:.3g} rad" if np.isfinite(radians) else "any number of turns"
    turned = "" if all(isinstance(body, PointMass) for body in ensemble.scene.bodies) else f" and {angle}"
    yield f"estimated integration error of the runs: at most {metres:.3g} m{turned}"
    hidden = not_shown(ensemble, points)
    if hidden:
        yield (
            f"the spread of {_listed(hidden)} is not shown by these runs: their integration error may exceed "
            f"{SHOWN:g} of it; use a smaller --rtol or --step"
        )


def _listed(hidden: list[Coordinate]) -> str:
    names = [f"{one.body}.{one.name}" for one in hidden[:MAX_NAMED]]
    return ", ".join(names) + (f" and {len(hidden) - MAX_NAMED} more" if len(hidden) > MAX_NAMED else "")


def to_dict(ensemble: Ensemble) -> dict[str, Any]:
    """Return plain data for JSON, all but the samples: inputs and end of every run, statistics over time."""
    points, design = statistics(ensemble), ensemble.design
    estimates = np.fmax.reduce(ensemble.errors, axis=1)  # NaN where a run has none
    ends = zip(ensemble.statuses, ensemble.messages, ensemble.methods, ensemble.reached, estimates, strict=True)
    return {
        "scene": ensemble.scene.name,
        "parameters": ensemble.scene.parameters,
        "settings": ensemble.settings.model_dump(exclude_defaults=True),
        "vary": {name: str(law) for name, law in design.laws.items()},
        "samples": design.count,
        "seed": design.seed,
        "counts": ensemble.counts,
        "account": account(ensemble, points),
        "wall_s": ensemble.wall_s,
        "runs_per_s": ensemble.runs_per_s,
        "times": ensemble.times,
        "integration_error": dict(zip(("m", "rad"), integration_error(ensemble).T, strict=True)),
        "points": [
            {"at": dict(zip(design.grids, at.tolist(), strict=True)), "bodies": _bodies(ensemble, one)}
            for at, one in zip(design.points, points, strict=True)
        ],
        "runs": [
            {"values": dict(zip(design.names, values.tolist(), strict=True)), "status": str(status), "message": message,
             "method": method, "reached": reached, "estimated_error": {"m": error[0], "rad": error[1]}}
            for values, (status, message, method, reached, error) in zip(design.values, ends, strict=False)
        ],
    }  # fmt: skip


def _bodies(ensemble: Ensemble, point: Statistics | None) -> dict[str, Any]:
    bodies: dict[str, Any] = {}
    if point is None:
        return bodies
    for k, one in enumerate(coordinates(ensemble)):
        bodies.setdefault(one.body, {})[one.name] = {
            "unit": one.unit, "runs": point.count,
            "mean": point.mean[:, k], "mean_standard_error": point.mean_error[:, k],
            "standard_deviation": point.deviation[:, k],
            "standard_deviation_standard_error": point.deviation_error[:, k],
            **{f"{100.0 * share:g} %": point.quantiles[j, :, k] for j, share in enumerate(QUANTILES)},
            "least": point.least[:, k], "most": point.most[:, k],
        }  # fmt: skip
    return bodies
