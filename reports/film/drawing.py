"""What is drawn of a motion: bodies as hulls of what is attached to them, joints on the ground, springs, circles and
surfaces of contact.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from mbs_ref import Trajectory
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import GROUND, Body, CoordinateDrive, Scene
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, Granules, PinOnSprocket, SphereOnPlane, SphereOnSphere
from mbs_ref.scene.traits import touching

ISOMETRIC = np.array([[-1.0, 1.0, 0.0], [-0.5, -0.5, 1.0]]) / np.array([[2.0**0.5], [1.5**0.5]])
ALIKE = 8  # bodies of one mass, of which one is coloured: a link of a track
SPOKES = 6  # of a wheel
ARCS = 8  # places on an orbit for each sample
FOLLOWED = 1.5  # times their own size: bodies that travel farther stay in the middle of the picture
HATCHES = 8  # marks of a ground that passes by, over the length of the bodies
UP = (0.0, 0.0, 1.0)  # in space without gravity


@dataclass(frozen=True)
class Drawing:
    """What is drawn at every sample, in metres on the paper."""

    spokes: list[tuple[int, np.ndarray]]  # body and (n_t, 2, 2) from its centre of mass to an attachment
    fills: list[tuple[int, np.ndarray]]  # body and (n_t, 3, 2): triangles that together are the hull of its attachments
    springs: list[np.ndarray]  # (n_t, 2, 2)
    surfaces: list[np.ndarray]  # (n_t, 2, 2)
    circles: list[tuple[np.ndarray, float]]  # (n_t, 2) and radius; spheres, which look the same from everywhere
    pins: list[np.ndarray]  # (n_t, 2) of joints on the ground
    centres: np.ndarray  # (n_t, n_bodies, 2)
    times: np.ndarray  # (n_t,) s
    labels: Mapping[int, str] = field(default_factory=dict)  # of bodies that only a name distinguishes, heaviest first
    radii: Sequence[np.ndarray] = ()  # (n_t, 2, 2) of wheels
    accent: int = -1  # the body that is coloured among many alike
    orbits: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 2)))  # (n, n_bodies, 2) of bodies with labels


def drawing(scene: Scene, trajectory: Trajectory) -> Drawing:
    """Follow every mark of a scene along its motion."""
    motion, paper = Motion(scene, trajectory), _paper(scene)
    centres = trajectory.position @ paper.T
    apart = is_apart(scene)
    ride, size = _ride(centres)
    if apart or np.ptp(ride, axis=0).max() <= FOLLOWED * size:
        ride = np.zeros_like(ride)

    def seen(places: np.ndarray) -> np.ndarray:
        return places @ paper.T - (ride if places.ndim == 2 else ride[:, None])

    centres = centres - ride[:, None]
    marks: dict[int, dict[tuple[float, ...], np.ndarray]] = {}  # by body and world point
    springs, pins = [], []
    for part in (*scene.joints, *scene.loads):
        ends = _marks(part)
        places = [seen(motion.point(body, mark)[0]) for body, mark in ends]
        for (body, mark), place in zip(ends, places, strict=True):
            if body != GROUND:
                marks.setdefault(scene.body_index(body), {})[tuple(np.round(mark, 9))] = place
            elif part in scene.joints:
                pins.append(place)
        if len(places) == 2 and part in scene.loads:
            springs.append(np.stack(places, axis=1))
    surfaces, circles = _contacts(motion)
    if ride.any():
        surfaces += _hatching(surfaces, size / HATCHES)
    turning = [seen(np.stack(ends, axis=1)) for ends in _turning(motion)]
    heaviest = sorted(range(len(scene.bodies)), key=lambda k: -scene.bodies[k].mass) if apart else ()

    def about(count: int) -> list[tuple[int, np.ndarray]]:
        """Return each body's centre with every so many of its marks."""
        groups = [(k, group) for k, own in marks.items() for group in combinations(own.values(), count)]
        return [(k, np.stack((centres[:, k], *group), axis=1)) for k, group in groups]

    return Drawing(
        about(1), about(2),
        springs, [seen(surface) for surface in surfaces], [(seen(place), r) for place, r in circles if r > 0.0],
        pins, centres, trajectory.times, {k: scene.bodies[k].name for k in heaviest}, turning, _accent(scene),
        arcs(trajectory) @ paper.T,
    )  # fmt: skip


