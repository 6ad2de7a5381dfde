"""Significant figures of each body's place against an ephemeris: -log10 of the relative error."""

from __future__ import annotations

import numpy as np

from cross_checks.ephemerides.observed import Observed
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

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
