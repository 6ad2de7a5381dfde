"""Drift of the conserved parts of momentum."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric
from mbs_ref.observables import momentum_drift


def _curve(judged: Judged) -> np.ndarray | Absent:
    drift = momentum_drift(judged.scene, judged.path)
    return Absent() if drift is None else np.asarray(drift)


METRICS = (Metric("momentum_drift", "momentum drift", "kg m/s, kg m^2/s", _curve),)
