"""The solar system as JPL's DE440 has it: heliocentric, ICRF equatorial axes, TDB."""

from __future__ import annotations

import numpy as np

from cross_checks.truths import NoTruth, Truth
from mbs_ref import ephemeris
from mbs_ref.scene import Scene
from mbs_ref.scenes.solar_system import julian_date

STORED_TO = 1e-3  # m: what DE440's Chebyshev series keep of the integration (Park et al. 2021, sec. 1)


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Read DE440; asteroids are part of the model and are not judged, and the lumped Earth is read as the Earth."""
    jd = julian_date(str(scene.parameters["start"]))
    position = np.full((len(times), len(scene.bodies), 3), np.nan)
    try:
        for k, name in enumerate(scene.body_names):
            if name in ephemeris.BODIES:
                position[:, k] = ephemeris.positions(name, jd, times)
    except ephemeris.EphemerisError as error:
        return NoTruth(str(error))
    how = f"{ephemeris.describe()}, seen from the Sun; DE421 differs by 0.2 km (Earth) to 489 km (Neptune) in 1998"
    return Truth(position, np.zeros(position.shape[:2]), STORED_TO, "ephemeris", how, origin="sun")
