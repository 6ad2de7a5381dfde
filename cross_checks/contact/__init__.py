"""Engines with their own contact models, compared by figures: one file for each engine, listed at run time.

Some run under a Python of their own, where a driver script of `drivers` runs them: free bodies with contacts alone.
ODE's ERP and CFM, and Bullet's stiffness and damping, are a spring and a damper whose force of a step h takes the
velocity at its end: c = damping + k h. Siconos has impacts by Newton's law and Coulomb's friction, and no stiffness.
"""

import json
import subprocess
from collections.abc import Iterator, Sequence
from copy import copy
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cross_checks import engines
from cross_checks.contact import request as wanted
from cross_checks.contact.request import ContactModel, Request, Translation, damped_by_step, own_law, snippet
from cross_checks.engine import End, Engine, Loop, Method, Plan, Poses, Refusal, fixed
from cross_checks.engines.elsewhere import Elsewhere
from cross_checks.isolation.environments import home_of, python_of
from cross_checks.judge.vocabulary import OURS
from cross_checks.linkage import surfaces
from cross_checks.linkage.links import Linkage, lifted, linkage_of
from cross_checks.linkage.motion import Motion, poses_of
from mbs_ref import Scene, Status
from mbs_ref.scene import GROUND
from mbs_ref.scene.contact import PinOnSprocket, RoundPair, StickSlip
from mbs_ref.scene.traits import part_types

DRIVEN = ("bullet", "ode", "siconos")  # by a driver, under a Python of their own
ENGINES = ("mujoco", "mjx", "exudyn", "drake", "dart", "newton", *DRIVEN)  # that have a contact model of their own
DRIVERS = Path(__file__).parent / "drivers"
METHODS = {  # engine -> its one method
    "bullet": fixed("impulses", 1, "symplectic Euler, sequential impulses", requires=frozenset({"contact"})),
    "ode": fixed("step", 1, "symplectic Euler, Dantzig's LCP", requires=frozenset({"contact"})),
    "siconos": fixed("moreau", 1, "Moreau and Jean's time stepping", requires=frozenset({"contact"})),
}
ENDLESS = (1e9, 1e9)  # m
LONG = 600.0  # s, of a run
PRODUCTS = 1e-9  # of the largest moment of inertia: smaller products are roundoff


class Driven(Engine):
    """An engine that its driver runs in another process: bodies as standard input, rows as standard output."""

    part_types: ClassVar[frozenset[str]] = frozenset({"planar", "spatial"})

    def __init__(self, name: str, home: Path) -> None:
        self.name = self.package = name  # type: ignore[misc]
        self.python, self.script = python_of(home), DRIVERS / f"{name}_.py"

    def methods(self) -> tuple[Method, ...]:
        return (METHODS[self.name],)

    def version(self) -> str:
        return self._call("--version").stdout.strip()

    def _call(self, *arguments: str, given: str = "") -> Any:
        command = [str(self.python), str(self.script), *arguments]
        try:
            return subprocess.run(command, input=given, capture_output=True, text=True, check=False, timeout=LONG)
        except subprocess.TimeoutExpired as late:
            raise TimeoutError(f"its driver took more than {LONG:g} s and was stopped") from late

    def refusals(self, scene: Scene) -> list[Refusal]:
        parts = sorted(part_types(scene.model_copy(update={"contacts": ()})) - self.part_types)
        reasons = [f"the driver of {self.name} has no part type {kind!r}" for kind in parts]
        for contact in scene.contacts:
            reasons += surfaces.friction_refusals(self.name, contact)
            where = f"contact {contact.name!r}: the driver of {self.name} has"
            if isinstance(contact, PinOnSprocket):
                reasons.append(f"{where} no sprocket")
            elif contact.body_a == GROUND:
                reasons.append(f"{where} ground as body_b alone")
            elif self.name == "bullet" and not isinstance(contact, RoundPair) and not surfaces.is_half_space(contact):
                reasons.append(f"{where} endless planes on ground alone")
        if self.name == "bullet" and not reasons:
            reasons += _limits_of_bullet(scene)
            reasons += surfaces.body_refusals("the driver of bullet", scene, scene.body_names)
        return [Refusal(reason, permanent=False) for reason in dict.fromkeys(reasons)]

    def build(self, scene: Scene, plan: Plan) -> Linkage:
        return linkage_of(scene)

    def advance(self, model: Linkage, plan: Plan) -> Loop:
        scene = model.scene
        bodies = [_body(model, k) for k in range(len(scene.bodies))]
        contacts = [_contact(model, contact, plan.step) for contact in scene.contacts]
        problem = {"step": plan.step, "counts": plan.counts, "gravity": model.gravity.tolist()}
        done = self._call(given=json.dumps(problem | {"bodies": bodies, "contacts": contacts}))
        start = [[*b["position"], *b["orientation"], *b["velocity"], *b["spin"]] for b in bodies]
        rows = np.array([start, *(json.loads(line) for line in done.stdout.splitlines() if line.startswith("[["))])
        ended = f"its driver ended with code {done.returncode}: {done.stderr.strip()[-200:]}"
        end = End(len(rows), Status.ENGINE_ERROR, ended) if len(rows) < len(plan.times) else End(len(rows))
        return Loop(rows, end, sum(plan.counts))

    def poses(self, model: Linkage, plan: Plan, states: np.ndarray) -> Poses:
        position, turn, velocity, spin = np.split(states, (3, 7, 10), axis=2)
        angle = np.unwrap(2.0 * np.arctan2(turn[..., 3], turn[..., 0]), axis=0)
        return poses_of(model, map(Motion, position, turn, velocity, spin, angle))


