"""Errors of a run: by component from the truth, of joint reactions, and in significant figures from an ephemeris."""

import numpy as np

from cross_checks.ephemerides import Observed
from cross_checks.metrics.metric import Absent, Judged, Metric
from mbs_ref import Scene, Trajectory
from mbs_ref.observables.distance import NAMES, UNITS, largest


def _component(place: int):
    def curve(judged: Judged) -> np.ndarray | Absent:
        errors = judged.errors
        if isinstance(errors, Absent):
            return Absent()
        sizes, bound = errors.sizes[..., place], float(largest(errors.bounds[..., place]))
        known = sizes[~np.isnan(sizes)]
        return known if known.size else Absent(below=bound if np.isfinite(bound) else None)

    return curve


COMPONENTS = tuple(
    Metric(f"{name.replace(' ', '_')}_error", f"{name} error", unit, _component(place))
    for place, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
)


def reaction_error(reactions: dict[str, np.ndarray], reference: dict[str, np.ndarray]) -> float | None:
    """Return the largest difference (N, N m) over the joints and samples both report; None without any.

    Each entry is (n_t, 3): the force on body_b at the joint point along the world axes, and the torque.
    """
    pairs = [(reactions[name], reference[name]) for name in sorted(reactions.keys() & reference.keys())]
    gaps = [float(np.max(np.abs(a[: len(b)] - b[: len(a)]), initial=0.0)) for a, b in pairs]
    finite = [gap for gap in gaps if np.isfinite(gap)]
    return max(finite) if finite and len(finite) == len(gaps) else None


def _reaction_curve(judged: Judged) -> np.ndarray | Absent:
    error = None if judged.reference is None else reaction_error(judged.path.reactions, judged.reference.reactions)
    return Absent() if error is None else np.array([error])


ORIGIN = "sun"
CENTERS = {"moon": "earth"}  # a satellite is seen from its planet, everything else from the Sun
MOST = 16.0  # figures a double can hold


def significant_figures(scene: Scene, path: Trajectory, observed: Observed) -> dict[str, float]:
    """Return figures per body at the last sample."""
    names = scene.body_names
    figures = {}
    for k, name in enumerate(names):
        center = CENTERS.get(name, ORIGIN)
        if name == ORIGIN or center not in names or not np.all(np.isfinite(observed.position[k])):
            continue
        c = names.index(center)
        true = observed.position[k] - observed.position[c]
        gap = np.linalg.norm(path.position[-1, k] - path.position[-1, c] - true) / np.linalg.norm(true)
        figures[name] = float(min(MOST, -np.log10(gap))) if gap > 0.0 else MOST
    return figures


METRICS = (*COMPONENTS, Metric("reaction_error", "joint force error", "N, N m", _reaction_curve))
