"""Planar contact: spheres and planes, paired explicitly."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math

import mujoco
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.planar_places import anchor
from cross_checks.joint_tree import JointTree
from mbs_ref.contact import CircleOnCircle, CircleOnLine
from mbs_ref.scene import GROUND, Scene
from mbs_ref.traits import joint_ends

STOCK_SOLREF, STOCK_SOLIMP = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's defaults, pinned
# solimp with the least impedance MuJoCo allows: F = m_eff (K d + B d' + impedance * a), a the acceleration without it
PENALTY_SOLIMP = (1e-4, 1e-4, 0.001, 0.5, 2.0)


def add_contact(spec, frames, tree: JointTree, contact, stock: bool) -> None:
    """A sphere against a plane or another sphere, paired explicitly so that nothing else touches."""
    if isinstance(contact, CircleOnCircle):
        a = (contact.body_a, contact.center_a, contact.radius_a)
        b = (contact.body_b, contact.center_b, contact.radius_b)
        geoms = [_sphere(frames, tree, f"{contact.name}/{side}", *end) for side, end in (("a", a), ("b", b))]
    else:
        sphere = _sphere(frames, tree, f"{contact.name}/a", contact.body_a, contact.center, contact.radius)
        geoms = [_plane(spec, f"{contact.name}/b", contact), sphere]
    pair = spec.add_pair(name=contact.name, geomname1=geoms[0], geomname2=geoms[1], condim=1)
    pair.margin, pair.gap = 0.0, 0.0
    mass = _contact_mass(tree.scene, contact)
    law = contact.law
    pair.solref = STOCK_SOLREF if stock else (-law.stiffness / mass, -law.damping / mass)
    pair.solimp = STOCK_SOLIMP if stock else PENALTY_SOLIMP


def _sphere(frames, tree: JointTree, label: str, body: str, center, radius: float) -> str:
    k = tree.scene.body_index(body)
    size = (radius, 0.0, 0.0)
    frame = frames[k]
    frame.add_geom(name=label, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, pos=anchor(tree, body, center), mass=0.0,
                   contype=0, conaffinity=0)  # fmt: skip
    return label


def _plane(spec, label: str, contact: CircleOnLine) -> str:
    along = np.subtract(contact.point_2, contact.point_1) / np.hypot(*np.subtract(contact.point_2, contact.point_1))
    spec.worldbody.add_geom(
        name=label, type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0), pos=(*contact.point_1, 0.0),
        zaxis=(-along[1], along[0], 0.0), contype=0, conaffinity=0,
    )  # fmt: skip
    return label


def _contact_mass(scene: Scene, contact) -> float:
    """Return the effective mass of a central contact of free bodies, which no pose changes."""
    names = [contact.body_a, contact.body_b]
    return 1.0 / sum(1.0 / scene.bodies[scene.body_index(name)].mass for name in names if name != GROUND)


def contact_refusals(scene: Scene) -> list[Refusal]:
    reasons = []
    jointed = {end for joint in scene.joints for end in joint_ends(joint)}
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        if contact.friction is not None:
            reasons.append(f"{where}: friction is not yet taught to mujoco here")
        if getattr(contact.law, "release", "force") != "force":
            reasons.append(f"{where}: mujoco's contact force is never negative; it needs release = 'force'")
        if isinstance(contact, CircleOnLine) and (contact.body_b != GROUND or contact.extent != "line"):
            reasons.append(f"{where}: a mujoco plane is endless and fixed to the world")
        centers = ((contact.body_a, getattr(contact, "center_a", None) or getattr(contact, "center", None)),
                   (contact.body_b, getattr(contact, "center_b", None)))  # fmt: skip
        for name, center in centers:
            if name == GROUND or center is None:
                continue
            if name in jointed or math.dist(center, scene.bodies[scene.body_index(name)].position) > 1e-12:
                reasons.append(f"{where}: its effective mass, which scales the stiffness, changes as {name!r} moves")
    return [Refusal(reason, permanent=False) for reason in reasons]
