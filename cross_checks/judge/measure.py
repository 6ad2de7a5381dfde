"""Every metric of one run, as the fields of a Record."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.ephemerides.observed import Observed, Unobserved, observe
from cross_checks.metrics.compliance import compliance, worst_joint
from cross_checks.metrics.contact_figures import contact_figures
from cross_checks.metrics.energy_drift import energy_drift
from cross_checks.metrics.momentum_drift import momentum_drift
from cross_checks.metrics.orientation_error import orientation_error
from cross_checks.metrics.pose_error import pose_error
from cross_checks.metrics.reaction_error import reaction_error
from cross_checks.metrics.significant_figures import significant_figures
from cross_checks.records.record import Error
from cross_checks.truths import NoTruth, Truth
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.trajectory import Trajectory

BROKEN = 1e-3  # m, rad: a joint this far open is named in the notes


def measure(scene: Scene, path: Trajectory, truth: Truth | NoTruth, reference: Trajectory | None) -> dict[str, Any]:
    """Return compliance, drifts, error, history and notes; None with a note for what is not defined."""
    if not len(path.times):
        return _nothing(path)
    with np.errstate(over="ignore", invalid="ignore"):  # a run that blew up may overflow here: not finite, so no figure
        return _measured(scene, path, truth, reference)


def _measured(scene: Scene, path: Trajectory, truth: Truth | NoTruth, reference: Trajectory | None) -> dict[str, Any]:
    position, velocity = compliance(scene, path)
    energy, why_no_energy = energy_drift(scene, path)
    momentum = momentum_drift(scene, path)
    error = pose_error(scene, path, truth) if isinstance(truth, Truth) else None
    observed = observe(scene, float(path.times[-1]))
    estimate = None if path.estimate is None else path.estimate.over_time
    history = {"t": path.times, "compliance": position, "energy_drift": energy, "error": error, "estimate": estimate}
    return {
        "compliance": {"position": _largest(position, _between_samples(path)), "velocity": _largest(velocity)},
        "energy_drift": _largest(energy),
        "momentum_drift": _largest(momentum),
        "error": _error(error, truth),
        "orientation_error": _orientation(scene, path, truth),
        "figures": significant_figures(scene, path, observed) if isinstance(observed, Observed) else {},
        "reaction_error": None if reference is None else reaction_error(path.reactions, reference.reactions),
        "notes": (*_notes(scene, path, truth, why_no_energy), *_unjudged(_error(error, truth)), *_told(observed)),
        "contact": contact_figures(scene, path),
        "events": _declared_events(scene, path),
        "history": {key: part.tolist() for key, part in history.items() if part is not None and _is_finite(part)},
    }


def _declared_events(scene: Scene, path: Trajectory) -> dict[str, list[float]]:
    """The times (s) of every declared event; empty where the engine locates none."""
    if path.event_times is None:
        return {}
    when, source = path.event_times.T
    places = {event.name: path.event_names.index(event.name) for event in scene.events}
    return {name: when[source == place].tolist() for name, place in places.items()}


def _nothing(path: Trajectory) -> dict[str, Any]:
    empty = {"compliance": {"position": None, "velocity": None}, "error": None, "notes": tuple(path.notes)}
    return empty | {"energy_drift": None, "momentum_drift": None, "reaction_error": None}


def _is_finite(part: np.ndarray) -> bool:
    return bool(np.all(np.isfinite(part)))


def _largest(*parts: np.ndarray | None) -> float | None:
    """The largest of all; None where it is not finite or there is nothing."""
    found = [float(np.max(part)) for part in parts if part is not None and len(part)]
    return max(found) if found and np.all(np.isfinite(found)) else None


def _between_samples(path: Trajectory) -> np.ndarray | None:
    return None if path.step_compliance is None else path.step_compliance[:, 1]


def _error(error: np.ndarray | None, truth: Truth | NoTruth) -> Error | None:
    if error is None or isinstance(truth, NoTruth) or not _is_finite(error):
        return None
    return Error(float(np.max(error)), "m", f"{truth.kind}: {truth.how}", truth.uncertainty, float(error[-1]))


def _unjudged(error: Error | None) -> tuple[str, ...]:
    if error is None or error.is_judged:
        return ()
    told = f"the truth, known to {error.uncertainty:.1e} m, judges no error below {error.floor:.1e} m"
    return (f"error not judged: {told}",)


def _orientation(scene: Scene, path: Trajectory, truth: Truth | NoTruth) -> float | None:
    """The largest geodesic angle (rad) from the truth, in space."""
    turning = any(isinstance(body, SpatialBody) for body in scene.bodies)
    if not turning or isinstance(truth, NoTruth):
        return None
    return _largest(orientation_error(path, truth).ravel())


def _told(observed: Observed | Unobserved | None) -> tuple[str, ...]:
    if isinstance(observed, Unobserved):
        return (f"no figures: {observed.reason}",)
    return () if observed is None else (f"figures against {observed.how}",)


def _notes(scene: Scene, path: Trajectory, truth: Truth | NoTruth, why_no_energy: str) -> tuple[str, ...]:
    found = list(path.notes)
    if isinstance(truth, NoTruth):
        found.append(f"no error: {truth.reason}")
    if why_no_energy:
        found.append(f"no energy drift: {why_no_energy}")
    worst = worst_joint(scene, path)
    if worst is not None and worst[1] > BROKEN:
        found.append(f"joint {worst[0]} is open by {worst[1]:.2g} (m or rad)")
    return tuple(found)
