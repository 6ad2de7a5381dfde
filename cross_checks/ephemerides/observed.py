"""Where the bodies of a scene truly were: the ephemeris a model is measured against, whatever integrates it.

A truth (cross_checks.truths) is the exact solution of a scene's equations and judges solvers. An observation
judges the equations: how many figures of reality the physics in the scene allows.
"""

from dataclasses import dataclass

import numpy as np

from cross_checks.truths import is_unchanged
from mbs_ref import ephemeris
from mbs_ref.scene import Scene
from mbs_ref.scenes.solar_system import julian_date

OBSERVED_SCENES = ("solar_system",)


@dataclass(frozen=True)
class Observed:
    """Barycentric places at one time; NaN where a body is part of the model but not observed."""

    position: np.ndarray  # (n_bodies, 3) m
    how: str


@dataclass(frozen=True)
class Unobserved:
    """Why there is nothing to compare with."""

    reason: str


def observe(scene: Scene, t: float) -> Observed | Unobserved | None:
    """Return the places at t (s), or why there are none; None for scenes that never were.

    Asteroids are not judged, and where Earth and Moon are lumped their barycentre is read as the Earth.
    """
    if scene.name not in OBSERVED_SCENES or not is_unchanged(scene):
        return None
    position = np.full((len(scene.bodies), 3), np.nan)
    try:
        for k, name in enumerate(scene.body_names):
            if name in ephemeris.BODIES:
                position[k] = ephemeris.positions(name, julian_date(str(scene.parameters["start"])), np.array([t]))[0]
    except ephemeris.EphemerisError as error:
        return Unobserved(str(error))
    return Observed(position, f"{ephemeris.describe()}, planets seen from the Sun, the Moon from the Earth")
