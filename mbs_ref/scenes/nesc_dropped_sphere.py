"""NASA's check case 1 of atmospheric flight: a sphere without drag falls from rest over a turning, oblate Earth."""

from __future__ import annotations

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.celestial import CelestialLoad, Newton, Oblateness

FOOT, SLUG = 0.3048, 14.593902937206364  # m, kg; international foot, slug of a pound-force
GM_EARTH = 3.986004418e14  # m^3/s^2, WGS-84
R_EARTH = 6_378_137.0  # m, WGS-84
J2 = 1.08262982e-3  # WGS-84, of the source
SPIN = 7.292115e-5  # rad/s, WGS-84
ALTITUDE = 30_000.0 * FOOT  # m


def build(*, duration: Positive = 30.0, j2: NonNegative = J2, spin: NonNegative = SPIN) -> Scene:
    """Let a sphere go 30 000 ft above the equator at longitude 0, at rest as seen from the turning ground.

    duration (s), j2 (of the Earth), spin (rad/s, of the Earth). Axes do not turn: z is the Earth's, x points to the
    start. Files of the published simulators are in Earth-fixed axes: their map states the spin.
    """
    field = Oblateness(name="earth_j2", body="earth", radius=R_EARTH, zonal=(j2,))
    words = "A sphere without drag falls from 30 000 ft over the equator of a turning, oblate Earth."
    return dropped("nesc_dropped_sphere", words, "case 1", R_EARTH + ALTITUDE, spin, duration, field)


def dropped(
    name: str, description: str, cases: str, radius: float, spin: float, duration: float, field: CelestialLoad
) -> Scene:
    """Return a sphere that is let go over the equator, `radius` (m) from the Earth's centre, with a field more."""
    return Scene(
        name=name,
        description=description,
        source=f"Jackson, Shelton, Jackson, Castro, Hill, NASA/TM-2015-218675, atmospheric check {cases}",
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            PointMass(name="earth", mass=5.9722e24, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            PointMass(name="sphere", mass=SLUG, position=(radius, 0.0, 0.0), velocity=(0.0, spin * radius, 0.0)),
        ),
        loads=(Newton(name="newton", gm=(GM_EARTH, 0.0), radius=(0.0, 0.0)), field),
    )
