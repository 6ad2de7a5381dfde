"""What is drawn of a motion: bodies as spokes from the centre of mass to whatever is attached to them, circles and
surfaces of contact as they are. Space is seen along (1, 1, 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import GROUND, CoordinateDrive, Scene
from mbs_ref.scene.base.directions import normals, unit
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, SphereOnPlane, SphereOnSphere
from mbs_ref.trajectory import Trajectory

MOST_LABELS = 20  # more would hide each other
ISOMETRIC = np.array([[-1.0, 1.0, 0.0], [-0.5, -0.5, 1.0]]) / np.array([[2.0**0.5], [1.5**0.5]])


@dataclass(frozen=True)
class Drawing:
    """What is drawn at every sample, in metres on the paper."""

    spokes: list[np.ndarray]  # (n_t, 2, 2) from a centre of mass to an attachment
    springs: list[np.ndarray]  # (n_t, 2, 2)
    surfaces: list[np.ndarray]  # (n_t, 2, 2)
    circles: list[tuple[np.ndarray, float]]  # (n_t, 2) and radius; spheres, which look the same from everywhere
    centres: np.ndarray  # (n_t, n_bodies, 2)
    times: np.ndarray  # (n_t,) s
    labels: tuple[str, ...] = ()  # of the bodies, where they are told apart by name alone
    radii: Sequence[np.ndarray] = ()  # (n_t, 2, 2) of wheels


def drawing(scene: Scene, trajectory: Trajectory) -> Drawing:
    """Follow every mark of a scene along its motion."""
    motion = Motion(scene, trajectory)
    centres = _on_paper(trajectory.position)
    spokes, springs = [], []
    for part in (*scene.joints, *scene.loads):
        ends = _marks(part)
        places = [_on_paper(motion.point(body, mark)[0]) for body, mark in ends]
        for (body, _), place in zip(ends, places, strict=True):
            if body != GROUND:
                spokes.append(np.stack((centres[:, scene.body_index(body)], place), axis=1))
        if len(places) == 2 and part in scene.loads:
            springs.append(np.stack(places, axis=1))
    surfaces, circles = _contacts(motion)
    surfaces = [_on_paper(surface) for surface in surfaces]
    radii = _turning(motion)
    circles = [(_on_paper(place), radius) for place, radius in circles]
    apart = not (scene.joints or scene.contacts) and len(scene.bodies) > 1
    labels = tuple(scene.body_names) if apart and len(scene.bodies) <= MOST_LABELS else ()
    return Drawing(spokes, springs, surfaces, circles, centres, trajectory.times, labels, radii)


def _marks(part) -> list[tuple[str, tuple[float, ...]]]:
    """Return the bodies and world points (t = 0) that a joint or load ties together."""
    if isinstance(part, CoordinateDrive):
        return []
    shared = getattr(part, "point", None)
    result = []
    for body, mark in (("body_a", "point_a"), ("body_b", "point_b"), ("body", "point")):
        name, place = getattr(part, body, None), getattr(part, mark, None) or shared
        if name is not None and place is not None:
            result.append((name, place))
    return result


def _contacts(motion: Motion) -> tuple[list[np.ndarray], list[tuple[np.ndarray, float]]]:
    surfaces, circles = [], []
    for contact in motion.scene.contacts:
        if isinstance(contact, CircleOnLine):
            circles.append((motion.point(contact.body_a, contact.center)[0], contact.radius))
            surfaces.append(_line(motion, contact, circles[-1][0]))
        elif isinstance(contact, SphereOnPlane):
            circles.append((motion.point(contact.body_a, contact.center)[0], contact.radius))
            surfaces += _sides(motion, contact)
        elif isinstance(contact, CircleOnCircle | SphereOnSphere):
            circles.append((motion.point(contact.body_a, contact.center_a)[0], contact.radius_a))
            circles.append((motion.point(contact.body_b, contact.center_b)[0], contact.radius_b))
    return surfaces, circles


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


def _turning(motion: Motion) -> list[np.ndarray]:
    """Return a radius (n_t, 2, 2) of every circle that turns by more than half a turn: a wheel is seen to roll."""
    scene, turned = motion.scene, motion.trajectory.orientation
    if scene.dimension == 3:
        return []
    result: dict[tuple, np.ndarray] = {}
    for contact in scene.contacts:
        for body, center, radius in _rounds(contact):
            k = scene.body_index(body) if body != GROUND else -1
            if k >= 0 and np.ptp(turned[:, k]) > np.pi:
                rim = (center[0] + radius, center[1])
                ends = [motion.point(body, end)[0] for end in (center, rim)]
                result[body, center, radius] = np.stack(ends, axis=1)
    return list(result.values())


def _rounds(contact) -> list[tuple[str, tuple[float, ...], float]]:
    """Return the circles of a contact: body, center (t = 0) and radius (m)."""
    if isinstance(contact, CircleOnLine):
        return [(contact.body_a, contact.center, contact.radius)]
    if isinstance(contact, CircleOnCircle):
        first = (contact.body_a, contact.center_a, contact.radius_a)
        return [first, (contact.body_b, contact.center_b, contact.radius_b)]
    return []


def _sides(motion: Motion, contact: SphereOnPlane) -> list[np.ndarray]:
    """Return the four sides of a rectangle; of a plane, of the part under the sphere's path."""
    edge = normals(contact.normal)[0] if contact.edge is None else unit(contact.edge)
    across = np.cross(unit(contact.normal), edge)
    middle, half = np.array(contact.point), np.ones(2)
    if contact.size is not None:
        half = 0.5 * np.array(contact.size)
    else:
        path = motion.point(contact.body_a, contact.center)[0] - middle
        along = np.stack((path @ edge, path @ across), axis=1)
        low, high = along.min(axis=0) - 2.0 * contact.radius, along.max(axis=0) + 2.0 * contact.radius
        middle, half = middle + np.array((edge, across)).T @ (0.5 * (low + high)), 0.5 * (high - low)
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    corners = [tuple(middle + p * half[0] * edge + q * half[1] * across) for p, q in signs]
    places = [motion.point(contact.body_b, corner)[0] for corner in corners]
    return [np.stack((places[k - 1], places[k]), axis=1) for k in range(4)]


def _on_paper(place: np.ndarray) -> np.ndarray:
    """Return (..., 2) of (..., 2) or, seen from (1, 1, 1), of (..., 3)."""
    return place if place.shape[-1] == 2 else place @ ISOMETRIC.T
