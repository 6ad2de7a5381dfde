"""What a metric is: one number of a run, with its name, its unit and the curve that it is the largest value of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cross_checks.metrics.state_error import Errors, from_truth
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import Scales, scales_of
from mbs_ref.trajectory import Trajectory


@dataclass(frozen=True)
class Absent:
    """Why a metric has no known figure for a run."""

    reason: str = ""  # empty where it needs no note
    below: float | None = None  # what the figure is at most, where the truth does not know it better


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
    def errors(self) -> Errors | Absent:
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
    curve: Callable[[Judged], np.ndarray | Absent]  # (n,), one value a sample where plotted; the figure is the largest
    plotted: bool = False  # its curve is kept for the plots


def largest(curve: np.ndarray | Absent) -> float | None:
    """Return the largest value; None where it is not finite or there is none."""
    if isinstance(curve, Absent) or not curve.size:
        return None
    value = float(np.max(curve))
    return value if np.isfinite(value) else None


def figures(curves: dict[str, np.ndarray | Absent]) -> dict[str, dict[str, Any]]:
    """Return `measures` and `bounds` of a record: every figure, and what unknown ones are at most."""
    below = {name: curve.below for name, curve in curves.items() if isinstance(curve, Absent)}
    return {
        "measures": {name: largest(curve) for name, curve in curves.items()},
        "bounds": {name: bound for name, bound in below.items() if bound is not None},
    }
