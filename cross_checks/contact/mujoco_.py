"""MuJoCo with its own contacts: the reference acceleration b v + k r of solref, and the impedance d of solimp.

At constant d, solref = (-K, -B) gives F = m (K r + B v) + d m g, clipped at 0, with m the effective mass of the pair
(MuJoCo documentation, "Solver parameters"). Friction creeps at (1 - d)/(d impratio) of the acceleration without it
over b, and rises with slip above the cone of the weight, so that what slides hops.
"""

import math
from dataclasses import replace
from typing import Any, ClassVar

import mujoco
import numpy as np

from cross_checks.contact import request as wanted
from cross_checks.contact.request import GRAVITY, ContactModel, Refused, Request, Translation, own_law, snippet
from cross_checks.engine import Method, Plan, Refusal, fixed
from cross_checks.engines.mujoco_ import METHODS, Built, MuJoCo, add_loads, at_start, specify_links
from cross_checks.engines.mujoco_.contact import add_pairs, effective_mass
from cross_checks.engines.mujoco_.forces import Callback, force_refusals, shared_forces, takes_shared_forces
from cross_checks.linkage.forces import LOCATED
from cross_checks.linkage.links import Linkage, closure_refusals, held_coordinates, linkage_of
from cross_checks.linkage.surfaces import friction_refusals
from mbs_ref import Scene
from mbs_ref.scene.contact import Friction, RegularisedCoulomb, SpringDamperLaw
from mbs_ref.scene.joints import CoordinateDrive, Drive
from mbs_ref.scene.signals import Constant, piece_at

STOCK_SOLREF, STOCK_SOLIMP = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's defaults, pinned
SLOW = 0.1  # of the speed of sliding, below which friction is in proportion to slip: 1 % of the distance
IMPEDANCE = 0.9  # of solimp, constant: its documented default at depth 0
EULER = next(method for method in METHODS if method.name == "euler")
PYRAMIDAL = {"cone": mujoco.mjtCone.mjCONE_PYRAMIDAL}
STOCK = {"enableflags": 0}  # as shipped, effective masses are approximated
OPTIONS: dict[str, dict[str, Any]] = {  # by method: what decides whether friction holds; the cone is elliptic
    "euler_impratio100": {"impratio": 100.0}, "euler": {}, "euler_noslip": PYRAMIDAL | {"noslip_iterations": 10},
    "stock": STOCK | PYRAMIDAL, "stock_impratio10": STOCK | {"impratio": 10.0},
    "stock_impratio100": STOCK | {"impratio": 100.0}, "stock_noslip": STOCK | PYRAMIDAL | {"noslip_iterations": 10},
}  # fmt: skip
DEFAULT = next(iter(OPTIONS))


