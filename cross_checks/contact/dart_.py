"""DART with its own contacts: Newton's law of impact, and Coulomb's friction along two axes, in one boxed LCP a step.

Restitutions of two shapes multiply, the smaller of their frictions counts, and a rebound slower than REBOUND is none
(DART 6.20, dart/constraint/ContactConstraint.cpp). Contacts are rigid.
"""

from typing import Any, ClassVar

import dartpy  # an optional extra
import numpy as np

from cross_checks.contact import request as wanted
from cross_checks.contact.request import ContactModel, Refused, Request, Translation, rebound_of, snippet
from cross_checks.engine import Method, Plan, Refusal, fixed
from cross_checks.engines.dart_ import Built, Dart
from cross_checks.linkage.forces import LOCATED
from cross_checks.linkage.links import closure_refusals
from cross_checks.linkage.surfaces import Shape, body_refusals, friction_refusals, pair_mass, shapes_of
from mbs_ref import Scene
from mbs_ref.scene import GROUND
from mbs_ref.scene.contact import StickSlip

REBOUND = 0.1  # m/s, DART_BOUNCING_VELOCITY_THRESHOLD
LCP = fixed("boxed_lcp", 1, "symplectic Euler with DART's own contacts", requires=frozenset({"contact"}))


class OwnContact(Dart):
    """DART with the spheres and boxes of contacts; it tests all shapes of two bodies against each other."""

    method_table: ClassVar[tuple[Method, ...]] = (LCP,)
    extra: ClassVar[frozenset[str]] = frozenset(part.model_fields["type"].default for part in LOCATED)

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [why for one in scene.contacts for why in friction_refusals(self.name, one)]
        reasons += body_refusals(self.name, scene, (*scene.body_names, GROUND))
        return closure_refusals(self.name, scene, self.closes) + [Refusal(why, False) for why in reasons]

    def build(self, scene: Scene, plan: Plan) -> Built:
        built = super().build(scene.model_copy(update={"contacts": ()}), plan)
        ground = dartpy.dynamics.Skeleton(GROUND)
        ground.setMobile(False)
        nodes = dict(zip(scene.body_names, built.reader.nodes, strict=True))
        nodes[GROUND] = ground.createWeldJointAndBodyNodePair()[1]
        built.world.addSkeleton(ground)
        solver, kept = built.world.getConstraintSolver(), set()
        solver.setCollisionDetector(dartpy.collision.DARTCollisionDetector())  # spheres and boxes without meshes
        built.reader.skeleton.setSelfCollisionCheck(True)
        for contact in scene.contacts:
            rebound = rebound_of(contact.law, pair_mass(scene, contact)) ** 0.5
            for shape in shapes_of(contact, boxes=True):
                place = built.linkage.local(shape.body, shape.middle)
                if shape.key not in kept:
                    _add(nodes[shape.body], place, shape, rebound, contact.friction)
                kept.add(shape.key)
        filtered = solver.getCollisionOption().collisionFilter
        touching = {frozenset(contact.ends) for contact in scene.contacts}
        for k, a in enumerate(nodes):
            for b in list(nodes)[:k]:
                if frozenset((a, b)) not in touching:
                    filtered.addBodyNodePairToBlackList(nodes[a], nodes[b])
        return built


def _add(node: Any, place: np.ndarray, shape: Shape, rebound: float, friction: Any) -> None:
    kinds, ball = dartpy.dynamics, shape.kind == "sphere"
    own = kinds.SphereShape(*shape.size) if ball else kinds.BoxShape([2.0 * half for half in shape.size])
    one, pose = node.createShapeNode(own), dartpy.math.Isometry3()
    pose.set_rotation(shape.axes)
    pose.set_translation(place)
    one.setRelativeTransform(pose)
    one.createCollisionAspect()
    aspect = one.createDynamicsAspect()
    aspect.setRestitutionCoeff(rebound)
    aspect.setFrictionCoeff(getattr(friction, "coefficient", 0.0))


def translate(request: Request) -> Translation:
    """Return restitution and friction of both shapes of a pair."""
    refused = wanted.refused_of_rigid(request)
    if request.rebound * request.speed < REBOUND:
        refused |= {wanted.RESTITUTION: Refused(0.0, f"a rebound slower than {REBOUND:g} m/s is none")}
    parameters = {"restitution": request.rebound**0.5, "friction": request.friction}
    friction = StickSlip(coefficient=request.friction, stiffness=request.stiffness) if request.friction else None
    text = snippet("dart.txt", step=request.step, **parameters)
    return Translation(request.law, friction, parameters, text, refused)


MODEL = ContactModel(OwnContact(), translate, (LCP.name,))
