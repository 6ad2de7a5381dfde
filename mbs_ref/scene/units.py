"""Which scenes are made of free particles, and their natural units."""

from __future__ import annotations

import itertools
import math

from mbs_ref.scene.bodies import PointMass
from mbs_ref.scene.celestial import CelestialPart, Newton
from mbs_ref.scene.scene import Scene


def is_celestial(scene: Scene) -> bool:
    """Return whether the scene is made of free particles in space that celestial fields alone move."""
    return (
        scene.dimension == 3
        and not scene.joints
        and all(isinstance(body, PointMass) for body in scene.bodies)
        and all(isinstance(load, CelestialPart) for load in scene.loads)
    )


def attraction(scene: Scene) -> tuple[float, ...]:
    """Return gm of every body, m^3/s^2; zeros where none attracts."""
    newton = [load for load in scene.loads if isinstance(load, Newton)]
    return newton[0].gm if newton else (0.0,) * len(scene.bodies)


def free_fall_time(scene: Scene) -> float:
    """Return the least sqrt(r^3 / gm) of any attracting pair at the start, s; 1 where nothing attracts."""
    return min((math.sqrt(gap**3 / gm) for gap, gm in _pairs(scene)), default=1.0)


def unit_length(scene: Scene) -> float:
    """Return the length that errors of particles are small or large against, m.

    Among attracting bodies their shortest distance at the start, in whatever unit; 1 m where nothing attracts.
    """
    return min((gap for gap, _ in _pairs(scene)), default=1.0)


def tolerance_unit(scene: Scene) -> float:
    """Return what an absolute tolerance counts in: the lesser of unit length (m) and unit speed (m/s)."""
    return min(unit_length(scene), unit_length(scene) / free_fall_time(scene))


def _pairs(scene: Scene) -> list[tuple[float, float]]:
    """Return distance (m) at the start and sum of gm of every pair that attracts and does not coincide."""
    gm, place = attraction(scene), [body.position for body in scene.bodies]
    pairs = itertools.combinations(range(len(gm)), 2)
    found = ((math.dist(place[j], place[k]), gm[j] + gm[k]) for j, k in pairs)
    return [(gap, both) for gap, both in found if gap > 0.0 and both > 0.0]
