"""Exudyn's two contacts, without joints: spheres and triangles in series, and connectors with a law for each pair.

In series friction acts on the undeformed surface that a sphere has sunk into: nearer to its centre than ours by the
depth. Connectors have F = k d + c d' until d = 0; whether a pair touches is settled once a step: order 1.
"""

from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.model import Redundant
from cross_checks.linkage.links import FIXED
from cross_checks.linkage.surfaces import frame_of, friction_refusals, is_half_space, spheres_of
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import normals
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, SphereOnPlane, SphereOnSphere, SpringDamperLaw

REACH = 100.0  # m, how far floors and the search for contact extend
SLOW = 1e-3  # m/s, its default, pinned: below it Exudyn's friction falls linearly where Coulomb's law would stick
type Flat = CircleOnLine | SphereOnPlane
FLAT, ROUND = (CircleOnLine, SphereOnPlane), (CircleOnCircle, SphereOnSphere)


def general_contact_refusals(scene: Scene) -> list[str]:
    """Return why GeneralContact cannot stand for the contacts: it has one law, and lets every two shapes touch."""
    reasons = []
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        if not isinstance(contact.law, SpringDamperLaw) or not isinstance(contact, (*FLAT, *ROUND)):
            reasons.append(f"{where}: GeneralContact takes circles with spring_damper_law, not {contact.law.type}")
            continue
        reasons += friction_refusals("Exudyn", contact)
        rule = "gap" if isinstance(contact, FLAT) else "force"
        if contact.law.damping and getattr(contact.law, "release", rule) != rule:
            reasons.append(f"{where}: GeneralContact ends a contact of {contact.type} by release = {rule!r} alone")
        if isinstance(contact, FLAT) and not is_half_space(contact):
            reasons.append(f"{where}: only an endless line or plane on ground is supported")
    laws = {repr((contact.law, contact.friction)) for contact in scene.contacts}
    simple = [contact for contact in scene.contacts if isinstance(contact, (*FLAT, *ROUND))]
    shapes = {shape for contact in simple for shape in spheres_of(contact)}
    bodies = [body for body, _, _ in shapes]
    floors = {surface_of(contact) for contact in simple if isinstance(contact, FLAT)}
    every_pair_is_listed = len(shapes) * len(floors) == len(simple)  # none of two round shapes
    if len(laws) > 1:
        reasons.append("GeneralContact gives laws to shapes, not to pairs: all contacts must share one")
    if len(bodies) != len(set(bodies)) and not every_pair_is_listed:
        reasons.append("a body has two circles, and GeneralContact would let both touch every surface")
    return reasons


def add_contacts(model: Redundant) -> None:
    """Add a general contact; the model keeps the calls, for Exudyn does not report them."""
    general, model.general = model.mbs.AddGeneralContact(), general_contact(model)
    for name, values, named in model.general:
        if name[0].isupper():
            getattr(general, name)(*values, **named)
        else:
            setattr(general, name, *values)


def general_contact(model: Redundant) -> list[tuple[str, tuple, dict[str, Any]]]:
    """Return the calls of a general contact, each with its arguments, and its attributes, each with its value.

    Two shapes are in series: each has twice the pair's stiffness and half its damping.
    """
    contacts = model.scene.contacts
    law, friction = contacts[0].law, contacts[0].friction
    assert isinstance(law, SpringDamperLaw)  # every other law is refused before
    shape = {"contactStiffness": 2.0 * law.stiffness, "contactDamping": 0.5 * law.damping, "frictionMaterialIndex": 0}
    pairings = np.array([[0.0 if friction is None else friction.coefficient]])
    planes = [_plane(model, *surface) for surface in {surface_of(c): None for c in contacts if isinstance(c, FLAT)}]
    spheres = [
        {"markerIndex": _marker(model, body, center), "radius": radius}
        for body, center, radius in sorted({sphere for contact in contacts for sphere in spheres_of(contact)})
    ]
    return [
        ("SetFrictionPairings", (pairings,), {}),
        ("frictionProportionalZone", (getattr(friction, "speed", SLOW),), {}),
        ("verboseMode", (0,), {}),
        *(("AddTrianglesRigidBodyBased", (), plane | shape) for plane in planes),
        *(("AddSphereWithMarker", (), sphere | shape) for sphere in spheres),
        ("SetSearchTreeCellSize", ([1, 1, 1],), {}),
        ("SetSearchTreeBox", (), {"pMin": [-REACH] * 3, "pMax": [REACH] * 3}),
    ]


