"""A disc that slides, then rolls: constant friction until the point of contact stands still."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.truth import Truth
from mbs_ref.scene import Scene

ROUNDOFF = 1e-14  # m


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """u = u0 - mu g t and r w = -(m r^2/I) mu g t until u + r w = 0; then both stay."""
    disc: Any = scene.bodies[0]
    ground: Any = scene.contacts[0]
    slowing = ground.friction.coefficient * -scene.gravity[1]
    ratio = disc.mass * ground.radius**2 / disc.inertia
    rolls = disc.velocity[0] / (slowing * (1.0 + ratio))
    sliding = np.minimum(times, rolls)
    lost = slowing * sliding  # m/s
    way = 0.5 * slowing * sliding**2 + lost * (times - sliding)
    x = disc.position[0] + disc.velocity[0] * times - way
    y = np.full_like(times, disc.position[1])
    angle = disc.angle - ratio / ground.radius * way
    how = "closed form: uniform slowing by friction on the sunk disc, then rolling"
    return Truth(np.stack((x, y), axis=1)[:, None], angle[:, None], ROUNDOFF, "exact", how)
