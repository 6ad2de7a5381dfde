"""How far an answer is from right, in units of the motion's own size."""

from collections.abc import Callable

import numpy as np

from cross_checks.extremes.extreme import Measure, Measured
from cross_checks.metrics.drifts import compliance
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Trajectory, observables
from mbs_ref.observables.distance import Partial, farthest, largest, point_distances

Positions = Callable[[np.ndarray], np.ndarray]  # times (n_t,) s -> centres of mass (n_t, n_bodies, dimension) m


def in_plane(*xy: np.ndarray | float) -> np.ndarray:
    """Return vectors (n_t, n, 2) of n bodies from x and y of each in turn."""
    columns = np.stack(np.broadcast_arrays(*xy), axis=-1)
    return columns.reshape(*columns.shape[:-1], -1, 2)


def positions(exact: Positions, size: float = 1.0) -> Measure:
    """Judge centres of mass by their exact places; `size` of the motion in m."""

    def measure(scene: Scene, path: Trajectory) -> Measured:
        # sizes whose squares overflow are scaled first
        return Measured(farthest(scene, Partial(path.position / size), Partial(exact(path.times) / size))[0])

    return measure


def truth(solve: Callable[[Scene, np.ndarray], Truth | NoTruth], size: float | None = 1.0) -> Measure:
    """Judge world points by a truth's solver; `size` in m, or None for how far the truth's own bodies go."""

    def measure(scene: Scene, path: Trajectory) -> Measured:
        truth = solve(scene, path.times)
        if not isinstance(truth, Truth):
            raise LookupError(f"{scene.name} has no truth here: {truth}")
        start = Partial(np.broadcast_to(truth.position[:1], truth.position.shape))
        unit = size or farthest(scene, truth, start)[0]
        return Measured(float(largest(point_distances(scene, path, truth)[..., 0])) / unit, truth.uncertainty / unit)

    return measure


def rates(exact: Positions, size: float) -> Measure:
    """Judge velocities; `size` in m/s."""
    return lambda scene, path: Measured(farthest(scene, path, Partial(velocity=exact(path.times)))[2] / size)


def open_joints(size: float = 1.0) -> Measure:
    """Judge by how far joints and rods open, of `size` (m)."""
    return lambda scene, path: Measured(float(np.max(compliance(scene, path)[0], initial=0.0)) / size)


def energy(scene: Scene, path: Trajectory) -> Measured:
    """Judge the energy's drift over the largest kinetic energy."""
    balance = observables.energy_balance(scene, path)
    if not np.isfinite(balance.energy).all():
        return Measured(np.inf)
    if balance.drift is None:
        raise LookupError(f"{scene.name} has no energy balance: {balance.reason}")
    swing = float(np.max(observables.kinetic_energy(scene, path)))
    return Measured(float(np.max(np.abs(balance.drift))) / swing if swing > 0.0 else np.inf)


def worst(*measures: Measure) -> Measure:
    """Judge by the worst of several."""
    return lambda scene, path: max(one(scene, path) for one in measures)


invariants = worst(energy, open_joints())  # which every right motion keeps


def unjudged(scene: Scene, path: Trajectory) -> Measured:
    """Return that no answer can be right: for cases that must stop."""
    return Measured(float("inf"))
