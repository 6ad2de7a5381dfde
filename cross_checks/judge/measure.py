"""Every metric of one run, as the fields of a Record."""

from typing import Any

import numpy as np

from cross_checks import metrics
from cross_checks.ephemerides import Observed, observe
from cross_checks.metrics.contact_figures import contact_figures
from cross_checks.metrics.drifts import worst_joint
from cross_checks.metrics.errors import significant_figures
from cross_checks.metrics.metric import Absent, Judged, figures, known_to
from cross_checks.records.record import Error
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Trajectory
from mbs_ref.observables.distance import NAMES, largest, units_of

BROKEN = 1e-3  # m, rad: a joint this far open is named in the notes


def measure(judged: Judged) -> dict[str, Any]:
    """Return measures, bounds, error, curves, figures and notes of a run; None with a note for what is not defined."""
    if not len(judged.path.times):
        return {"measures": dict.fromkeys(metrics.every()), "error": None, "notes": tuple(judged.path.notes)}
    with np.errstate(over="ignore", invalid="ignore"):  # a run that blew up may overflow here: not finite, so no figure
        return _measured(judged)


def _measured(judged: Judged) -> dict[str, Any]:
    scene, path = judged.scene, judged.path
    curves = {name: metric.curve(judged) for name, metric in metrics.every().items()}
    reasons = [curve.reason for curve in curves.values() if isinstance(curve, Absent) and curve.reason]
    error, history = error_of(judged)
    observed = observe(scene, float(path.times[-1]))
    return {
        **figures(curves),
        "error": error,
        "notes": (*_notes(judged), *reasons, *unjudged(error), *_told(observed)),
        "figures": significant_figures(scene, path, observed) if isinstance(observed, Observed) else {},
        "contact": contact_figures(scene, path),
        "events": _declared_events(scene, path),
        "history": _history(path, curves, history),
    }


def error_of(judged: Judged) -> tuple[Error | None, list[float | None] | None]:
    """Return the error of a run and its curve over time (n_t,), with None where the truth knows nothing.

    None without a truth, and where the error is not finite.
    """
    errors, truth, scales = judged.errors, judged.truth, judged.scales
    if isinstance(errors, Absent) or not isinstance(truth, Truth):
        return None, None
    relative = errors.counted / units_of(scales)
    if not relative.size or not np.isfinite(value := float(largest(relative))):
        return None, None
    sample, body, part = np.unravel_index(int(np.nanargmax(relative)), relative.shape)
    worst = f"{NAMES[part]} of {judged.scene.body_names[body]} at t = {judged.path.times[sample]:.4g} s"
    known, source = known_to(judged.scene, truth), f"{truth.kind}: {truth.how}"
    curve = gaps_as_none(largest(largest(relative, -1), -1))
    return Error(value, source, known, curve[-1], worst, scales.length, scales.time), curve


def gaps_as_none(curve: np.ndarray) -> list[float | None]:
    """Return a curve (n,) as a list, with None where it is unknown."""
    return [float(value) if np.isfinite(value) else None for value in curve]


def _history(path: Trajectory, curves: dict[str, Any], error: list | None) -> dict[str, list[float | None]]:
    plotted = {name: curve for name, curve in curves.items() if metrics.every()[name].plotted}
    estimate = None if path.estimate is None else path.estimate.over_time
    every = {"t": path.times, "estimate": estimate, **plotted}
    known = {name: c for name, c in every.items() if isinstance(c, np.ndarray) and np.isfinite(c).all()}
    listed = {name: curve.tolist() for name, curve in known.items()}
    return listed if error is None else listed | {"error": error}


def _declared_events(scene: Scene, path: Trajectory) -> dict[str, list[float]]:
    """The times (s) of every declared event; empty where the engine locates none."""
    if path.event_times is None:
        return {}
    when, source = path.event_times.T
    places = {event.name: path.event_names.index(event.name) for event in scene.events}
    return {name: when[source == place].tolist() for name, place in places.items()}


def unjudged(error: Error | None) -> tuple[str, ...]:
    """Return the sentence that a truth is not known well enough for this error, if so."""
    if error is None or error.is_judged:
        return ()
    return (f"error not judged: the truth is known to {error.uncertainty:.1e} of the scene",)


def _told(observed: Observed | NoTruth | None) -> tuple[str, ...]:
    if isinstance(observed, NoTruth):
        return (f"no figures: {observed.reason}",)
    return () if observed is None else (f"figures against {observed.how}",)


def _notes(judged: Judged) -> tuple[str, ...]:
    worst = worst_joint(judged.scene, judged.path)
    if worst is None or worst[1] <= BROKEN:
        return tuple(judged.path.notes)
    return (*judged.path.notes, f"joint {worst[0]} is open by {worst[1]:.2g} (m or rad)")
