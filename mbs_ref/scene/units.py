"""Scenes of free particles: detection, and their natural units."""

import itertools
import math
from typing import NamedTuple

from mbs_ref.scene.bodies import PointMass
from mbs_ref.scene.celestial import CelestialPart, Newton
from mbs_ref.scene.scene import Scene

LEAST = 1e-100  # m, m/s, m^3/s^2: of smaller numbers, and of those above its inverse, double precision holds no cubes


def is_celestial(scene: Scene) -> bool:
    """Return whether the scene is made of free particles in space that celestial fields alone move."""
    return (
        scene.dimension == 3
        and not (scene.joints or scene.contacts or scene.events)
        and all(isinstance(body, PointMass) for body in scene.bodies)
        and all(isinstance(load, CelestialPart) for load in scene.loads)
    )


def attraction(scene: Scene) -> tuple[float, ...]:
    """Return gm of every body, m^3/s^2; zeros where none attracts."""
    newton = [load for load in scene.loads if isinstance(load, Newton)]
    return newton[0].gm if newton else (0.0,) * len(scene.bodies)


def free_fall_time(scene: Scene, least: float = 0.0) -> float:
    """Return the least sqrt(r^3 / gm) of any attracting pair at the start, s; 1 where nothing attracts.

    Distances r below `least` (m) count as that.
    """
    return min((math.sqrt(max(pair.gap, least) ** 3 / pair.gm) for pair in _pairs(scene)), default=1.0)


def unit_length(scene: Scene) -> float:
    """Return the length that errors of particles are small or large against, m.

    Among attracting bodies the size of the tightest orbit of two, whatever the unit; 1 m where nothing attracts.
    """
    return min((pair.size(scene.duration) for pair in _pairs(scene)), default=1.0)


def tolerance_unit(scene: Scene) -> float:
    """Return what an absolute tolerance counts in: the lesser of unit length (m) and unit speed (m/s)."""
    return min(unit_length(scene), unit_length(scene) / free_fall_time(scene))


class _Pair(NamedTuple):
    """Two bodies that attract one another, at the start."""

    gap: float  # m
    speed: float  # m/s, of one about the other
    gm: float  # m^3/s^2, the sum of theirs

    def size(self, duration: float) -> float:
        """Return the semi-major axis (m) of a closed orbit, 1/a = 2/r - v^2/gm, the same at every point of it.

        It is no more than what a fall passes through in that time (s), from where it is; of two that pass one another,
        their distance.
        """
        binding = 2.0 / self.gap - self.speed**2 / self.gm
        if binding <= 0.0:
            return self.gap
        fall = (4.5 * self.gm * duration**2) ** (1.0 / 3.0)  # r of a parabolic fall out of the centre
        return min(1.0 / binding, max(self.gap, fall))


def _pairs(scene: Scene) -> list[_Pair]:
    """Return every pair that attracts and does not coincide; ValueError names one whose numbers have no cubes."""
    gm, found = attraction(scene), list[_Pair]()
    for (a, gm_a), (b, gm_b) in itertools.combinations(zip(scene.bodies, gm, strict=False), 2):
        pair = _Pair(math.dist(a.position, b.position), math.dist(a.velocity, b.velocity), gm_a + gm_b)
        if pair.gap > 0.0 and pair.gm > 0.0:
            if not (LEAST <= pair.gap <= 1.0 / LEAST and LEAST <= pair.gm <= 1.0 / LEAST >= pair.speed):
                figures = ", ".join(f"{name} = {value:g}" for name, value in pair._asdict().items())
                raise ValueError(f"{a.name!r} and {b.name!r}: {figures}; allowed: {LEAST:g} to {1.0 / LEAST:g} (SI)")
            found.append(pair)
    return found