def is_apart(scene: Scene) -> bool:
    """Return whether only names distinguish the bodies, as on orbits: nothing joins them, and none touches another."""
    return not (scene.joints or touching(scene)) and len(scene.bodies) > 1


def arcs(path: Trajectory) -> np.ndarray:
    """Return the way of every body (n, n_bodies, dimension), m: cubics of ARCS places by the velocities of samples."""
    h, s = np.diff(path.times)[:, None, None], np.linspace(0.0, 1.0, ARCS + 1)[:-1, None, None, None]
    begin, way = path.position[:-1], np.diff(path.position, axis=0)
    slope, last = h * path.velocity[:-1], h * path.velocity[1:]
    inner = begin + s * (slope + s * (3.0 * way - 2.0 * slope - last + s * (slope + last - 2.0 * way)))
    return np.concatenate((np.swapaxes(inner, 0, 1).reshape(-1, *begin.shape[1:]), path.position[-1:]))


def _marks(part) -> list[tuple[str, tuple[float, ...]]]:
    """Return the bodies and world points (t = 0) that a joint or load ties together."""
    if isinstance(part, CoordinateDrive):
        return []
    named = [(vars(part).get(end), part.mark(end)) for end in ("body_a", "body_b", "body")]
    return [(body, mark) for body, mark in named if body is not None and mark is not None]


def _accent(scene: Scene) -> int:
    """Return the index of the first of many bodies of equal mass; -1 where there are none."""
    masses = Counter(body.mass for body in scene.bodies)
    return next((k for k, body in enumerate(scene.bodies) if masses[body.mass] >= ALIKE), -1)


