"""A thin slab that slides to rest: uniform slowing, then rest. A block of some height also tips back when it stops."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.truth import NoTruth, Truth
from cross_checks.truths.incline import require_both_corners
from mbs_ref.scene import Scene

ROUNDOFF = 1e-13  # m


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """x = v t - mu g t^2 / 2 until t = v / (mu g)."""
    require_both_corners(scene)
    block: Any = scene.bodies[0]
    friction: Any = scene.contacts[0].friction
    slowing = friction.coefficient * -scene.gravity[1]
    stops = block.velocity[0] / slowing if slowing > 0.0 else np.inf
    if scene.parameters["height"] and times[-1] > stops:
        return NoTruth("as it stops, a block of some height tips back on corners whose friction is not unique")
    under_way = np.minimum(times, stops)
    x = block.position[0] + block.velocity[0] * under_way - 0.5 * slowing * under_way**2
    y = np.full_like(times, block.position[1])
    how = "closed form: uniform slowing by Coulomb's friction, then rest"
    angle = np.full((len(times), 1), block.angle)
    return Truth(np.stack((x, y), axis=1)[:, None], angle, ROUNDOFF, "exact", how)
