"""An ensemble as plain data: for JSON, and as arrays for a file."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbs_ref.simulate.ensemble.account import account
from mbs_ref.simulate.ensemble.runs import Ensemble
from mbs_ref.simulate.ensemble.statistics import (
    QUANTILES,
    Coordinate,
    Statistics,
    coordinates,
    integration_error,
    statistics,
)


def to_dict(ensemble: Ensemble) -> dict[str, Any]:
    """Return everything but the samples themselves: inputs and end of every run, statistics over time."""
    found, design = statistics(ensemble), ensemble.design
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
        "account": account(ensemble, found),
        "wall_s": ensemble.wall_s,
        "runs_per_s": ensemble.runs_per_s,
        "times": ensemble.times,
        "integration_error": dict(zip(("m", "rad"), integration_error(ensemble).T, strict=True)),
        "points": [
            {"at": dict(zip(design.grids, at.tolist(), strict=True)), "bodies": _bodies(ensemble, one)}
            for at, one in zip(design.points, found, strict=True)
        ],
        "runs": [
            {"values": dict(zip(design.names, values.tolist(), strict=True)), "status": str(status), "message": message,
             "method": method, "reached": reached, "estimated_error": {"m": error[0], "rad": error[1]}}
            for values, (status, message, method, reached, error) in zip(design.values, ends, strict=False)
        ],
    }  # fmt: skip


def _bodies(ensemble: Ensemble, found: Statistics | None) -> dict[str, Any]:
    bodies: dict[str, Any] = {}
    if found is not None:
        for k, one in enumerate(coordinates(ensemble)):
            bodies.setdefault(one.body, {})[one.name] = _over_time(found, one, k)
    return bodies


def _over_time(found: Statistics, one: Coordinate, k: int) -> dict[str, Any]:
    quantiles = {f"{100.0 * share:g} %": found.quantiles[j, :, k] for j, share in enumerate(QUANTILES)}
    return {
        "unit": one.unit, "runs": found.count, "mean": found.mean[:, k], "mean_standard_error": found.mean_error[:, k],
        "standard_deviation": found.deviation[:, k], "standard_deviation_standard_error": found.deviation_error[:, k],
        **quantiles, "least": found.least[:, k], "most": found.most[:, k],
    }  # fmt: skip
