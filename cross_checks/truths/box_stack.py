"""The stack stays upright by symmetry: one coordinate a box, two corners as one spring-damper, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.mechanisms.unilateral import Line, Unilateral, line_motion
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scenes.stacks import BOX_HEIGHT as HEIGHT


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Heights of the boxes."""
    bodies: Any = scene.bodies
    n = len(bodies)
    law: Any = scene.contacts[0].law
    mass = np.array([b.mass for b in bodies])
    contacts = tuple(
        Unilateral(
            tuple(float(j == k) - float(j == k - 1) for j in range(n)), HEIGHT if k else 0.5 * HEIGHT,
            2.0 * law.stiffness, 2.0 * law.damping, by_force=True,
        )
        for k in range(n)
    )  # fmt: skip
    line = Line(mass, mass * scene.gravity[1], np.array([b.position[1] for b in bodies]), np.zeros(n), contacts)
    y, uncertainty = line_motion(line, times)
    how = "upright by symmetry: one-sided spring-dampers on a line, matrix exponentials between located instants"
    return Truth(np.stack((np.zeros_like(y), y), axis=2), np.zeros_like(y), uncertainty, "exact", how)
