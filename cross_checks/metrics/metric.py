"""What a metric is: a named number of a run with a unit and a curve; and the differences of a run from its truth."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from cross_checks.truths import truth_for
from cross_checks.truths.truth import NO_ERROR, ONE_FIGURE, NoTruth, Truth
from mbs_ref import Scene, Trajectory
from mbs_ref.observables.distance import Motion, distances, farthest
from mbs_ref.scene.scales import Scales, scales_of


class Errors(NamedTuple):
    """Differences at each common sample, each (n_t, n_bodies, 4): m, rad, m/s, rad/s."""

    sizes: np.ndarray  # NaN where the truth lacks the quantity, or knows no figure of it
    bounds: np.ndarray  # what such an unknown size is at most: the difference and the uncertainty; NaN elsewhere
    counted: np.ndarray  # sizes of rates, and all differences of poses: their uncertainty is stated beside the total


def from_truth(scene: Scene, path: Motion, truth: Truth, other: Motion | None = None) -> Errors:
    """Return the distance of a run from the truth, or from another run in the components that the truth covers.

    Both are distances in one measure: two runs are no farther apart than the sum of their errors.
    """
    apart = distances(scene, path, other or truth)
    doubt = _uncertainty(scene, truth, len(apart))
    sizes = np.where(apart >= ONE_FIGURE * doubt, apart, np.nan)
    unknown = np.isnan(sizes) & np.isfinite(doubt)
    counted = np.concatenate((apart[..., :2], sizes[..., 2:]), axis=-1)
    return Errors(sizes, np.where(unknown, apart + doubt, np.nan), counted)


def off_truth(scene: Scene, path: Trajectory) -> list[float] | None:
    """Return the largest distances of a run from the scene's truth: m, rad, m/s, rad/s; NaN where unknown.

    None without a truth, and for a run that stops early.
    """
    truth = truth_for(scene, path.times) if path.ok else None
    return None if truth is None else farthest(scene, path, truth)


def known_to(scene: Scene, truth: Truth) -> float:
    """Return how well poses of a truth are known, in the measure of the error: the worse of places and turns."""
    return float(np.max(_uncertainty(scene, truth, 1)[..., :2] / (scales_of(scene).length, 1.0)))


def _uncertainty(scene: Scene, truth: Truth, n: int) -> np.ndarray:
    """Return how well a truth is known at its first n samples (n, 1, 4): m, rad, m/s, rad/s.

    Unless given, that of orientations is the angle of its `uncertainty` at the least radius of gyration.
    """
    length = scales_of(scene).length
    arm = min((body.gyration_radius for body in scene.bodies if body.gyration_radius > 0.0), default=length)
    turn = truth.uncertainty / arm if truth.turn_uncertainty is None else truth.turn_uncertainty
    rate = np.inf if truth.rate_uncertainty is None else truth.rate_uncertainty[:n]
    return np.stack(np.broadcast_arrays(truth.uncertainty, turn, rate, rate), axis=-1).reshape(-1, 1, 4)


@dataclass(frozen=True)
class Absent:
    """Why a metric has no known figure for a run."""

    reason: str = ""  # empty where it needs no note
    below: float | None = None  # what the figure is at most, where the truth does not know it better


@dataclass(frozen=True)
class Judged:
    """A run and the truth that it is compared with."""

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
            return Absent(NO_ERROR + self.truth.reason)
        return from_truth(self.scene, self.path, self.truth)


@dataclass(frozen=True)
class Metric:
    """A figure of every run; records, tables and the page list all of them."""

    name: str  # in records and CSV
    label: str  # over a column
    unit: str
    curve: Callable[[Judged], np.ndarray | Absent]  # (n,), one value a sample where plotted; the figure is the largest
    plotted: bool = False  # its curve is stored for the plots


def largest_value(curve: np.ndarray | Absent) -> float | None:
    """Return the largest value; None where it is not finite or there is none."""
    if isinstance(curve, Absent) or not curve.size:
        return None
    value = float(np.max(curve))
    return value if np.isfinite(value) else None


def figures(curves: dict[str, np.ndarray | Absent]) -> dict[str, dict[str, Any]]:
    """Return `measures` and `bounds` of a record: every figure, and what unknown ones are at most."""
    below = {name: curve.below for name, curve in curves.items() if isinstance(curve, Absent)}
    return {
        "measures": {name: largest_value(curve) for name, curve in curves.items()},
        "bounds": {name: bound for name, bound in below.items() if bound is not None},
    }
