"""Significant figures of each body's place against an ephemeris: -log10 of the relative error."""

from __future__ import annotations

import numpy as np

from cross_checks.truths import Truth
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

CENTERS = {"moon": "earth"}  # a satellite is seen from its planet, everything else from the truth's origin
MOST = 16.0  # figures a double can hold


def significant_figures(scene: Scene, path: Trajectory, truth: Truth) -> dict[str, float]:
    """Return figures per body at the last sample, seen from the truth's origin; empty where it has none."""
    if truth.origin is None or not len(path.times):
        return {}
    names, last = scene.body_names, len(path.times) - 1
    found = {}
    for k, name in enumerate(names):
        center = CENTERS.get(name, truth.origin)
        if name == truth.origin or center not in names or not truth.covers(k):
            continue
        c = names.index(center)
        true = truth.position[last, k] - truth.position[last, c]
        gap = np.linalg.norm(path.position[last, k] - path.position[last, c] - true) / np.linalg.norm(true)
        found[name] = float(min(MOST, -np.log10(gap))) if gap > 0.0 else MOST
    return found
