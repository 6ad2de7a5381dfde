"""The components of the error, each in its own unit: position, orientation, velocity, angular velocity."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric
from cross_checks.metrics.state_error import NAMES, UNITS


def _component(place: int):
    def curve(judged: Judged) -> np.ndarray | Absent:
        differences = judged.differences
        return Absent() if isinstance(differences, Absent) else differences.sizes[:, place]

    return curve


METRICS = tuple(
    Metric(f"{name.replace(' ', '_')}_error", f"{name} error", unit, _component(place))
    for place, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
)
