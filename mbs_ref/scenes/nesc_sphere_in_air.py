"""NASA's check cases 4 and 5 of atmospheric flight: a sphere falls through air over a round Earth, still or turning."""

from __future__ import annotations

from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.celestial import StandardDrag
from mbs_ref.scenes.nesc_dropped_sphere import ALTITUDE, FOOT, SLUG, SPIN, dropped

R_EARTH = 6_371_007.1809  # m, mean radius of the source (20 902 255.199 ft, a foot being 1 / 3.28084 m there)
AREA = 0.1963495 * FOOT**2  # m^2, of the six-inch sphere
DRAG_COEFFICIENT = 0.1


def build(*, duration: Positive = 30.0, spin: NonNegative = SPIN) -> Scene:
    """Let a sphere go 30 000 ft above the equator, at rest as seen from the ground, in the 1976 standard atmosphere.

    duration (s), spin (rad/s, of the Earth and its air): as given check case 5, with 0 check case 4. Axes do not turn:
    z is the Earth's, x points to the start.
    """
    air = StandardDrag(
        name="air", body="sphere", planet="earth", coefficient=DRAG_COEFFICIENT * AREA / SLUG, radius=R_EARTH, spin=spin
    )
    words = "A sphere with drag falls from 30 000 ft over the equator of a round Earth, in standard air."
    return dropped("nesc_sphere_in_air", words, "cases 4 and 5", R_EARTH + ALTITUDE, spin, duration, air)
