"""Exudyn's GeneralContact: a spring and a damper for each shape, in series, with friction in proportion to slow slip.

Two spheres only push: F = k d + c d' >= 0. A sphere pulls at a triangle until the gap opens, and then rebounds with
exp(-pi z/sqrt(1 - z^2)). Friction grows up to mu F at frictionProportionalZone (Exudyn documentation, GeneralContact).
"""

import math
from typing import Any, ClassVar

import numpy as np

from cross_checks.contact import request as wanted
from cross_checks.contact.request import GRAVITY, ContactModel, Refused, Request, Translation, linear_law, own_law
from cross_checks.engine import Method, Plan, Refusal
from cross_checks.engine.plan import DEFAULT_STEP
from cross_checks.engines.exudyn_ import Built, Exudyn
from cross_checks.engines.exudyn_.contact import FLAT, SLOW, surface_of
from cross_checks.engines.exudyn_.run import CONTACT, METHODS
from cross_checks.linkage.surfaces import friction_refusals, pair_mass
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import RegularisedCoulomb, StickSlip

CORNER = 1e-3  # m, deeper than the corners of bodies at rest sink


class OwnContact(Exudyn):
    """Exudyn with shapes whose parameters are translated from the laws of the scene."""

    method_table: ClassVar[tuple[Method, ...]] = tuple(method for method in METHODS if method.name == CONTACT)

    def refusals(self, scene: Scene) -> list[Refusal]:
        return super().refusals(translated(scene, DEFAULT_STEP))

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        return super().method_refusals(translated(scene, DEFAULT_STEP), method)

    def build(self, scene: Scene, plan: Plan) -> Built:
        return super().build(translated(scene, plan.step), plan)


def translated(scene: Scene, step: float) -> Scene:
    """Return the scene with laws and shapes that Exudyn has."""
    contacts = tuple(contact.model_copy(update=_own(scene, contact, step)) for contact in scene.contacts)
    return scene.model_copy(update={"contacts": contacts})


def _own(scene: Scene, contact: Any, step: float) -> dict[str, object]:
    """Return the law, and for a corner the sphere whose lowest point it is: a sphere of radius 0 touches nothing."""
    mass, flat = pair_mass(scene, contact), isinstance(contact, FLAT)
    own: dict[str, object] = {"law": own_law(contact.law, mass, step, "gap" if flat else "force")}
    if isinstance(contact.friction, StickSlip) and not friction_refusals("Exudyn", contact):
        speed = ramp(contact.friction.coefficient, math.hypot(*scene.gravity), step) or SLOW
        own["friction"] = RegularisedCoulomb(coefficient=contact.friction.coefficient, speed=speed)
    if flat and not contact.radius:
        normal = np.array(surface_of(contact)[1])[: scene.dimension]
        own |= {"radius": CORNER, "center": tuple((np.array(contact.center) + CORNER * normal).tolist())}
    return own


def ramp(friction: float, gravity: float, step: float) -> float:
    """Return frictionProportionalZone (m/s): friction stops a slip of it within a step, and no slower one faster."""
    return friction * gravity * step


def translate(request: Request) -> Translation:
    """Return stiffness, damping and friction of two equal shapes, and of a sphere and triangles."""
    mu = request.friction
    floor = linear_law(request.rebound, request.stiffness, request.mass, "gap")
    zone = ramp(mu, GRAVITY, request.step)
    shapes = {"contactStiffness": 2.0 * request.stiffness, "contactDamping": 0.5 * request.law.damping}
    parameters = {**shapes, "contactDamping of triangles": 0.5 * floor.damping, "frictionProportionalZone": zone}
    creep = Refused(wanted.SHARE * zone, "friction is in proportion to slip below frictionProportionalZone")
    text = wanted.snippet(
        "exudyn.txt", mass=request.mass, step=request.step, friction=mu, ramp=zone, stiffness=2.0 * request.stiffness,
        damping=0.5 * request.law.damping, floor_damping=0.5 * floor.damping,
    )  # fmt: skip
    friction = RegularisedCoulomb(coefficient=mu, speed=zone) if mu else None
    return Translation(request.law, friction, parameters, text, {wanted.CREEP: creep} if mu else {}, floor)


MODEL = ContactModel(OwnContact(), translate, (CONTACT,))
