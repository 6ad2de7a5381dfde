"""The shapes of a contact, for engines with shapes of their own: spheres, half-spaces and boxes in space."""

import numpy as np

from cross_checks.linkage.links import Z, lifted
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.contact import RollingFriction, RoundPair, SphereOnPlane

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


def friction_refusals(engine: str, contact) -> list[str]:
    """Return why the friction of a contact is refused by an engine that takes nothing of it but one coefficient."""
    friction, where = contact.friction, f"contact {contact.name!r}: {engine}"
    if isinstance(friction, RollingFriction):
        return [f"{where} is given no resistance to rolling here"]
    one = getattr(friction, "static", None) in (None, getattr(friction, "coefficient", None))
    return [] if one else [f"{where} has one coefficient of friction; leave static out"]


def pair_mass(scene: Scene, contact) -> float:
    """Return the effective mass (kg) of a central contact, 1/(1/m_a + 1/m_b); joints are not considered."""
    ends = [scene.body_index(name) for name in (contact.body_a, contact.body_b) if name != GROUND]
    return 1.0 / sum(1.0 / scene.bodies[k].mass for k in ends)
