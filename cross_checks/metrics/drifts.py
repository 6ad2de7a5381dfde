"""Drifts of what a motion conserves: constraints, energy and momentum."""

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric
from mbs_ref import Scene, Trajectory
from mbs_ref.observables import energy_balance, momentum_drift, rows


def compliance(scene: Scene, trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest |C| (m, rad) and |dC/dt| (m/s, rad/s) over the rows, each (n_t,); zero without joints."""
    constraints = rows(scene, trajectory)
    return tuple(np.max(np.abs(part), axis=1, initial=0.0) for part in (constraints.residual, constraints.rate))  # type: ignore[return-value]


def worst_joint(scene: Scene, trajectory: Trajectory) -> tuple[str, float] | None:
    """Return the joint that is broken most and by how much (m, rad); None without joints."""
    constraints = rows(scene, trajectory)
    if not constraints.joints or not len(trajectory.times):
        return None
    largest = np.max(np.abs(constraints.residual), axis=0)
    k = int(np.argmax(largest))
    return constraints.joints[k], float(largest[k])


def _position(judged: Judged) -> np.ndarray:
    """|C| at the samples and, in-house, the largest over the steps before each."""
    at_samples = compliance(judged.scene, judged.path)[0]
    steps = judged.path.step_compliance
    if steps is None or not len(at_samples):
        return at_samples
    between = np.zeros_like(at_samples)
    between[: len(steps)] = steps[: len(between), 1]
    return np.maximum(at_samples, between)


RESOLVED = 0.1  # of the drift: the work integral must be known at least this well
NEGLIGIBLE = 1e-9  # of the energy: a work integral known to this is good enough whatever the drift


def energy_drift(scene: Scene, trajectory: Trajectory) -> np.ndarray | Absent:
    """Return |E(t) - E(0) - work| (n_t,), J, or the reason why it is not defined here."""
    balance = energy_balance(scene, trajectory)
    if balance.drift is None:
        return Absent(balance.reason and f"no energy drift: {balance.reason}")
    drift = np.abs(balance.drift)
    if balance.resolution > max(RESOLVED * float(np.max(drift)), NEGLIGIBLE * float(np.max(np.abs(balance.energy)))):
        error = f"the work integral has an error of up to {balance.resolution:.2g} J at this output interval"
        return Absent(f"no energy drift: {error}; use more samples")
    return drift


def _momentum_curve(judged: Judged) -> np.ndarray | Absent:
    drift = momentum_drift(judged.scene, judged.path)
    return Absent() if drift is None else np.asarray(drift)


METRICS = (
    Metric("compliance_position", "compliance", "m, rad", _position, plotted=True),
    Metric("compliance_velocity", "rate compliance", "m/s, rad/s", lambda run: compliance(run.scene, run.path)[1]),
    Metric("energy_drift", "energy drift", "J", lambda run: energy_drift(run.scene, run.path), plotted=True),
    Metric("momentum_drift", "momentum drift", "kg m/s, kg m^2/s", _momentum_curve),
)