def _limits_of_bullet(scene: Scene) -> Iterator[str]:
    """Yield which bodies have products of inertia, which the driver of Bullet cannot give them."""
    for body, link in zip(scene.bodies, linkage_of(scene).of_body, strict=True):
        where, diagonal = f"body {body.name!r}: the driver of bullet has", np.diag(link.inertia)
        if np.abs(link.inertia - np.diag(diagonal)).max() > PRODUCTS * diagonal.max():
            yield f"{where} principal axes along those of the world at t = 0 alone"


def _body(model: Linkage, k: int) -> dict[str, Any]:
    """Return a body in the axes of the world at t = 0; in the plane it has the same moment of inertia about all."""
    body: Any = model.scene.bodies[k]
    spin = np.append(np.zeros(2), body.angular_velocity)[-3:]
    vectors = {"position": body.position, "velocity": body.velocity}
    return {name: lifted(vector).tolist() for name, vector in vectors.items()} | {
        "mass": body.mass, "inertia": model.of_body[k].inertia.tolist(), "orientation": [1.0, 0.0, 0.0, 0.0],
        "spin": spin.tolist(),
    }  # fmt: skip


def _contact(model: Linkage, contact: Any, step: float) -> dict[str, Any]:
    scene = model.scene
    mass, (ball, other) = surfaces.pair_mass(scene, contact), surfaces.shapes_of(contact)
    law = damped_by_step(own_law(contact.law, mass, step, "force"), step)

    def local(shape: surfaces.Shape, out: float = 0.0) -> list[float]:
        origin = 0.0 if shape.body == GROUND else lifted(scene.bodies[scene.body_index(shape.body)].position)
        return (shape.middle + out * shape.axes[:, 2] - origin).tolist()

    found = {
        "a": scene.body_index(contact.body_a), "b": scene.body_index(contact.body_b),
        "center": local(ball), "radius": ball.size[0], "stiffness": law.stiffness,
        "damping": law.damping - law.stiffness * step, "friction": getattr(contact.friction, "coefficient", 0.0),
        "rebound": wanted.rebound_of(contact.law, mass),
    }  # fmt: skip
    if other.kind == "sphere":
        return found | {"origin": local(other), "other": other.size[0]}
    *sides, thickness = (2.0 * half for half in other.size or (*ENDLESS, 0.5 * surfaces.THICK))
    size = {"sides": sides, "thickness": thickness, "axes": other.axes.T.tolist()}
    return found | size | {"origin": local(other, 0.5 * thickness if other.size else 0.0)}


def translate(name: str, request: Request) -> Translation:
    """Return an engine's parameters of two equal bodies."""
    mu, step = request.friction, request.step
    law, refused = damped_by_step(request.law, step), wanted.refused_of_step(request)
    k, c = law.stiffness, law.damping - law.stiffness * step
    parameters: dict[str, Any] = {"mu": mu, "soft_erp": step * k / (step * k + c), "soft_cfm": 1.0 / (step * k + c)}
    if name == "bullet":
        parameters = {"lateralFriction": mu**0.5, "contactStiffness": 2.0 * k, "contactDamping": 0.5 * c}
    if name == "siconos":
        parameters, refused = {"e": request.rebound, "mu": mu}, wanted.refused_of_rigid(request)
    friction = StickSlip(coefficient=mu, stiffness=k) if mu else None
    text = snippet(f"{name}.txt", step=step, **parameters)
    return Translation(request.law if name == "siconos" else law, friction, parameters, text, refused)


def model_of(engine: str) -> ContactModel | str:
    """Return the contact model of an engine, or the reason why there is none; ValueError for another name."""
    if engine not in ENGINES:
        raise ValueError(f"engine = {engine!r} has no contact model here; allowed: {', '.join(ENGINES)}")
    if engine in DRIVEN:
        if (home := home_of(engine)) is None:
            return "not installed"
        return ContactModel(Driven(engine, home), partial(translate, engine), (METHODS[engine].name,))
    found = next(engines.installed([engine]), None)
    if found is None:
        return "not installed"
    return _model_there(engine, found.home) if isinstance(found, Elsewhere) else _model_here(engine)


@cache
def _model_there(name: str, home: Path) -> ContactModel:
    there = Elsewhere(name, home, _engine_here)
    return ContactModel(there, partial(there.ask, _translation, name), there.ask(_compared, name))


def _model_here(name: str) -> ContactModel:
    return import_module(f"{__name__}.{name}_").MODEL


def _engine_here(name: str) -> Engine:
    return _model_here(name).engine


def _translation(_: object, name: str, request: Request) -> Translation:
    return _model_here(name).translate(request)


def _compared(_: object, name: str) -> tuple[str, ...]:
    return _model_here(name).compared


def own_engine(name: str) -> Engine:
    """Return the engine with its own contact model, or ours; others refuse every scene. Raises EngineMissing."""
    model = model_of(name) if name in ENGINES else f"{name} has no contact model of its own"
    if isinstance(model, ContactModel):
        return model.engine
    engine = copy(engines.get(name))
    vars(engine).update({} if name == OURS else {"refusals": lambda _: [Refusal(model, permanent=False)]})
    return engine


def models(names: Sequence[str] = ENGINES) -> tuple[dict[str, ContactModel], list[str]]:
    """Return the contact models of the engines that are installed, and a sentence for each of the others."""
    known = {name: model_of(name) for name in names}
    absent = [f"{name}: {model}" for name, model in known.items() if isinstance(model, str)]
    return {name: model for name, model in known.items() if isinstance(model, ContactModel)}, absent
