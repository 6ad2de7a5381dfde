"""How far the constraints are broken: |C| and |dC/dt|."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Judged, Metric
from mbs_ref.observables import rows
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory


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


METRICS = (
    Metric("compliance_position", "compliance", "m, rad", _position, plotted=True),
    Metric("compliance_velocity", "rate compliance", "m/s, rad/s", lambda run: compliance(run.scene, run.path)[1]),
)
