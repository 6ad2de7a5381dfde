"""An artificial satellite of the Earth: a point mass with each force on its own switch."""

import math
from typing import Any, Literal

import numpy as np

from mbs_ref.scene import PointMass, Scene, celestial
from mbs_ref.scene.base.part import Positive

Orbit = Literal["leo", "gps", "geo", "molniya", "sun_synchronous"]
GM_EARTH = 3.986004415e14  # m^3/s^2, EGM2008 (Pavlis et al., J. Geophys. Res. 117, 2012, B04406), as its J_n below
R_EARTH = 6.3781363e6  # m, EGM2008
ZONAL = (1.08262617385222e-3, -2.53241051856772e-6, -1.61989759991697e-6, -2.27753590730836e-7, 5.40666576283813e-7)
GM_SUN, GM_MOON = 1.32712440041279419e20, 4.902800118e12  # m^3/s^2, DE440
MASS, AREA = 500.0, 5.0  # kg, m^2: a small satellite, a choice
DRAG_COEFFICIENT, LIGHT_COEFFICIENT = 2.2, 1.3  # Montenbruck and Gill 2000, sec. 3.5.1 and 3.4: usual values
AIR = (3.725e-12, 4.0e5, 58_515.0)  # kg/m^3, m, m: density at 400 km and scale height; Vallado 2013, table 8-4
GEO_RADIUS = 4.2164e7  # m
# semi-major axis (m), eccentricity, inclination (deg); nodes and perigees are choices
ORBITS = {
    "leo": (R_EARTH + 4.0e5, 1e-3, 51.6),
    "gps": (2.6560e7, 0.01, 55.0),
    "geo": (GEO_RADIUS, 1e-4, 0.05),
    "molniya": (2.6554e7, 0.72, 63.4),
    "sun_synchronous": (R_EARTH + 7.0e5, 1e-3, 0.0),
}
YEAR_D = 365.2422  # days, tropical


def satellite(
    *, orbit: Orbit = "leo", days: Positive = 1.0, j2: bool = True, zonals: bool = False,
    third_bodies: bool = False, drag: bool = False, radiation: bool = False,
) -> Scene:  # fmt: skip
    """Follow a satellite round the Earth with the forces that are switched on (Fox 2001).

    orbit (leo, gps, geo, molniya, sun_synchronous), days, j2, zonals (J3 to J6 as well), third_bodies (Moon and
    Sun), drag (exponential atmosphere), radiation (sunlight with shadow). The Earth is at rest; z is its axis.
    """
    place, rate = state(orbit)
    return Scene(
        name="satellite",
        description=f"A satellite of {MASS:g} kg on the orbit {orbit}, about an Earth at rest, from J2000.",
        source="EGM2008 for the field; O. Montenbruck, E. Gill, Satellite Orbits, Springer 2000, for the other forces",
        duration=days * celestial.DAY_S,
        bodies=(
            PointMass(name="earth", mass=5.9722e24, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            PointMass(name="satellite", mass=MASS, position=tuple(place), velocity=tuple(rate)),
        ),
        loads=(
            celestial.Epoch(), celestial.Newton(name="newton", gm=(GM_EARTH, 0.0), radius=(R_EARTH, 0.0)),
            *_forces(j2, zonals, third_bodies, drag, radiation),
        ),
    )  # fmt: skip


def elements(orbit: str) -> tuple[float, float, float]:
    """Return semi-major axis (m), eccentricity and inclination (rad); the sun-synchronous one is computed."""
    a, e, degrees = ORBITS[orbit]
    if orbit != "sun_synchronous":
        return a, e, math.radians(degrees)
    wanted = 2.0 * math.pi / (YEAR_D * celestial.DAY_S)  # rad/s, the mean Sun's motion
    return a, e, math.acos(wanted / nodal_rate(a, e, 0.0))


def nodal_rate(a: float, e: float, inclination: float) -> float:
    """Return the mean drift of the node by J2 (rad/s): -3/2 n J2 (R/p)^2 cos i (Vallado 2013, eq 9-38)."""
    n, p = math.sqrt(GM_EARTH / a**3), a * (1.0 - e * e)
    return -1.5 * n * ZONAL[0] * (R_EARTH / p) ** 2 * math.cos(inclination)


def state(orbit: str) -> tuple[list[float], list[float]]:
    """Return position (m) and velocity (m/s) at perigee, node on the x axis, perigee at 270 degrees for Molniya."""
    a, e, i = elements(orbit)
    w = math.radians(270.0 if orbit == "molniya" else 0.0)
    along = np.array([math.cos(w), math.sin(w) * math.cos(i), math.sin(w) * math.sin(i)])
    across = np.array([-math.sin(w), math.cos(w) * math.cos(i), math.cos(w) * math.sin(i)])
    speed = math.sqrt(GM_EARTH / a * (1.0 + e) / (1.0 - e))
    return (a * (1.0 - e) * along).tolist(), (speed * across).tolist()


def _forces(j2: bool, zonals: bool, third_bodies: bool, drag: bool, radiation: bool) -> list[Any]:
    parts: list[Any] = []
    if j2 or zonals:
        parts.append(
            celestial.Oblateness(name="earth_j", body="earth", radius=R_EARTH, zonal=ZONAL if zonals else ZONAL[:1])
        )
    if third_bodies:
        parts.append(celestial.ThirdBody(name="sun", body="satellite", source="sun", gm=GM_SUN))
        parts.append(celestial.ThirdBody(name="moon", body="satellite", source="moon", gm=GM_MOON))
    if drag:
        density, altitude, scale = AIR
        parts.append(
            celestial.Drag(
                name="air", body="satellite", planet="earth", coefficient=DRAG_COEFFICIENT * AREA / MASS,
                density=density, altitude=altitude, scale_height=scale, radius=R_EARTH,
            )
        )  # fmt: skip
    if radiation:
        ratio = LIGHT_COEFFICIENT * AREA / MASS
        parts.append(
            celestial.RadiationPressure(
                name="light", body="satellite", planet="earth", coefficient=ratio, radius=R_EARTH
            )
        )
    return parts
