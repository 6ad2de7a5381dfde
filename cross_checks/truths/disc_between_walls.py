"""The disc on its line between two one-sided springs, or two rigid walls, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.mechanisms.unilateral import Line, Unilateral, line_motion
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import RigidLaw


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate."""
    disc: Any = scene.bodies[0]
    contacts = []
    for contact, sign in zip(scene.contacts, (1.0, -1.0), strict=True):
        wall: Any = contact
        place = sign * wall.point_1[0] + wall.radius
        contacts.append(
            Unilateral((sign,), place, restitution=wall.law.restitution)
            if isinstance(wall.law, RigidLaw)
            else Unilateral((sign,), place, wall.law.stiffness, wall.law.damping)
        )
    mass, start = np.array([disc.mass]), np.array([disc.position[0]])
    line = Line(mass, np.zeros(1), start, np.array([disc.velocity[0]]), tuple(contacts))
    x, uncertainty = line_motion(line, times)
    how = "free flight and half oscillations, matrix exponentials between instants found to roundoff"
    return Truth(np.stack((x, np.zeros_like(x)), axis=2), np.zeros_like(x), uncertainty, "exact", how)
