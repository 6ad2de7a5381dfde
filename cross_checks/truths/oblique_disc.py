"""An oblique impact that slides all along: the normal motion is a free impact, friction takes mu times its impulse."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.certify.mechanisms.unilateral import Line, Unilateral, line_motion
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths.bouncing_ball import impact
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """x - x0 = u0 t - mu (y - y0 - v0 t), and the spin likewise, while the disc slides forwards."""
    disc: Any = scene.bodies[0]
    ground: Any = scene.contacts[0]
    law, friction = ground.law, ground.friction
    u0, v0 = disc.velocity
    e = impact(law, disc.mass, -v0).restitution
    lever = 1.0 + disc.mass * ground.radius**2 / disc.inertia
    if not friction.coefficient * (1.0 + e) * -v0 * lever < u0:
        return NoTruth("the disc stops sliding within the impact: the closed form is of one that slides all along")
    contact = Unilateral((1.0,), ground.radius, law.stiffness, law.damping, by_force=law.release == "force")
    line = Line(np.array([disc.mass]), np.zeros(1), np.array([disc.position[1]]), np.array([v0]), (contact,))
    y, uncertainty = line_motion(line, times)
    y = y[:, 0]
    kick = friction.coefficient * (y - disc.position[1] - v0 * times)  # m, of the friction's impulse over the mass
    x = disc.position[0] + u0 * times - kick
    angle = disc.angle - disc.mass * ground.radius / disc.inertia * kick
    how = "closed form: a free normal impact, and Coulomb's friction that slides all along"
    return Truth(np.stack((x, y), axis=1)[:, None], angle[:, None], uncertainty, "exact", how)
