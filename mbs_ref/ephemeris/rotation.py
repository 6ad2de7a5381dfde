"""Radii, poles and rates of rotation of the Sun, the planets, the Moon and Pluto, as rigid bodies need them.

Source: Archinal et al., Celest. Mech. Dyn. Astr. 109 (2011) 101, tables 1, 2, 4 and 5, at J2000.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mbs_ref.scene.celestial import DAY_S


class Rotation(NamedTuple):
    """A body's mean radius (km), the ICRF direction of its pole (deg) and its rate (deg/day)."""

    radius_km: float
    ascension_deg: float
    declination_deg: float
    rate_deg_day: float

    @property
    def angular_velocity(self) -> tuple[float, float, float]:
        """The rate along the pole, rad/s, ICRF axes."""
        rate = math.radians(self.rate_deg_day) / DAY_S
        a, d = math.radians(self.ascension_deg), math.radians(self.declination_deg)
        return rate * math.cos(d) * math.cos(a), rate * math.cos(d) * math.sin(a), rate * math.sin(d)


ROTATIONS = {
    "sun": Rotation(696_000.0, 286.13, 63.87, 14.1844),
    "mercury": Rotation(2439.7, 281.0097, 61.4143, 6.1385025),
    "venus": Rotation(6051.8, 272.76, 67.16, -1.4813688),
    "earth": Rotation(6371.0084, 0.0, 90.0, 360.9856235),
    "moon": Rotation(1737.4, 269.9949, 66.5392, 13.17635815),
    "mars": Rotation(3389.5, 317.68143, 52.8865, 350.89198226),
    "jupiter": Rotation(69_911.0, 268.056595, 64.495303, 870.536),
    "saturn": Rotation(58_232.0, 40.589, 83.537, 810.7939024),
    "uranus": Rotation(25_362.0, 257.311, -15.175, -501.1600928),
    "neptune": Rotation(24_622.0, 299.36, 43.46, 536.3128492),
    "pluto": Rotation(1195.0, 132.993, -6.163, 56.3625225),
}
