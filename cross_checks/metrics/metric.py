"""What a metric is: one number of a run, with its name, its unit and the curve that it is the largest value of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cross_checks.metrics.state_error import Differences, from_truth
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import Scales, scales_of
from mbs_ref.trajectory import Trajectory


@dataclass(frozen=True)
class Absent:
    """Why a metric is not defined for a run."""

    reason: str = ""  # empty where nobody needs to be told


@dataclass(frozen=True)
class Judged:
    """A run and what it is held against."""

    scene: Scene
    path: Trajectory
    truth: Truth | NoTruth
    reference: Trajectory | None = None  # joint reactions to compare with

    @cached_property
    def scales(self) -> Scales:
        return scales_of(self.scene)

    @cached_property
    def differences(self) -> Differences | Absent:
        """How far the run is from the truth, component by component."""
        if isinstance(self.truth, NoTruth):
            return Absent(f"no error: {self.truth.reason}")
        return from_truth(self.scene, self.path, self.truth)


@dataclass(frozen=True)
class Metric:
    """A figure of every run; records, tables and the page list all of them."""

    name: str  # in records and CSV
    label: str  # over a column
    unit: str
    curve: Callable[[Judged], np.ndarray | Absent]  # (n_t,) or (1,); the figure is its largest value
    plotted: bool = False  # its curve is kept for the plots


def largest(curve: np.ndarray | Absent) -> float | None:
    """Return the largest value; None where it is not finite or there is none."""
    if isinstance(curve, Absent) or not curve.size:
        return None
    value = float(np.max(curve))
    return value if np.isfinite(value) else None