def _ride(centres: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the middle of all bodies (n_t, 2) and the size (m) of their figure about it; infinite of a single one."""
    middle = centres.mean(axis=1)
    size = np.ptp(centres - middle[:, None], axis=(0, 1)).max()
    return middle, float(size) if centres.shape[1] > 1 else np.inf


def _hatching(surfaces: list[np.ndarray], pitch: float) -> list[np.ndarray]:
    """Return short lines (n_t, 2, 2) below the surfaces that rest, a pitch (m) apart, by which a ride is seen."""
    marks: dict[tuple[float, ...], np.ndarray] = {}
    for surface in surfaces:
        one, two = surface[0]
        length = float(np.linalg.norm(two - one))
        if length > 0.0 and not np.ptp(surface, axis=0).any():
            along = (two - one) / length
            for place in np.arange(np.ceil(one @ along / pitch) * pitch, two @ along, pitch):
                top = one + (place - one @ along) * along
                line = np.stack((top, top - 0.3 * pitch * (along + np.array((0.0, 1.0)))))
                marks[tuple(np.round(top, 6))] = np.broadcast_to(line, surface.shape)
    return list(marks.values())


def _paper(scene: Scene) -> np.ndarray:
    """Return the matrix from the scene's axes to the paper: space is seen along (1, 1, 1), against gravity upright."""
    if scene.dimension == 2:
        return np.eye(2)
    up = unit(np.negative(scene.gravity)) if any(scene.gravity) else np.array(UP)
    first = np.eye(3)[(np.argmax(np.abs(up)) + 1) % 3]
    first = unit(first - (first @ up) * up)
    return ISOMETRIC @ np.array((first, np.cross(up, first), up))


def _contacts(motion: Motion) -> tuple[list[np.ndarray], list[tuple[np.ndarray, float]]]:
    """Return the surfaces (n_t, 2, 2) of all contacts, and the middles (n_t, 2 or 3) and radii of their circles."""
    surfaces: list[np.ndarray] = []
    planes: dict[tuple, list[SphereOnPlane]] = {}  # those of a body that are one are drawn once
    for contact in motion.scene.contacts:
        if isinstance(contact, CircleOnLine):
            surfaces.append(_line(motion, contact, motion.point(contact.body_a, contact.center)[0]))
        elif isinstance(contact, SphereOnPlane):
            normal = unit(contact.normal)
            key = (contact.body_b, *np.round((*normal, normal @ contact.point), 6) + 0.0)
            planes.setdefault(key, []).append(contact)
    surfaces += [side for group in planes.values() for side in _sides(motion, group)]
    for grains in motion.scene.loads if motion.scene.dimension == 2 else ():
        if isinstance(grains, Granules):
            path, beyond = motion.trajectory.position, max(grains.radius)
            surfaces += [_wall(np.array(wall.point), wall.normal, path, beyond) for wall in grains.walls]
    circles = dict.fromkeys(circle for part in touching(motion.scene) for circle in _circles(part, motion.scene.bodies))
    return surfaces, [(motion.point(body, center)[0], radius) for body, center, radius in circles]


def _line(motion: Motion, contact: CircleOnLine, center: np.ndarray) -> np.ndarray:
    """Return the ends (n_t, 2, 2) of a line; of one without ends, as far as its circle's center (n_t, 2) goes."""
    one, two = (motion.point(contact.body_b, end)[0] for end in (contact.point_1, contact.point_2))
    if contact.extent == "line":
        length = np.linalg.norm(two - one, axis=1, keepdims=True)
        along = (two - one) / length
        way = np.sum((center - one) * along, axis=1)
        low, high = way.min() - 2.0 * contact.radius, way.max() + 2.0 * contact.radius
        one, two = one + min(low, 0.0) * along, one + np.maximum(high, length) * along
    return np.stack((one, two), axis=1)


def _wall(point: np.ndarray, normal: Sequence[float], path: np.ndarray, beyond: float) -> np.ndarray:
    """Return the ends (n_t, 2, 2) of a wall, as far as the bodies' path (n_t, n_bodies, 2) goes, and beyond (m)."""
    along = unit((normal[1], -normal[0]))
    way = (path - point) @ along
    ends = point + np.outer((way.min() - beyond, way.max() + beyond), along)
    return np.broadcast_to(ends, (len(path), 2, 2))


def _turning(motion: Motion) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the ends (n_t, 2) of the spokes of every circle that turns by more than half a turn."""
    scene, turned = motion.scene, motion.trajectory.orientation
    if scene.dimension == 3:
        return []
    wheels = {wheel for part in touching(scene) for wheel in _circles(part, scene.bodies) if wheel[2] > 0.0}
    result = []
    for body, center, radius in sorted(wheels):
        k = scene.body_index(body)
        about_its_middle = k >= 0 and np.allclose(center, scene.bodies[k].position)
        if about_its_middle and np.ptp(turned[:, k]) > np.pi:
            for angle in 2.0 * np.pi * np.arange(SPOKES) / SPOKES:
                rim = (center[0] + radius * np.cos(angle), center[1] + radius * np.sin(angle))
                result.append(tuple(motion.point(body, end)[0] for end in (center, rim)))
    return result


def _circles(contact, bodies: Sequence[Body]) -> list[tuple[str, tuple[float, ...], float]]:
    """Return the circles and spheres of a contact: body, center (t = 0) and radius (m)."""
    if isinstance(contact, CircleOnLine | SphereOnPlane):
        return [(contact.body_a, contact.center, contact.radius)]
    if isinstance(contact, CircleOnCircle | SphereOnSphere):
        first = (contact.body_a, contact.center_a, contact.radius_a)
        return [first, (contact.body_b, contact.center_b, contact.radius_b)]
    if isinstance(contact, Granules):
        radius, half = contact.shapes(len(bodies), len(bodies[0].position))
        reach = (radius + np.linalg.norm(half, axis=1)).tolist()  # of cores that are no points, what is around them
        return [(body.name, body.position, size) for body, size in zip(bodies, reach, strict=True)]
    if isinstance(contact, PinOnSprocket):
        return [(contact.body_b, contact.axle, contact.pitch_radius)]
    return []


def _sides(motion: Motion, contacts: Sequence[SphereOnPlane]) -> list[np.ndarray]:
    """Return the four sides of a rectangle around those of contacts in one plane, or around their spheres' paths."""
    first = contacts[0]
    edge = normals(first.normal)[0] if first.edge is None else unit(first.edge)
    across, start = np.cross(unit(first.normal), edge), np.array(first.point)
    ends = []
    for contact in contacts:
        if contact.size is not None:
            half, seen = 0.5 * np.array(contact.size), np.array([contact.point])
        else:
            half, seen = 2.0 * contact.radius, motion.point(contact.body_a, contact.center)[0]
        along = np.stack(((seen - start) @ edge, (seen - start) @ across), axis=1)
        ends += [along.min(axis=0) - half, along.max(axis=0) + half]
    low, high = np.min(ends, axis=0), np.max(ends, axis=0)
    corners = [(high[0], high[1]), (low[0], high[1]), (low[0], low[1]), (high[0], low[1])]
    places = [motion.point(first.body_b, tuple(start + x * edge + y * across))[0] for x, y in corners]
    return [np.stack((places[k - 1], places[k]), axis=1) for k in range(4)]
