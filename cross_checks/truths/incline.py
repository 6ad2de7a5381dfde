"""A block laid in equilibrium on an incline: it stays within the angle of friction, and slides uniformly beyond."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.truth import OutsideDomainError, Truth
from mbs_ref.scene import Scene

ROUNDOFF = 1e-13  # m, of the equilibrium of the sunk corners


def require_both_corners(scene: Scene) -> None:
    """Raise OutsideDomainError where a corner does not push at the start: the block topples about the other one.

    On hard ground that is where friction over normal force, min(tan(angle), mu), exceeds length over height.
    """
    corners: Any = scene.contacts
    if not all(corner.center[1] < 0.0 for corner in corners):
        raise OutsideDomainError("the block topples: the closed form holds while both of its corners push")


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """x = (g sin - mu g cos) t^2 / 2, or rest."""
    require_both_corners(scene)
    block: Any = scene.bodies[0]
    friction: Any = scene.contacts[0].friction
    pull = scene.gravity[0] + friction.coefficient * scene.gravity[1]
    x = block.position[0] + 0.5 * max(pull, 0.0) * times**2
    y = np.full_like(times, block.position[1])
    how = "closed form: rest within the angle of friction, uniform sliding beyond it"
    angle = np.full((len(times), 1), block.angle)
    return Truth(np.stack((x, y), axis=1)[:, None], angle, ROUNDOFF, "exact", how)