def _marker(model: Redundant, body: str, center) -> int:
    """Return a marker that takes a torque, which friction needs, where its body turns."""
    turns = isinstance(model.scene.bodies[model.scene.body_index(body)], PlanarBody)
    return model.marker(body, center, rigid=turns if model.scene.planar else None)


def surface_of(contact: Flat) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return a point and the unit normal, in space."""
    axes, point, _ = frame_of(contact)
    return tuple(point.tolist()), tuple(axes[:, 2].tolist())


def _plane(model: Redundant, point: tuple[float, ...], normal: tuple[float, ...]) -> dict[str, Any]:
    """Return two triangles, wide enough for the scene."""
    first, second = normals(np.array(normal))
    corners = [np.array(point) + REACH * (p * first + q * second) for p, q in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    marker = model.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=model.bodies[FIXED], localPosition=[0.0, 0.0, 0.0]))
    return {"rigidBodyMarkerIndex": marker, "pointList": corners, "triangleList": [[0, 1, 2], [0, 2, 3]]}


def pair_contact_refusals(scene: Scene) -> list[str]:
    """Return why connectors cannot stand for the contacts."""
    reasons = []
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        reasons += friction_refusals("Exudyn", contact)
        if not isinstance(contact.law, SpringDamperLaw):
            reasons.append(f"{where}: the connectors take spring_damper_law, not {contact.law.type}")
        elif contact.law.damping and contact.law.release != "gap":
            reasons.append(f"{where}: the connectors release at gap = 0; give release = 'gap'")
        if isinstance(contact, SphereOnPlane) and (contact.extent != "plane" or contact.thickness is not None):
            reasons.append(f"{where}: only an endless plane is supported")
    return reasons


def add_pair_contacts(model: Redundant) -> None:
    for contact in model.scene.contacts:
        law, friction = contact.law, contact.friction
        assert isinstance(law, SpringDamperLaw)  # every other law is refused before
        # gap, slip, impact velocity, plastic overlap: far away at t = 0
        data = model.mbs.AddNode(item.NodeGenericData(initialCoordinates=[1.0, 0, 0, 0], numberOfDataCoordinates=4))
        shared = {
            "nodeNumber": data, "impactModel": 0, "contactStiffness": law.stiffness, "contactDamping": law.damping,
            "dynamicFriction": 0.0 if friction is None else friction.coefficient,
            "frictionProportionalZone": getattr(friction, "speed", SLOW),
        }  # fmt: skip
        if isinstance(contact, SphereOnSphere):
            radii = [contact.radius_a, contact.radius_b]
            marks = model.pair(contact, contact.center_a, contact.center_b)
            model.mbs.AddObject(item.ObjectContactSphereSphere(markerNumbers=marks, spheresRadii=radii, **shared))
        elif isinstance(contact, SphereOnPlane):
            _add_triangle(model, contact, shared)


def _add_triangle(model: Redundant, contact: SphereOnPlane, shared: dict) -> None:
    """One triangle, wide enough for the scene, in the axes of the body that carries it."""
    first, second = (model.axes(contact.body_b).T @ along for along in normals(contact.normal))
    corners = [np.zeros(3) + REACH * (np.cos(a) * first + np.sin(a) * second) for a in (0.0, 2.1, 4.2)]
    marks = model.pair(contact, contact.center, contact.point)
    shape = {"sphereRadius": contact.radius, "trianglePoints": exu.Vector3DList(corners)}
    model.mbs.AddObject(item.ObjectContactSphereTriangle(markerNumbers=marks, **shape, **shared))
