"""Exudyn's contact connectors: a sphere against a sphere or a triangle, a law for each pair.

F = k d + c d' until d = 0; whether a pair touches is settled once a step, so the method is of order 1.
"""

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.exudyn_.contact import REACH, SLOW, one_coefficient
from cross_checks.engines.exudyn_.model import Redundant
from mbs_ref.scene import Scene
from mbs_ref.scene.base.directions import normals
from mbs_ref.scene.contact import SphereOnPlane, SphereOnSphere, SpringDamperLaw


def pair_contact_refusals(scene: Scene) -> list[Refusal]:
    reasons = [f"joint {joint.name!r}: Exudyn's explicit solvers take no joint" for joint in scene.joints]
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        reasons += one_coefficient(contact)
        if not isinstance(contact.law, SpringDamperLaw):
            reasons.append(f"{where}: the connectors take spring_damper_law, not {contact.law.type}")
        elif contact.law.damping and contact.law.release != "gap":
            reasons.append(f"{where}: the connectors let go by release = 'gap'")
        if isinstance(contact, SphereOnPlane) and (contact.extent != "plane" or contact.thickness is not None):
            reasons.append(f"{where}: only an endless plane is taught")
    return [Refusal(reason, permanent=False) for reason in reasons]


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
            _add_plane(model, contact, shared)


def _add_plane(model: Redundant, contact: SphereOnPlane, shared: dict) -> None:
    """One triangle, wide enough for the scene, in the axes of the body that carries it."""
    first, second = (model.axes(contact.body_b).T @ along for along in normals(contact.normal))
    corners = [np.zeros(3) + REACH * (np.cos(a) * first + np.sin(a) * second) for a in (0.0, 2.1, 4.2)]
    marks = model.pair(contact, contact.center, contact.point)
    model.mbs.AddObject(
        item.ObjectContactSphereTriangle(
            markerNumbers=marks, sphereRadius=contact.radius, trianglePoints=exu.Vector3DList(corners), **shared
        )
    )
