"""Drake's discrete point contact: under SAP a spring and a damper, and friction that creeps in proportion to the step.

The normal impulse of a step h is h (k d + k (h + tau) d') >= 0 with the velocity at its end, so that c = k (h + tau).
Below the cone friction's impulse is -v/R_t, R_t = sigma w, sigma = 1e-3 and w = ||W||_F/3 of the contact's mobility W
(3, 3): what is held creeps by sigma w m h a, a its acceleration without friction (Castro, Permenter and Han 2022, "An
unconstrained convex formulation of compliant contact", section V).
"""

import math
from typing import Any, ClassVar

from pydrake import geometry
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction, DiscreteContactApproximation, MultibodyPlant

from cross_checks.contact import request as wanted
from cross_checks.contact.request import ContactModel, Request, Translation, damped_by_step, own_law, snippet
from cross_checks.engine import Method, Plan, Refusal, fixed
from cross_checks.engines.drake_ import SAP, Built, Drake
from cross_checks.engines.drake_.build import Shapes
from cross_checks.linkage.forces import LOCATED
from cross_checks.linkage.links import Linkage, closure_refusals, linkage_of
from cross_checks.linkage.surfaces import friction_refusals, pair_mass, shapes_of
from mbs_ref import Scene
from mbs_ref.scene.contact import PinOnSprocket, StickSlip

SIGMA = 1e-3  # -, of SAP's friction, fixed in Drake
MOBILITY = math.sqrt(2.0) / 3.0  # w m = m ||W||_F/3 with W = diag(1, 0, 1)/m of a planar body that does not turn
SHAPES: dict[str, Any] = {
    "sphere": geometry.Sphere, "half_space": geometry.HalfSpace,
    "box": lambda *half: geometry.Box(*(2.0 * side for side in half)),
}  # fmt: skip
STOCK = geometry.DefaultProximityProperties()
APPROXIMATIONS = {  # by method: what solves the contact problem; stock is as shipped
    SAP: DiscreteContactApproximation.kSap, "similar": DiscreteContactApproximation.kSimilar,
    "lagged": DiscreteContactApproximation.kLagged, "stock": DiscreteContactApproximation.kLagged,
}  # fmt: skip


class OwnContact(Drake):
    """Drake's discrete time with compliant point contact, its parameters translated from the laws of the scene.

    Damping is so for SAP alone: "similar" and "lagged" take stiffness and friction, and Drake's default dissipation.
    """

    method_table: ClassVar[tuple[Method, ...]] = tuple(
        fixed(name, 1, "symplectic Euler with Drake's own contacts", requires=frozenset({"contact"}))
        for name in APPROXIMATIONS
    )
    extra: ClassVar[frozenset[str]] = frozenset(part.model_fields["type"].default for part in LOCATED)

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = closure_refusals(self.name, scene, self.closes)
        reasons += [Refusal(why, False) for one in scene.contacts for why in friction_refusals(self.name, one)]
        if any(isinstance(contact, PinOnSprocket) for contact in scene.contacts):
            reasons.append(Refusal("the gaps between teeth are not convex, and Drake's shapes are", True))
        return reasons

    def build(self, scene: Scene, plan: Plan, shapes: tuple[Shapes, geometry.SceneGraph] | None = None) -> Built:
        linkage, graph = linkage_of(scene), geometry.SceneGraph()

        def add_shapes(plant: MultibodyPlant, bodies: dict[int, Any]) -> None:
            plant.RegisterAsSourceForSceneGraph(graph)
            plant.set_discrete_contact_approximation(APPROXIMATIONS[plan.method.name])
            known: dict[str, Any] = {}
            pairs = [_add_pair(plant, bodies, linkage, contact, plan, known) for contact in scene.contacts]
            every = geometry.GeometrySet([shape for pair in pairs for shape in pair])
            declared = geometry.CollisionFilterDeclaration().ExcludeWithin(every)
            for a, b in pairs:
                declared.AllowBetween(geometry.GeometrySet(a), geometry.GeometrySet(b))
            graph.collision_filter_manager().Apply(declared)

        return super().build(scene.model_copy(update={"contacts": ()}), plan, (add_shapes, graph))


def _add_pair(
    plant: MultibodyPlant, bodies: dict[int, Any], linkage: Linkage, contact: Any, plan: Plan, known: dict[str, Any]
) -> list[Any]:
    """Add the two shapes of a contact, each with twice the stiffness and half the relaxation time; return their ids.

    `known` has those that are there: 15 half-spaces end the process (SIGSEGV, seen in 1.58.0).
    """
    properties = geometry.ProximityProperties()
    mu = getattr(contact.friction, "coefficient", 0.0)
    stiffness, tau = 0.5 * STOCK.point_stiffness, 2.0 * STOCK.relaxation_time  # of two shapes as shipped
    if plan.method.name != "stock":
        law = damped_by_step(own_law(contact.law, pair_mass(linkage.scene, contact), plan.step, "force"), plan.step)
        stiffness, tau = law.stiffness, law.damping / law.stiffness - plan.step
    material = {"dissipation": STOCK.hunt_crossley_dissipation, "point_stiffness": 2.0 * stiffness}
    geometry.AddContactMaterial(properties=properties, friction=CoulombFriction(mu, mu), **material)
    properties.AddProperty("material", "relaxation_time", 0.5 * tau)
    ids = []
    for end, shape in zip("ab", shapes_of(contact), strict=True):
        key = repr((shape.key, stiffness, tau, mu))
        if key not in known:
            pose = RigidTransform(RotationMatrix(shape.axes), linkage.local(shape.body, shape.middle))
            owner, own = bodies[linkage.scene.body_index(shape.body)], SHAPES[shape.kind](*shape.size)
            known[key] = plant.RegisterCollisionGeometry(owner, pose, own, f"{contact.name}/{end}", properties)
        ids.append(known[key])
    return ids


def translate(request: Request) -> Translation:
    """Return stiffness, relaxation time and friction of two equal shapes under SAP."""
    law, mu, step = damped_by_step(request.law, request.step), request.friction, request.step
    tau = law.damping / law.stiffness - step
    friction = StickSlip(coefficient=mu, stiffness=law.stiffness) if mu else None
    pull = wanted.GRAVITY * math.sin(math.atan(wanted.SHARE * mu))
    creep = wanted.Refused(SIGMA * MOBILITY * step * pull, "friction is regularised in proportion to the step")
    refused = wanted.refused_of_step(request) | ({wanted.CREEP: creep} if mu else {})
    parameters = {"point_stiffness": 2.0 * law.stiffness, "relaxation_time": 0.5 * tau, "friction": mu}
    text = snippet("drake.txt", mass=request.mass, step=step, friction=mu, stiffness=2.0 * law.stiffness, tau=0.5 * tau)
    return Translation(law, friction, parameters, text, refused)


MODEL = ContactModel(OwnContact(), translate, (SAP, "stock"))
