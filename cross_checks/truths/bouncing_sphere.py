"""The free impact of the plane, along the normal of a tilted floor."""

from __future__ import annotations

import numpy as np

from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import bouncing_ball
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scenes.bouncing import floor_normal


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """The ball moves along the normal alone and does not turn."""
    given = dict(scene.parameters)
    normal = floor_normal(float(given.pop("tilt")), float(given.pop("heading")))
    planar = bouncing_ball.solve(scenes.make("bouncing_ball", **given), times)
    if isinstance(planar, NoTruth):
        return planar
    position = planar.position[:, :, 1:] * normal
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1, 1))
    return Truth(position, still, planar.uncertainty, planar.kind, planar.how)
