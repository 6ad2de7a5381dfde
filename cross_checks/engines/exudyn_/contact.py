"""Exudyn's own contact: spheres and triangles in series, without joints."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from typing import Any

import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.exudyn_.planar_model import Redundant
from cross_checks.joint_tree import FIXED
from mbs_ref.contact import CircleOnCircle, CircleOnLine, SpringDamperLaw
from mbs_ref.scene import GROUND, Scene

REACH = 100.0  # m, how far floors and the search for contact extend


def general_contact_refusals(scene: Scene) -> list[Refusal]:
    reasons = [f"joint {joint.name!r}: Exudyn's explicit solvers take no joint" for joint in scene.joints]
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        if not isinstance(contact.law, SpringDamperLaw) or not isinstance(contact, CircleOnLine | CircleOnCircle):
            reasons.append(f"{where}: GeneralContact takes circles with spring_damper_law, not {contact.law.type}")
            continue
        if contact.friction is not None:
            reasons.append(f"{where}: friction is not yet taught to exudyn here")
        rule = "gap" if isinstance(contact, CircleOnLine) else "force"
        if getattr(contact.law, "release", rule) != rule:
            reasons.append(f"{where}: GeneralContact lets go of {contact.type} by release = {rule!r}")
        if isinstance(contact, CircleOnLine) and (contact.body_b != GROUND or contact.extent != "line"):
            reasons.append(f"{where}: only an endless line on ground is taught")
    reasons += _mixed_refusals(scene)
    return [Refusal(reason, permanent=False) for reason in reasons]


def _mixed_refusals(scene: Scene) -> list[str]:
    """GeneralContact gives stiffness to shapes, not to pairs, and lets every pair touch."""
    laws = {repr(contact.law) for contact in scene.contacts}
    shapes = {shape for contact in scene.contacts for shape in _circles(contact)}
    bodies = [body for body, _, _ in shapes]
    reasons = []
    if len(laws) > 1:
        reasons.append("GeneralContact gives laws to shapes, not to pairs: all contacts must share one")
    if len(bodies) != len(set(bodies)):
        reasons.append("a body with two circles would touch with both")
    return reasons


def _circles(contact: CircleOnLine | CircleOnCircle) -> list[tuple[str, tuple[float, ...], float]]:
    if isinstance(contact, CircleOnLine):
        return [(contact.body_a, contact.center, contact.radius)]
    return [(contact.body_a, contact.center_a, contact.radius_a), (contact.body_b, contact.center_b, contact.radius_b)]


def add_contacts(model: Redundant) -> None:
    """Two shapes in series: each has twice the pair's stiffness and half its damping."""
    contacts = model.scene.contacts
    law: Any = contacts[0].law
    general = model.mbs.AddGeneralContact()
    general.SetFrictionPairings(np.zeros((1, 1)))
    general.verboseMode = 0
    shape = {"contactStiffness": 2.0 * law.stiffness, "contactDamping": 0.5 * law.damping, "frictionMaterialIndex": 0}
    lines = [c for c in contacts if isinstance(c, CircleOnLine)]
    for line in {(c.point_1, c.point_2): c for c in lines}.values():
        _add_plane(model, general, line, shape)
    for body, center, radius in sorted({circle for contact in contacts for circle in _circles(contact)}):
        general.AddSphereWithMarker(markerIndex=model.marker(body, center), radius=radius, **shape)
    general.SetSearchTreeCellSize([1, 1, 1])
    general.SetSearchTreeBox(pMin=[-REACH, -REACH, -REACH], pMax=[REACH, REACH, REACH])


def _add_plane(model: Redundant, general, line: CircleOnLine, shape: dict) -> None:
    """A line as two triangles, wide and deep enough for the scene."""
    along = np.subtract(line.point_2, line.point_1) / np.hypot(*np.subtract(line.point_2, line.point_1))
    ends = [np.array([*(np.array(line.point_1) + s * REACH * along), z]) for s in (-1, 1) for z in (-REACH, REACH)]
    marker = model.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=model.bodies[FIXED], localPosition=[0.0, 0.0, 0.0]))
    general.AddTrianglesRigidBodyBased(
        rigidBodyMarkerIndex=marker, pointList=ends, triangleList=[[0, 1, 3], [0, 3, 2]], **shape
    )
