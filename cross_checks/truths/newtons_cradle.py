"""The cradle on its line: free flight between impacts, or one-sided springs, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.mechanisms.unilateral import Line, Unilateral, line_motion
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import RigidLaw


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """One coordinate a ball."""
    bodies: Any = scene.bodies
    n = len(bodies)
    contacts = []
    for k, contact in enumerate(scene.contacts):
        law: Any = contact.law
        row = tuple(float(j == k + 1) - float(j == k) for j in range(n))
        reach = contact.radius_a + contact.radius_b  # type: ignore[union-attr]
        contacts.append(
            Unilateral(row, reach, restitution=law.restitution)
            if isinstance(law, RigidLaw)
            else Unilateral(row, reach, law.stiffness, law.damping, by_force=True)
        )
    line = Line(
        np.array([b.mass for b in bodies]), np.zeros(n), np.array([b.position[0] for b in bodies]),
        np.array([b.velocity[0] for b in bodies]), tuple(contacts),
    )  # fmt: skip
    x, uncertainty = line_motion(line, times)
    how = "one-sided contacts on a line, matrix exponentials between instants found to roundoff"
    return Truth(np.stack((x, np.zeros_like(x)), axis=2), np.zeros_like(x), uncertainty, "exact", how)
