"""Drift of the energy balance."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric
from mbs_ref.observables import energy_balance
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

RESOLVED = 0.1  # of the drift: the work integral must be known at least this well
NEGLIGIBLE = 1e-9  # of the energy: a work integral known to this is good enough whatever the drift


def energy_drift(scene: Scene, trajectory: Trajectory) -> tuple[np.ndarray | None, str]:
    """Return |E(t) - E(0) - work| (n_t,), J, or None and the reason why it is not defined here."""
    balance = energy_balance(scene, trajectory)
    if balance.drift is None:
        return None, balance.reason
    drift = np.abs(balance.drift)
    if balance.resolution > max(RESOLVED * float(np.max(drift)), NEGLIGIBLE * float(np.max(np.abs(balance.energy)))):
        text = f"the samples resolve the work to {balance.resolution:.1e} J only; ask for more samples"
        return None, text
    return drift, ""


def _curve(judged: Judged) -> np.ndarray | Absent:
    drift, reason = energy_drift(judged.scene, judged.path)
    return Absent(f"no energy drift: {reason}") if drift is None else drift


METRICS = (Metric("energy_drift", "energy drift", "J", _curve, plotted=True),)
