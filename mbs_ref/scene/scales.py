"""The length and the time that a scene's errors and tolerances are counted in; those of free particles."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from mbs_ref.scene.base.part import Role, fields_of
from mbs_ref.scene.bodies import PointMass
from mbs_ref.scene.celestial import CelestialPart, Newton
from mbs_ref.scene.contact import Granules
from mbs_ref.scene.scene import Scene, of_last_scene

LEAST = 1e-100  # m, m/s, m^3/s^2: of smaller numbers, and of those above its inverse, double precision holds no cubes


@dataclass(frozen=True)
class Scales:
    """What is neither large nor small in a scene."""

    length: float  # m
    time: float  # s

    @property
    def speed(self) -> float:
        """Length over time, m/s."""
        return self.length / self.time


@of_last_scene
def scales_of(scene: Scene) -> Scales:
    """Return a scene's length and time scale.

    Among attracting bodies: the size of the tightest orbit (`unit_length`), and the least free-fall time. Elsewhere the
    length is the extent of all bodies, joints and attachments at the start (a single body has its radius of gyration,
    or its height above what it may touch; a mere point has its distance from the values that are watched, or its path),
    and the time is what the fastest of gravity, the initial motion and the duration make of it:
    1/T^2 = g/L + (v/L)^2 + w^2 + 1/duration^2.
    """
    if any(attraction(scene)):
        return Scales(unit_length(scene), free_fall_time(scene))
    length = _extent(scene)
    speed = max(math.hypot(*body.velocity) for body in scene.bodies)
    spin = max(_spin(body) for body in scene.bodies)
    gravity = math.hypot(*scene.gravity)
    rate = math.hypot(math.sqrt(gravity / length), speed / length, spin, 1.0 / scene.duration)
    return Scales(length, 1.0 / rate)


def _extent(scene: Scene) -> float:
    """Return the diagonal of the box around every marked point, the largest body's size or a point's path; else 1 m."""
    points = [tuple(point) for point in _points(scene)]
    sides = [max(axis) - min(axis) for axis in zip(*points, strict=True)]
    sizes = [body.gyration_radius for body in scene.bodies]
    return max(math.hypot(*sides), *sizes, *_reaches(scene)) or max(_watched(scene), default=0.0) or _path(scene) or 1.0


def _watched(scene: Scene) -> Iterator[float]:
    """Yield how far (m) bodies are from the values of coordinates that are watched."""
    for event in scene.events:
        if event.type == "coordinate_event" and not event.rate and event.coordinate != "angle":
            yield abs(event.value - scene.bodies[scene.body_index(event.body)].position["xyz".index(event.coordinate)])


def _path(scene: Scene) -> float:
    """Return how far (m) bodies move at their first velocities and in free fall."""
    speed = max(math.hypot(*body.velocity) for body in scene.bodies)
    return speed * scene.duration + 0.5 * math.hypot(*scene.gravity) * scene.duration**2


def _points(scene: Scene) -> Iterator[tuple[float, ...]]:
    dimension = scene.dimension
    for body in scene.bodies:
        yield body.position
    for part in itertools.chain(scene.joints, scene.loads, scene.contacts):
        for field in fields_of(type(part), Role.POINT):
            point = getattr(part, field)
            if point is not None and len(point) == dimension:
                yield point
        yield from (wall.point for wall in vars(part).get("walls", ()))


def _reaches(scene: Scene) -> Iterator[float]:
    """Yield the radii of what touches."""
    for contact in scene.contacts:
        yield from (getattr(contact, name) for name in ("radius", "radius_a") if getattr(contact, name, None))
    grains = [load for load in scene.loads if isinstance(load, Granules)]
    yield from (max(load.radius) + max((math.hypot(*half) for half in load.half), default=0.0) for load in grains)


def _spin(body: Any) -> float:
    rate = vars(body).get("angular_velocity", 0.0)
    return math.hypot(*rate) if isinstance(rate, tuple) else abs(rate)


def is_celestial(scene: Scene) -> bool:
    """Return whether the scene consists of free particles in space that celestial fields alone move."""
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
            if min(pair.gap, pair.gm) < LEAST or max(pair) > 1.0 / LEAST:  # states of a failed run may hold NaN
                figures = ", ".join(f"{name} = {value:g}" for name, value in pair._asdict().items())
                raise ValueError(f"{a.name!r} and {b.name!r}: {figures}; allowed: {LEAST:g} to {1.0 / LEAST:g} (SI)")
            found.append(pair)
    return found
