"""Newton with its own contacts, under Featherstone's solver: a spring, and a damper that acts on approach alone.

F = ke d + kd max(d', 0) at a depth d > 0, and friction kf v_t up to mu F; of two shapes the numbers are averaged
(newton/_src/solvers/semi_implicit/kernels_contact.py of 1.8.0). With w^2 = k/m and z = c/(2 m w) an impact goes as deep
as e v/w, e = exp(-z acos(z)/sqrt(1 - z^2)), from where the spring throws it back: e is the rebound.
"""

import cmath
import math
from collections import Counter
from dataclasses import replace
from typing import Any, ClassVar, get_args

# the first, for its absence is what says that the extra is not installed
from cross_checks.engines.newton_ import Built, Newton, newton, warp

# isort: split
from scipy.optimize import brentq

from cross_checks.contact import request as wanted
from cross_checks.contact.request import GRAVITY, ContactModel, Refused, Request, Translation, own_law, rebound_of
from cross_checks.engine import SINGLE, Method, Plan, Refusal, fixed
from cross_checks.engines.newton_ import METHODS
from cross_checks.linkage.links import FIXED, Linkage, closure_refusals, linkage_of
from cross_checks.linkage.surfaces import friction_refusals, pair_mass, shapes_of
from mbs_ref import Scene
from mbs_ref.scene import GROUND, contact
from mbs_ref.scene.euler_parameters import from_matrix

OWN, STOCK = "featherstone", "stock"
STOCK_MATERIAL = {"ke": 2.5e3, "kd": 100.0, "kf": 1000.0}  # Newton's defaults, pinned
GRIP = 0.5  # of m/h, the friction gain that stops a slip within a step: what turns, too, has a smaller inertia there
ONE_SIDED = "its damper acts on approach alone"


class OwnContact(Newton):
    """Newton's Featherstone solver with shapes whose materials are translated from the laws of the scene."""

    method_table: ClassVar[tuple[Method, ...]] = tuple(
        fixed(name, 1, text, requires=frozenset({"contact"}), roundoff=SINGLE)
        for name, text in ((OWN, f"{METHODS[0].description}, own contacts"), (STOCK, "the same, contacts as shipped"))
    )
    extra: ClassVar[frozenset[str]] = frozenset(
        part.model_fields["type"].default
        for kind in (contact.Contact, contact.ContactLaw, contact.Friction)
        for part in get_args(get_args(kind)[0])
        if part is not contact.PinOnSprocket
    )

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [Refusal(why, False) for one in scene.contacts for why in friction_refusals(self.name, one)]
        return closure_refusals(self.name, scene, self.closes) + reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage, between = linkage_of(scene), Counter(frozenset(one.ends) for one in scene.contacts)
        known: dict[str, int] = {}

        def add_shapes(builder: Any, bodies: dict[int, int]) -> list[tuple[int, int]]:
            pairs = []
            for one in scene.contacts:
                material = _material(scene, one, plan, between[frozenset(one.ends)])
                a, b = (_add_shape(builder, bodies, linkage, shape, material, known) for shape in shapes_of(one))
                pairs.append((min(a, b), max(a, b)))
            return pairs

        return self.built(linkage, replace(plan, method=METHODS[0]), add_shapes)


def _material(scene: Scene, one: Any, plan: Plan, several: int) -> dict[str, float]:
    """Return the material of both shapes of a contact, `several` of which share a load and the grip of friction."""
    mu, mass = getattr(one.friction, "coefficient", 0.0), pair_mass(scene, one)
    if plan.method.name == STOCK:
        return STOCK_MATERIAL | {"mu": mu}
    stiffness = own_law(one.law, mass, plan.step, "force").stiffness
    damping = damping_of(rebound_of(one.law, mass), stiffness, mass)
    return {"ke": stiffness, "kd": damping, "kf": GRIP * mass / (plan.step * several), "mu": mu}


def _add_shape(builder, bodies: dict[int, int], linkage: Linkage, shape, material, known: dict[str, int]) -> int:
    key = repr((shape.key, material))
    if key not in known:
        body = bodies[FIXED if shape.body == GROUND else linkage.scene.body_index(shape.body)]
        body = _welded(builder) if body < 0 and shape.kind == "sphere" else body
        w, *vector = from_matrix(shape.axes)
        pose = warp.transform(linkage.local(shape.body, shape.middle), warp.quat(*vector, w))
        config = newton.ModelBuilder.ShapeConfig(density=0.0, **material)
        place = {"xform": pose, "cfg": config}
        if shape.kind == "sphere":
            known[key] = builder.add_shape_sphere(body, radius=shape.size[0], **place)
        elif shape.kind == "half_space":
            known[key] = builder.add_shape_plane(None, body=body, width=0.0, length=0.0, **place)
        else:
            known[key] = builder.add_shape_box(body, **dict(zip(("hx", "hy", "hz"), shape.size, strict=True)), **place)
    return known[key]


def _welded(builder) -> int:
    """Return a body fixed to the world: depths leave out the radius of a sphere without one (Newton's issue 272)."""
    body = builder.add_link(mass=1.0, inertia=warp.mat33(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    builder.add_articulation([builder.add_joint_fixed(-1, body)])
    return body


def compressed(ratio: float) -> float:
    """Return the angle acos(z)/sqrt(1 - z^2) (rad) of the free oscillation until the depth is largest, z the ratio."""
    return abs(cmath.acos(ratio) / cmath.sqrt(1.0 - ratio**2))


def damping_of(rebound: float, stiffness: float, mass: float) -> float:
    """Return the damping (N s/m) on approach with which an impact rebounds so."""
    rebound = min(max(rebound, wanted.LEAST_REBOUND), 1.0 - 1e-9)

    def excess(ratio: float) -> float:
        return math.exp(-math.exp(ratio) * compressed(math.exp(ratio))) - rebound

    ratio = math.exp(brentq(excess, *map(math.log, (1e-10, 1e5)), xtol=1e-13))  # type: ignore[arg-type]
    return 2.0 * ratio * math.sqrt(stiffness * mass)


def translate(request: Request) -> Translation:
    """Return the material of two equal shapes."""
    k, mass, mu, step = request.stiffness, request.mass, request.friction, request.step
    damping, omega = damping_of(request.rebound, k, mass), math.sqrt(k / mass)
    ratio = damping / (2.0 * mass * omega)
    refused = {
        wanted.DURATION: Refused((compressed(ratio) + 0.5 * math.pi) / omega, ONE_SIDED),
        wanted.PENETRATION: Refused(request.rebound * request.speed / omega, ONE_SIDED),
    }
    parameters = {"ke": k, "kd": damping, "kf": GRIP * mass / step, "ka": 0.0, "mu": mu}
    pull = mass * GRAVITY * math.sin(math.atan(wanted.SHARE * mu))
    creep = {wanted.CREEP: Refused(pull / parameters["kf"], "friction is kf v below mu F")} if mu else {}
    friction = contact.StickSlip(coefficient=mu, stiffness=k) if mu else None
    text = wanted.snippet("newton.txt", mass=mass, step=step, **parameters)
    return Translation(request.law, friction, parameters, text, refused | creep)


MODEL = ContactModel(OwnContact(), translate, (OWN, STOCK))