class OwnContact(MuJoCo):
    """MuJoCo's Euler, with pairs whose parameters are translated from the laws of the scene."""

    method_table: ClassVar[tuple[Method, ...]] = tuple(
        fixed(name, None, "semi-implicit Euler with MuJoCo's own contacts", requires=frozenset({"contact"}))
        for name in OPTIONS
    )
    extra: ClassVar[frozenset[str]] = frozenset(
        part.model_fields["type"].default for part in (*LOCATED, CoordinateDrive)
    )

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        bare, _ = _without_contacts(scene)
        reasons = closure_refusals(self.name, scene, self.closes) + force_refusals(bare)
        reasons += [Refusal(why, False) for one in scene.contacts for why in friction_refusals(self.name, one)]
        held = held_coordinates(scene)
        if any(isinstance(joint, Drive) and joint not in held for joint in scene.joints):
            reasons.append(Refusal("MuJoCo prescribes motions of mocap bodies alone, which contacts see at rest", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        return built(scene, plan, OPTIONS[plan.method.name])


def built(scene: Scene, plan: Plan, options: dict[str, Any]) -> Built:
    """Return MuJoCo's model of a scene with its own contacts, under options of MuJoCo beside those pinned."""
    linkage, (bare, signals) = linkage_of(scene), _without_contacts(scene)
    spec, frames = specify_links(linkage, replace(plan, method=EULER))
    shared = takes_shared_forces(bare)
    add_loads(spec, frames, bare, shared)
    for option, value in options.items():
        setattr(spec.option, option, value)
    stock = plan.method.name.startswith("stock")
    pairs = [(pair, one) for one in scene.contacts for pair in add_pairs(spec, frames, linkage, one)]
    names = [(pair.name, pair.geomname2, pair.geomname1, contact.law) for pair, contact in pairs]
    for pair, contact in pairs:
        pair.solref, pair.solimp = STOCK_SOLREF, STOCK_SOLIMP
        if not stock:  # solref follows when the effective mass is known
            pair.solimp = (IMPEDANCE, IMPEDANCE, *STOCK_SOLIMP[2:])
            pair.solreffriction = friction_solref(contact.friction, math.hypot(*scene.gravity), plan.step)
    model = spec.compile()
    data = at_start(model, linkage)
    mujoco.mj_forward(model, data)
    for name, pin, other, scene_law in () if stock else names:
        mass = effective_mass(model, data, pin, other)
        law = _resolved(own_law(scene_law, mass, plan.step, "force"), mass, plan.step)
        k, impedance = model.pair(name).id, impedance_of(model, mass, pin, other)
        scale = impedance / IMPEDANCE
        model.pair_solimp[k, :2], model.pair_solreffriction[k, 0] = impedance, model.pair_solreffriction[k, 0] / scale
        model.pair_solref[k] = (-law.stiffness * scale / mass, -law.damping * scale / mass)
    act = shared_forces(model, bare) if shared else _varying(signals)
    return Built(linkage, model, at_start(model, linkage), act)


def impedance_of(model: mujoco.MjModel, mass: float, *geoms: str) -> float:
    """Return the impedance with which a pair of an effective mass (kg) is as soft as with IMPEDANCE and exact masses.

    F (1/m + R) = a_ref - a with R = (1 - d)/(d m'); m' = m if mjENBL_DIAGEXACT is set, else 1/m' is the sum of both
    bodies' invweight0.
    """
    if model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_DIAGEXACT:
        return IMPEDANCE
    mobility = sum(float(model.body_invweight0[model.geom(name).bodyid[0], 0]) for name in geoms)
    return 1.0 / (1.0 + (1.0 / IMPEDANCE - 1.0) / (mass * mobility))


def _without_contacts(scene: Scene) -> tuple[Linkage, dict[str, Any]]:
    """Return a scene's linkage without contacts, and the segments of loads that vary in time, which it has constant.

    A tree keeps them: there the shared force code may act.
    """
    bare = linkage_of(scene.model_copy(update={"contacts": ()}))
    varying = [load for load in scene.loads if not isinstance(getattr(load, "factor", Constant()), Constant)]
    if not bare.closures or not varying:
        return bare, {}
    loads = tuple(load.model_copy(update={"factor": Constant()}) if load in varying else load for load in scene.loads)
    signals = {load.name: load.factor.segments() for load in varying}  # type: ignore[union-attr]
    return linkage_of(scene.model_copy(update={"contacts": (), "loads": loads})), signals


def calls_python(scene: Scene) -> bool:
    """Whether the loads of a scene are those of the shared force code, or vary in time."""
    bare, varying = _without_contacts(scene)
    return takes_shared_forces(bare) or bool(varying)


def _varying(signals: dict[str, Any]) -> Callback | None:
    """Return what sets the actuators of loads that vary in time; None without such loads."""
    if not signals:
        return None

    def act(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        for name, segments in signals.items():
            model.actuator(name).biasprm[0] = piece_at(segments, data.time).value(data.time)

    return act


def _resolved(law: SpringDamperLaw, mass: float, step: float) -> SpringDamperLaw:
    """Return the law, softened at the same rebound to the time constant of two steps that refsafe allows.

    MuJoCo limits solref only in the form (time constant, damping ratio): 2/B >= 2 h, and at critical damping K = B^2/4.
    """
    rate = law.damping / mass * step  # B h
    share = min(1.0, 0.25 * mass / (law.stiffness * step**2), 1.0 / max(rate, 1.0) ** 2)
    numbers = {"stiffness": share * law.stiffness, "damping": math.sqrt(share) * law.damping}
    return law.model_copy(update=numbers)


def friction_solref(friction: Friction | None, gravity: float, step: float) -> tuple[float, float]:
    """Return solreffriction: b = 2/(d tc) slows a slip below v_s at b v, where v_s = mu g/b is the part's or stock."""
    slow = getattr(friction, "speed", math.inf) / max(getattr(friction, "coefficient", 0.0) * gravity, 1e-300)  # 1/b
    return max(2.0 * step, min(2.0 / IMPEDANCE * slow, STOCK_SOLREF[0])), 1.0


def translate(request: Request) -> Translation:
    """Return solref, solimp and friction for the effective mass of the pair."""
    law, d, mu = _resolved(request.law, request.mass, request.step), IMPEDANCE, request.friction
    friction = RegularisedCoulomb(coefficient=mu, speed=SLOW * request.speed) if mu else None
    slip, impratio = friction_solref(friction, GRAVITY, request.step), OPTIONS[DEFAULT]["impratio"]
    creep = 0.5 * (1.0 - d) * slip[0] / impratio * GRAVITY * math.sin(math.atan(wanted.SHARE * mu))
    parameters = {"solref": (-law.stiffness / request.mass, -law.damping / request.mass), "solreffriction": slip,
                  "solimp": (d, d, *STOCK_SOLIMP[2:]), "friction": mu, "impratio": impratio}  # fmt: skip
    refused = {
        wanted.CREEP: Refused(creep, "friction is regularised: (1 - d) a/(d b impratio) without noslip_iterations"),
        wanted.SINK: Refused((1.0 - d) * request.mass * GRAVITY / law.stiffness, "the impedance bears d m g"),
    }
    refused = refused if mu else {}
    if law.stiffness < request.stiffness:
        soft, why = replace(request, stiffness=law.stiffness).figures, "the time constant is at least two steps"
        refused |= {label: Refused(soft[label], why) for label in (wanted.DURATION, wanted.PENETRATION)}
    values = {name: " ".join(f"{x:.10g}" for x in np.atleast_1d(value)) for name, value in parameters.items()}
    text = snippet("mujoco.xml", mass=f"{request.mass:g}", step=f"{request.step:g}", **values)
    return Translation(law, friction, parameters, text, refused)


MODEL = ContactModel(OwnContact(), translate, (DEFAULT, "stock"))
