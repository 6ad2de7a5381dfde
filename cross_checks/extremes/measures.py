"""How far an answer is from right, in units of the motion's own size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cross_checks.extremes.extreme import Measure
from cross_checks.metrics.drifts import compliance
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import observables
from mbs_ref.observables.distance import Partial, farthest, largest, point_distances
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

Positions = Callable[[np.ndarray], np.ndarray]  # times (n_t,) s -> centres of mass (n_t, n_bodies, dimension) m


def positions(exact: Positions, size: float = 1.0) -> Measure:
    """Judge centres of mass by their exact places; `size` of the motion in m."""

    def measure(scene: Scene, path: Trajectory) -> float:
        # sizes whose squares overflow are scaled first
        return farthest(scene, Partial(path.position / size), Partial(exact(path.times) / size))[0]

    return measure


def truth(solve: Callable[[Scene, np.ndarray], Truth | NoTruth], size: float | None = 1.0) -> Measure:
    """Judge world points by a truth's solver; `size` in m, or None for how far the truth's own bodies go."""

    def measure(scene: Scene, path: Trajectory) -> float:
        truth = solve(scene, path.times)
        if not isinstance(truth, Truth):
            raise LookupError(f"{scene.name} has no truth here: {truth}")
        start = Partial(np.broadcast_to(truth.position[:1], truth.position.shape))
        return float(largest(point_distances(scene, path, truth)[..., 0])) / (size or farthest(scene, truth, start)[0])

    return measure


def rates(exact: Positions, size: float) -> Measure:
    """Judge velocities; `size` in m/s."""

    def measure(scene: Scene, path: Trajectory) -> float:
        return farthest(scene, path, Partial(velocity=exact(path.times)))[2] / size

    return measure


def invariants(size: float = 1.0) -> Measure:
    """Judge energy (of the largest kinetic one) and constraints (of `size`, m): right motions keep both."""

    def measure(scene: Scene, path: Trajectory) -> float:
        balance = observables.energy_balance(scene, path)
        if not np.isfinite(balance.energy).all():
            return np.inf
        if balance.drift is None:
            raise LookupError(f"{scene.name} has no energy balance: {balance.reason}")
        swing = float(np.max(observables.kinetic_energy(scene, path)))
        drift = float(np.max(np.abs(balance.drift)))
        open_by = float(np.max(compliance(scene, path)[0], initial=0.0))
        return max(drift / swing if swing > 0.0 else np.inf, open_by / size)

    return measure


def worst(*measures: Measure) -> Measure:
    """Judge by the worst of several."""

    def measure(scene: Scene, path: Trajectory) -> float:
        return max(one(scene, path) for one in measures)

    return measure


def unjudged(scene: Scene, path: Trajectory) -> float:
    """Say that no answer can be right: for cases that must stop."""
    return float("inf")
