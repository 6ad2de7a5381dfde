"""The components of the error, each in its own unit: position, orientation, velocity, angular velocity."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric
from mbs_ref.observables.distance import NAMES, UNITS, largest


def _component(place: int):
    def curve(judged: Judged) -> np.ndarray | Absent:
        errors = judged.errors
        if isinstance(errors, Absent):
            return Absent()
        sizes, bound = errors.sizes[..., place], float(largest(errors.bounds[..., place]))
        known = sizes[~np.isnan(sizes)]
        return known if known.size else Absent(below=bound if np.isfinite(bound) else None)

    return curve


METRICS = tuple(
    Metric(f"{name.replace(' ', '_')}_error", f"{name} error", unit, _component(place))
    for place, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
)
