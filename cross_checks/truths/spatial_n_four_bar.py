"""The N-four-bar modelled in space moves as the planar one does."""

from __future__ import annotations

import numpy as np

from cross_checks.truth import Truth
from cross_checks.truths import n_four_bar
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import from_axis_angle


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Lift the exact planar motion into the plane z = 0."""
    plane = n_four_bar.solve(scene, times)
    position = np.concatenate([plane.position, np.zeros((*plane.position.shape[:2], 1))], axis=2)
    turned = from_axis_angle((0.0, 0.0, 1.0), plane.orientation)
    return Truth(position, turned, plane.uncertainty, plane.kind, plane.how)
