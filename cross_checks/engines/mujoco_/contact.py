"""Contact: spheres and planes, paired explicitly.

Friction is MuJoCo's own: an elliptic cone whose projection raises the normal force of a contact that slides, so
that a thrown sphere hops. It acts between the surfaces, half the penetration nearer to the centre than ours.
"""

import math
from typing import Any

from cross_checks.engines.mujoco_.pairs import add_pair
from cross_checks.linkage.links import Linkage
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene import contact as laws

# solimp with the least impedance MuJoCo allows: F = m_eff (K d + B d' + impedance * a), a the acceleration without it
PENALTY_SOLIMP = (1e-4, 1e-4, 0.001, 0.5, 2.0)


def add_contact(spec, frames, linkage: Linkage, contact: laws.Contact) -> None:
    """A sphere against a plane or another sphere, by the scene's law."""
    pair = add_pair(spec, frames, linkage, contact)
    masses = {body.name: body.mass for body in linkage.scene.bodies} | {GROUND: math.inf}
    mass = 1.0 / (1.0 / masses[contact.body_a] + 1.0 / masses[contact.body_b])  # no pose changes it: bodies are free
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
        if isinstance(contact.friction, laws.RegularisedCoulomb):
            reasons.append(f"{where}: mujoco regularises friction in its own way; it needs stick_slip")
        if contact.friction is not None and not getattr(contact.law, "damping", 1.0):
            reasons.append(f"{where}: mujoco brakes slip by the law's damping, and without it has no friction at all")
        if getattr(contact.friction, "static", None) not in (None, getattr(contact.friction, "coefficient", None)):
            reasons.append(f"{where}: mujoco has one coefficient of friction; leave static out")
        if getattr(contact.law, "damping", 0.0) and getattr(contact.law, "release", "force") != "force":
            reasons.append(f"{where}: mujoco's contact force is never negative; it needs release = 'force'")
        endless = getattr(contact, "extent", "") in ("line", "plane") and getattr(contact, "thickness", None) is None
        if isinstance(contact, laws.CircleOnLine | laws.SphereOnPlane) and (contact.body_b != GROUND or not endless):
            reasons.append(f"{where}: a mujoco plane is endless and fixed to the world")
        centers = ((contact.body_a, getattr(contact, "center_a", None) or getattr(contact, "center", None)),
                   (contact.body_b, getattr(contact, "center_b", None)))  # fmt: skip
        for name, center in centers:
            if name == GROUND or center is None:
                continue
            if name in jointed or math.dist(center, scene.bodies[scene.body_index(name)].position) > 1e-12:
                reasons.append(f"{where}: its effective mass, which scales the stiffness, changes as {name!r} moves")
    return reasons
