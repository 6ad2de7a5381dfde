"""Report an ensemble: sentences on its runs, corrections and resolved spread; plain data for JSON."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.scene import PointMass
from mbs_ref.simulate.many.ensemble.runs import Ensemble
from mbs_ref.simulate.many.ensemble.statistics import (
    QUANTILES,
    SHOWN,
    Coordinate,
    Statistics,
    coordinates,
    integration_error,
    not_shown,
    statistics,
)
from mbs_ref.trajectory import Status

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
    if point is not None:
        for k, one in enumerate(coordinates(ensemble)):
            bodies.setdefault(one.body, {})[one.name] = _over_time(point, one, k)
    return bodies


def _over_time(point: Statistics, one: Coordinate, k: int) -> dict[str, Any]:
    quantiles = {f"{100.0 * share:g} %": point.quantiles[j, :, k] for j, share in enumerate(QUANTILES)}
    return {
        "unit": one.unit, "runs": point.count, "mean": point.mean[:, k], "mean_standard_error": point.mean_error[:, k],
        "standard_deviation": point.deviation[:, k], "standard_deviation_standard_error": point.deviation_error[:, k],
        **quantiles, "least": point.least[:, k], "most": point.most[:, k],
    }  # fmt: skip
