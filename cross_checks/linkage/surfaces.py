"""The shapes of a contact, for engines with shapes of their own: spheres, half-spaces, boxes and cylinders in space."""

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cross_checks.linkage.links import Z, lifted
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.contact import PinOnSprocket, RollingFriction, RoundPair, SphereOnPlane, SpringDamperLaw

CORNER = 1e-9  # m, radius of the sphere that stands for a corner
REACH, THICK = 100.0, 1.0  # m: half length of an endless surface on a body, and depth of a box without a thickness
ENDLESS = (2.0 * REACH, 2.0 * REACH)  # m


def spheres_of(contact) -> list[tuple[str, tuple[float, ...], float]]:
    """Return body, centre (world, t = 0, m) and radius (m) of every sphere of a contact, the one on body a first."""
    if not isinstance(contact, RoundPair):
        return [(contact.body_a, contact.center, max(contact.radius, CORNER))]
    ends = ((contact.body_a, contact.center_a, contact.radius_a), (contact.body_b, contact.center_b, contact.radius_b))
    return [(body, center, max(radius, CORNER)) for body, center, radius in ends]


def frame_of(contact) -> tuple[np.ndarray, np.ndarray, tuple[float, float]]:
    """Return axes (3, 3) of a flat surface as columns, the normal last, its middle (3,) m, and its sides (m)."""
    if isinstance(contact, SphereOnPlane):
        normal, middle, sides = unit(contact.normal), lifted(contact.point), contact.size or ENDLESS
        along = unit(contact.edge) if contact.edge else normals(normal)[0]
    else:
        start, end = lifted(contact.point_1), lifted(contact.point_2)
        along = unit(end - start)
        bounded, normal = contact.extent != "line", np.cross(Z, along)
        middle = 0.5 * (start + end) if bounded else start
        sides = (float(np.linalg.norm(end - start)), 2.0 * REACH) if bounded else ENDLESS
    return np.column_stack((along, np.cross(normal, along), normal)), middle, sides


def is_half_space(contact) -> bool:
    """Whether the flat surface of a contact is endless, without a thickness, and fixed to the world."""
    return contact.body_b == GROUND and frame_of(contact)[2] == ENDLESS and contact.thickness is None


@dataclass(frozen=True)
class Shape:
    """A convex shape of a body, where it is in the world at t = 0."""

    body: str
    kind: Literal["sphere", "half_space", "box", "cylinder"]
    middle: np.ndarray  # (3,) m; of a half-space a point of its surface
    axes: np.ndarray  # (3, 3), as columns: the last one is the outer normal, or the cylinder's axis
    size: tuple[float, ...]  # m: radius, nothing, half sides, or radius and half length

    @property
    def key(self) -> str:
        """The same of shapes that are the same."""
        return repr((self.body, self.kind, self.middle.tolist(), self.axes.tolist(), self.size))


def shapes_of(contact, *, boxes: bool = False) -> list[Shape]:
    """Return both shapes of a contact that is no sprocket's, on body a first; with `boxes` no half-space is one."""
    balls = spheres_of(contact)
    found = [Shape(body, "sphere", lifted(center), np.eye(3), (radius,)) for body, center, radius in balls]
    if isinstance(contact, RoundPair):
        return found
    axes, middle, sides = frame_of(contact)
    if is_half_space(contact) and not boxes:
        return [*found, Shape(contact.body_b, "half_space", middle, axes, ())]
    depth = contact.thickness or THICK
    size = (0.5 * sides[0], 0.5 * sides[1], 0.5 * depth)
    return [*found, Shape(contact.body_b, "box", middle - 0.5 * depth * axes[:, 2], axes, size)]


def gap_walls(contact: PinOnSprocket) -> Iterator[Shape]:
    """Yield the root of a sprocket and both flanks of each gap: each touches the arc that the gap has for its seat."""
    axis = Z if contact.axis is None else unit(contact.axis)
    first = np.array([1.0, 0.0, 0.0]) if contact.seat is None else unit(contact.seat)
    radius, clearance, axle = contact.pitch_radius, contact.clearance, lifted(contact.axle)
    thick, wide = 0.1 * radius, contact.addendum_radius
    body, root = contact.body_b, (radius - clearance, wide)
    yield Shape(body, "cylinder", axle, np.column_stack((*normals(axis), axis)), root)
    sine, cosine = math.sin(contact.flank_angle), math.cos(contact.flank_angle)
    for gap in range(contact.teeth):
        angle = contact.first_seat + 2.0 * math.pi * gap / contact.teeth
        radial = math.cos(angle) * first + math.sin(angle) * np.cross(axis, first)
        for side in (-1.0, 1.0):
            ahead = side * np.cross(axis, radial)
            along, normal = cosine * radial + sine * ahead, sine * radial - cosine * ahead
            start = radius * radial - clearance * normal  # from the axle, where the seat's arc ends
            inward = float(along @ start)
            length = math.sqrt(inward**2 - float(start @ start) + contact.addendum_radius**2) - inward
            middle = axle + start + 0.5 * (length - thick) * along - 0.5 * thick * normal
            axes = np.column_stack((along, np.cross(normal, along), normal))
            yield Shape(body, "box", middle, axes, (0.5 * (length + thick), wide, 0.5 * thick))


def friction_refusals(engine: str, contact) -> list[str]:
    """Return why the friction of a contact is refused by an engine that takes nothing of it but one coefficient."""
    friction, where = contact.friction, f"contact {contact.name!r}: {engine}"
    if isinstance(friction, RollingFriction):
        return [f"{where} is given no resistance to rolling here"]
    one = getattr(friction, "static", None) in (None, getattr(friction, "coefficient", None))
    return [] if one else [f"{where} has one coefficient of friction; leave static out"]


def body_refusals(engine: str, scene: Scene, bodies: Collection[str]) -> Iterator[str]:
    """Yield why a scene is refused by an engine where `bodies` have one material each, and all touch by all shapes."""
    shapes: dict[str, set[str]] = {}
    if any(isinstance(contact, PinOnSprocket) for contact in scene.contacts):
        yield f"the gaps between teeth are not convex, and the shapes of {engine} are"
        return
    for body in bodies:
        own = [contact for contact in scene.contacts if body in contact.ends]
        masses = [0.0 if isinstance(one.law, SpringDamperLaw) else pair_mass(scene, one) for one in own]
        if len({(repr(c.law), repr(c.friction), mass) for c, mass in zip(own, masses, strict=True)}) > 1:
            yield f"body {body!r}: {engine} has one law and one friction for all contacts of a body"
    pairs = set()
    for contact in scene.contacts:
        ends = shapes_of(contact)
        pairs.add(frozenset(end.key for end in ends))
        for end in ends:
            shapes.setdefault(end.body, set()).add(end.key)
    for a, b in dict.fromkeys(contact.ends for contact in scene.contacts):
        if any(frozenset((p, q)) not in pairs for p in shapes[a] for q in shapes[b]):
            yield f"bodies {a!r} and {b!r}: {engine} has contacts of all their shapes, and not all are declared"


def pair_mass(scene: Scene, contact) -> float:
    """Return the effective mass (kg) of a central contact, 1/(1/m_a + 1/m_b); joints are not considered."""
    ends = [scene.body_index(name) for name in (contact.body_a, contact.body_b) if name != GROUND]
    return 1.0 / sum(1.0 / scene.bodies[k].mass for k in ends)
