"""Contacts as pairs of MuJoCo's geoms.

Friction is MuJoCo's own: an elliptic cone whose projection raises the normal force of a contact that slides, so
that a thrown sphere hops. It acts between the surfaces, half the penetration nearer to the centre than ours.
"""

import math
from typing import Any

import mujoco
import numpy as np

from cross_checks.linkage import surfaces
from cross_checks.linkage.links import Linkage, lifted
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene import contact as laws
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.contact import PinOnSprocket
from mbs_ref.scene.euler_parameters import from_matrix

SHAPES = {  # and the size of one without
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE, "half_space": mujoco.mjtGeom.mjGEOM_PLANE,
    "box": mujoco.mjtGeom.mjGEOM_BOX, "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
}  # fmt: skip
ENDLESS = (0.0, 0.0, 1.0)  # the size of a plane: only drawn


def add_pairs(spec, frames, linkage: Linkage, contact) -> list:
    """Add the geoms of a contact and return their pairs, apart from which none touches anything."""
    if isinstance(contact, PinOnSprocket):
        return _in_gaps(spec, frames, linkage, contact)
    for end, shape in zip("ab", surfaces.shapes_of(contact), strict=True):
        _add_geom(frames, linkage, f"{contact.name}/{end}", shape)
    return [_pair(spec, contact, contact.name, f"{contact.name}/b")]


def _pair(spec, contact, name: str, other: str):
    pair = spec.add_pair(name=name, geomname1=other, geomname2=f"{contact.name}/a")
    pair.margin, pair.gap, pair.condim = 0.0, 0.0, 1
    if contact.friction is not None:
        pair.condim, pair.friction = 3, (contact.friction.coefficient, contact.friction.coefficient, 0.0, 0.0, 0.0)
    return pair


def _in_gaps(spec, frames, linkage: Linkage, contact: PinOnSprocket) -> list:
    """Add a pin, and for the first one the walls of the sprocket's gaps: convex, where the gaps are not."""
    pin = surfaces.Shape(contact.body_a, "sphere", lifted(contact.center), np.eye(3), (surfaces.CORNER,))
    _add_geom(frames, linkage, f"{contact.name}/a", pin)
    walls = []
    for k, wall in enumerate(surfaces.gap_walls(contact)):
        walls.append(f"{contact.body_b}/wall{k}")
        if spec.geom(walls[-1]) is None:
            _add_geom(frames, linkage, walls[-1], wall)
    return [_pair(spec, contact, f"{contact.name}/{k}", wall) for k, wall in enumerate(walls)]


def _add_geom(frames, linkage: Linkage, name: str, shape: surfaces.Shape) -> None:
    size = (*(shape.size or ENDLESS), 0.0, 0.0)[:3]
    place = {"pos": linkage.local(shape.body, shape.middle), "quat": from_matrix(shape.axes)}
    frame = frames[linkage.scene.body_index(shape.body)]
    frame.add_geom(name=name, type=SHAPES[shape.kind], size=size, mass=0.0, contype=0, conaffinity=0, **place)


def effective_mass(model: mujoco.MjModel, data: mujoco.MjData, geom: str, other: str) -> float:
    """Return 1/(J M^-1 J^T) (kg) of a sphere's normal on another geom at the pose of the data, loops left open."""
    geoms = [data.geom(name) for name in (geom, other)]
    flat = model.geom_type[geoms[1].id] in (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_BOX))
    normal = geoms[1].xmat.reshape(3, 3)[:, 2] if flat else unit(geoms[0].xpos - geoms[1].xpos)
    place = geoms[0].xpos - model.geom(geoms[0].id).size[0] * normal
    row, jacobian, solved = np.zeros((1, model.nv)), np.empty((3, model.nv)), np.empty((1, model.nv))
    for one, sign in zip(geoms, (1.0, -1.0), strict=True):
        mujoco.mj_jac(model, data, jacobian, None, place, model.geom_bodyid[one.id])
        row += sign * normal @ jacobian
    mujoco.mj_solveM(model, data, solved, row)
    return 1.0 / float((row @ solved.T).item())


# solimp with the least impedance MuJoCo allows: F = m_eff (K d + B d' + impedance * a), a the acceleration without it
PENALTY_SOLIMP = (1e-4, 1e-4, 0.001, 0.5, 2.0)


def add_contact(spec, frames, linkage: Linkage, contact: laws.Contact) -> None:
    """A sphere against a plane or another sphere, by the scene's law."""
    (pair,) = add_pairs(spec, frames, linkage, contact)
    mass = surfaces.pair_mass(linkage.scene, contact)  # no pose changes it: bodies are free
    law: Any = contact.law
    pair.solref = (-law.stiffness / mass, -law.damping / mass)
    pair.solimp = PENALTY_SOLIMP


def contact_refusals(scene: Scene) -> list[str]:
    """Return why MuJoCo's own contacts cannot stand for the scene's, contact by contact."""
    reasons = []
    jointed = {end for joint in scene.joints for end in joint.ends}
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        known = isinstance(contact, laws.CircleOnLine | laws.CircleOnCircle | laws.SphereOnPlane | laws.SphereOnSphere)
        if not known or not isinstance(contact.law, laws.SpringDamperLaw):
            given = f"{contact.type} with {contact.law.type}"
            reasons.append(f"{where}: mujoco's own contact takes round things with spring_damper_law, not {given}")
        if contact.friction is not None and not isinstance(contact.friction, laws.StickSlip):
            reasons.append(f"{where}: mujoco regularises friction in its own way; it needs stick_slip")
        if contact.friction is not None and not getattr(contact.law, "damping", 1.0):
            reasons.append(f"{where}: mujoco brakes slip by the law's damping, and without it has no friction at all")
        reasons += surfaces.friction_refusals("mujoco", contact)
        if getattr(contact.law, "damping", 0.0) and getattr(contact.law, "release", "force") != "force":
            reasons.append(f"{where}: mujoco's contact force is never negative; it needs release = 'force'")
        if isinstance(contact, laws.CircleOnLine | laws.SphereOnPlane) and not surfaces.is_half_space(contact):
            reasons.append(f"{where}: a mujoco plane is endless and fixed to the world")
        centers = ((contact.body_a, getattr(contact, "center_a", None) or getattr(contact, "center", None)),
                   (contact.body_b, getattr(contact, "center_b", None)))  # fmt: skip
        for name, center in centers:
            if name == GROUND or center is None:
                continue
            if name in jointed or math.dist(center, scene.bodies[scene.body_index(name)].position) > 1e-12:
                reasons.append(f"{where}: its effective mass, which scales the stiffness, changes as {name!r} moves")
    return reasons
