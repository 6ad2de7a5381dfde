"""MuJoCo: joints in a tree are exact minimal coordinates; loop closures are always soft constraints."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from time import perf_counter
from typing import ClassVar

import mujoco
import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.joint_tree import FIXED, Edge, JointTree, joint_tree, local
from cross_checks.outcome import End, Plan, end_of, plan_run, trajectory
from cross_checks.prescribed import constant_value
from cross_checks.reactions import tree_reactions
from cross_checks.spatial_tree import SpatialEdge, SpatialTree, spatial_tree
from mbs_ref.contact import CircleOnCircle, CircleOnLine
from mbs_ref.scene import (
    GROUND,
    Cylindrical,
    Distance,
    Force,
    PlanarBody,
    Prismatic,
    Revolute,
    Scene,
    SpatialBody,
    Spherical,
    SpringDamper,
    Torque,
    TorsionSpring,
    Weld,
)
from mbs_ref.settings import Settings
from mbs_ref.traits import joint_ends
from mbs_ref.trajectory import Status, Timing, Trajectory

INTEGRATORS = {
    "rk4": (mujoco.mjtIntegrator.mjINT_RK4, 4, "explicit Runge-Kutta 4"),
    "euler": (mujoco.mjtIntegrator.mjINT_EULER, 1, "semi-implicit Euler, joint damping implicit"),
    "implicit": (mujoco.mjtIntegrator.mjINT_IMPLICIT, 1, "implicit in velocity, with Coriolis terms"),
    "implicitfast": (mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 1, "implicit in velocity, without Coriolis terms"),
}
LADDER = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
DEFAULT_SOLREF = (0.02, 1.0)  # s, damping ratio: MuJoCo's default, pinned
TIGHT = "_tight"
STOCK = "_stock_contact"
# solimp with the least impedance MuJoCo allows: F = m_eff (K d + B d' + impedance * a), a the acceleration without it
PENALTY_SOLIMP = (1e-4, 1e-4, 0.001, 0.5, 2.0)
STOCK_SOLREF, STOCK_SOLIMP = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's defaults, pinned
# How much is lost depends on which joints close the loops: A02 loses 1.4 J over this tree, 7.1 J over a serial one.
SOFT = "loop closures are springs of 0.02 s time constant whatever the step: the energy of a loop is lost at every step"
STEP_SOFT = "loop closures are springs whose time constant is two steps"
Z = (0.0, 0.0, 1.0)
WORLD = "world"


def _methods() -> tuple[Method, ...]:
    plain = [Method(n, "fixed", p, text, LADDER, wrong_limit=SOFT) for n, (_, p, text) in INTEGRATORS.items()]
    tight = [
        Method(m.name + TIGHT, "fixed", None, f"{m.description}; {STEP_SOFT}", LADDER)
        for m in plain
        if m.name in ("rk4", "implicitfast")
    ]
    stock = Method("rk4" + STOCK, "fixed", None, "explicit Runge-Kutta 4; MuJoCo's default contacts", LADDER,
                   wrong_limit="contacts have MuJoCo's default stiffness and damping, not the scene's")  # fmt: skip
    return (*plain, *tight, stock)


METHODS = _methods()


class MuJoCo(Engine):
    """MuJoCo through MjSpec, every option pinned, the loop in C."""

    name: ClassVar[str] = "mujoco"
    package: ClassVar[str] = "mujoco"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
        | {"force", "torque", "spring_damper", "torsion_spring"}
        | {"spatial", "spherical", "cylindrical"}
        | {"circle_on_line", "circle_on_circle", "spring_damper_law"}
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return mujoco.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if scene.dimension == 3:
            return _spatial_refusals(scene)
        return _part_refusals(scene) + _closure_refusals(scene) + _contact_refusals(scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name.endswith(TIGHT) and not reasons and not _closures(scene):
            reasons.append(Refusal(f"{method.name} differs only where a joint closes a loop, and none does", True))
        if method.name.endswith(STOCK) and not scene.contacts:
            reasons.append(Refusal(f"{method.name} differs only in contact, and there is none", True))
        return reasons

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        start = perf_counter()
        tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
        model = _compile(tree, plan) if isinstance(tree, JointTree) else _compile_spatial(tree, plan)
        data = _at_start(model, tree)
        built = perf_counter()
        _advance(model, _at_start(model, tree), plan, 1)
        called = perf_counter()
        states, end = _advance(model, data, plan, len(plan.times))
        looped = perf_counter()
        steps = sum(plan.counts[: max(0, end.samples - 1)])
        stages = 4 if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        if isinstance(tree, SpatialTree):
            poses, reactions = _observe_spatial(model, tree, states[: end.samples]), {}
        else:
            poses, wrench = _observe(model, tree, states[: end.samples])
            known = settings.reactions and not scene.loads and not scene.contacts
            reactions = tree_reactions(tree, poses, wrench) if known else {}  # cfrc_int leaves out tendons, actuators
        return trajectory(
            plan,
            poses,
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=steps * stages,
            reactions=reactions,
        )


ENGINE = MuJoCo


# --- what cannot be modelled -----------------------------------------------------------------------


def _part_refusals(scene: Scene) -> list[Refusal]:
    reasons = []
    for load in scene.loads:
        if isinstance(load, Force | Torque) and constant_value(load.factor) is None:
            reasons.append(f"load {load.name!r} varies in time, which mujoco is not yet taught")
        if isinstance(load, SpringDamper) and load.tension_only and load.damping:
            reasons.append(f"load {load.name!r}: a mujoco tendon damps while slack, so tension_only allows no damping")
    return [Refusal(reason, permanent=False) for reason in reasons]


def _closure_refusals(scene: Scene) -> list[Refusal]:
    return [
        Refusal(f"joint {joint.name!r} closes a loop by a slide, which mujoco is not yet taught", permanent=False)
        for joint in joint_tree(scene).closures
        if isinstance(joint, Prismatic)
    ]


def _closures(scene: Scene) -> tuple:
    return tuple((joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)).closures)


SPATIAL_PARTS = (Spherical, Revolute, Prismatic, Cylindrical, Weld, Distance, SpringDamper)


def _spatial_refusals(scene: Scene) -> list[Refusal]:
    parts = [part for part in (*scene.joints, *scene.loads) if not isinstance(part, SPATIAL_PARTS)]
    reasons = [f"{part.name!r}: mujoco is not yet taught {part.type} in space" for part in parts]
    slides = [j for j in spatial_tree(scene).closures if isinstance(j, Prismatic | Cylindrical)]
    reasons += [f"joint {joint.name!r} closes a loop by a slide, which mujoco is not yet taught" for joint in slides]
    return [Refusal(reason, permanent=False) for reason in reasons] + _part_refusals(scene)


# --- the model -------------------------------------------------------------------------------------


def _compile(tree: JointTree, plan: Plan) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    _pin_options(spec, plan, tree.scene)
    frames = {FIXED: spec.worldbody}
    for edge in tree.edges:
        frames[edge.body] = _add_body(frames[edge.parent], edge, tree)
    for joint in tree.closures:
        _add_closure(spec, frames, tree, joint, _solref(plan))
    for load in tree.scene.loads:
        LOADS[type(load)](spec, frames, tree, load)
    for contact in tree.scene.contacts:
        _add_contact(spec, frames, tree, contact, plan.method.name.endswith(STOCK))
    return spec.compile()


def _pin_options(spec: mujoco.MjSpec, plan: Plan, scene: Scene) -> None:
    """Leave no option to a default that a release may change."""
    option = spec.option
    option.timestep = plan.step
    option.integrator = INTEGRATORS[plan.method.name.removesuffix(TIGHT).removesuffix(STOCK)][0]
    option.gravity = tuple(np.resize((*scene.gravity, 0.0), 3))
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.tolerance, option.iterations, option.ls_tolerance, option.ls_iterations = 1e-15, 200, 0.01, 50
    option.noslip_iterations, option.impratio = 0, 1.0
    option.cone, option.jacobian = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtJacobian.mjJAC_DENSE
    option.wind, option.density, option.viscosity = (0.0, 0.0, 0.0), 0.0, 0.0
    flags = mujoco.mjtDisableBit
    # without warm starts a run repeats bit for bit
    option.disableflags = int(flags.mjDSBL_WARMSTART) | (0 if scene.contacts else int(flags.mjDSBL_CONTACT))
    # without it the effective mass of a jointed body is guessed, and was seen wrong by 7.5x
    option.enableflags = int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT) if scene.contacts else 0
    spec.compiler.autolimits = False


def _solref(plan: Plan) -> tuple[float, float]:
    return (2.0 * plan.step, 1.0) if plan.method.name.endswith(TIGHT) else DEFAULT_SOLREF


def _add_body(parent: mujoco.MjsBody, edge: Edge, tree: JointTree) -> mujoco.MjsBody:
    """Place the frame at the centre of mass so that zero coordinates are the poses at t = 0."""
    body = tree.scene.bodies[edge.body]
    offset = local(tree, edge.parent, tree.position[edge.body] - tree.position[edge.parent])
    turn = tree.angle[edge.body] - tree.angle[edge.parent]
    frame = parent.add_body(name=body.name, pos=(*offset, 0.0), quat=(np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)))
    # only the z axis turns; equal moments satisfy the triangle inequality MuJoCo checks
    inertia = body.inertia if isinstance(body, PlanarBody) else _particle_inertia(edge)
    frame.explicitinertial = True
    frame.mass, frame.inertia, frame.ipos = body.mass, (inertia,) * 3, (0.0, 0.0, 0.0)
    _add_joints(frame, edge, tree)
    return frame


def _particle_inertia(edge: Edge) -> float:
    """A sliding particle never turns, so any inertia will do; on a rod MuJoCo's floor stands for none."""
    return {"weld": 0.0, "revolute": 2.0 * mujoco.mjMINVAL}.get(edge.kind, 1.0)


def _add_joints(frame: mujoco.MjsBody, edge: Edge, tree: JointTree) -> None:
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    axes = {
        "prismatic": [edge.axis],
        "free": [np.array([1.0, 0.0]), np.array([0.0, 1.0])],
        "free_point": [np.array([1.0, 0.0]), np.array([0.0, 1.0])],
    }.get(edge.kind, [])
    for k, axis in enumerate(axes):
        frame.add_joint(name=f"{frame.name}/slide{k}", type=slide, axis=(*local(tree, edge.body, axis), 0.0))
    if edge.kind in ("revolute", "free"):
        point = local(tree, edge.body, edge.point - tree.position[edge.body])
        frame.add_joint(name=_hinge(frame.name), type=hinge, axis=Z, pos=(*point, 0.0))


def _hinge(body: str) -> str:
    return f"{body}/hinge"


def _anchor(tree: JointTree, name: str, point) -> tuple[float, float, float]:
    """Return a world point at t = 0 in a body's frame."""
    k = tree.scene.body_index(name)
    return (*local(tree, k, np.array(point) - tree.position[k]), 0.0)


def _site(spec, frames, tree: JointTree, name: str, point, label: str, turned_to_world: bool = False) -> str:
    k = tree.scene.body_index(name)
    turn = -tree.angle[k] if turned_to_world else 0.0
    quat = (np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2))
    frames[k].add_site(name=label, pos=_anchor(tree, name, point), quat=quat)
    return label


def _world_name(name: str) -> str:
    return WORLD if name == "ground" else name


def _add_closure(spec, frames, tree: JointTree, joint, solref: tuple[float, float]) -> None:
    if isinstance(joint, Distance):
        tendon = _tendon(spec, frames, tree, joint)
        initial = float(np.hypot(*np.subtract(joint.point_b, joint.point_a)))
        row = spec.add_equality(name=joint.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)
        row.data[0] = 0.0 if joint.length is None else joint.length - initial
    else:
        kind = {Revolute: mujoco.mjtEq.mjEQ_CONNECT, Weld: mujoco.mjtEq.mjEQ_WELD}[type(joint)]
        row = spec.add_equality(name=joint.name, type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
        # the anchor of a connect is in body 1, of a weld in body 2
        first, second = (joint.body_a, joint.body_b) if isinstance(joint, Revolute) else (joint.body_b, joint.body_a)
        row.name1, row.name2 = _world_name(first), _world_name(second)
        row.data[0:3] = _anchor(tree, joint.body_a, joint.point)
        if isinstance(joint, Weld):
            row.data[10] = 1.0  # m/rad, torque scale
    row.active, row.solref = True, solref


def _tendon(spec, frames, tree: JointTree, part):
    tendon = spec.add_tendon(name=part.name)
    for end, (body, point) in enumerate(((part.body_a, part.point_a), (part.body_b, part.point_b))):
        tendon.wrap_site(_site(spec, frames, tree, body, point, f"{part.name}/{end}"))
    return tendon


def _add_spring(spec, frames, tree: JointTree, load: SpringDamper) -> None:
    tendon = _tendon(spec, frames, tree, load)
    initial = float(np.hypot(*np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    tendon.stiffness, tendon.damping = _linear(load.stiffness), _linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)


def _linear(coefficient: float) -> np.ndarray:
    """Return a linear law in the shape of the specification's polynomial coefficients."""
    return np.array([coefficient, 0.0, 0.0])


def _add_torsion(spec, frames, tree: JointTree, load: TorsionSpring) -> None:
    """The relative angle is a sum of hinge angles: a fixed tendon over the tree's path."""
    tendon = spec.add_tendon(name=load.name)
    weights: dict[str, float] = {}
    for name, sign in ((load.body_b, 1.0), (load.body_a, -1.0)):
        for edge in tree.path(tree.scene.body_index(name)):
            if edge.kind in ("revolute", "free"):
                label = _hinge(tree.scene.body_names[edge.body])
                weights[label] = weights.get(label, 0.0) + sign
    for label, weight in weights.items():
        if weight:
            tendon.wrap_joint(label, weight)
    tendon.stiffness, tendon.damping, tendon.springlength = _linear(load.stiffness), _linear(load.damping), (0.0, 0.0)
    a, b = (tree.scene.body_index(name) for name in (load.body_a, load.body_b))
    initial = tree.angle[b] - tree.angle[a]
    rest = initial if load.rest_angle is None else load.rest_angle
    if rest != initial:
        _motor(spec, load.name, mujoco.mjtTrn.mjTRN_TENDON, load.name, load.stiffness * (rest - initial))


def _motor(spec, name: str, transmission, target: str, force: float, refsite: str = "", gear=(1.0, 0, 0, 0, 0, 0)):
    """A constant force: the actuator's bias alone, so that no control input is needed."""
    motor = spec.add_actuator(name=name, trntype=transmission, target=target, gear=gear)
    if refsite:
        motor.refsite = refsite
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    motor.gainprm[0] = 0.0
    motor.biasprm[0] = force


def _add_force(spec, frames, tree: JointTree, load: Force) -> None:
    scale = constant_value(load.factor) or 0.0
    in_body = load.frame == "body"
    site = _site(spec, frames, tree, load.body, load.point, load.name, turned_to_world=True)
    reference = "" if in_body else _site(spec, frames, tree, "ground", load.point, f"{load.name}/world")
    gear = (*(scale * c for c in load.vector), 0.0, 0.0, 0.0, 0.0)
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, site, 1.0, reference, gear)


def _add_torque(spec, frames, tree: JointTree, load: Torque) -> None:
    point = tree.position[tree.scene.body_index(load.body)]
    site = _site(spec, frames, tree, load.body, point, load.name)
    gear = (0.0, 0.0, 0.0, 0.0, 0.0, load.torque * (constant_value(load.factor) or 0.0))
    _motor(spec, load.name, mujoco.mjtTrn.mjTRN_SITE, site, 1.0, "", gear)


LOADS = {Force: _add_force, Torque: _add_torque, SpringDamper: _add_spring, TorsionSpring: _add_torsion}


def _add_contact(spec, frames, tree: JointTree, contact, stock: bool) -> None:
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
    frame.add_geom(name=label, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, pos=_anchor(tree, body, center), mass=0.0,
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


def _contact_refusals(scene: Scene) -> list[Refusal]:
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


# --- space -----------------------------------------------------------------------------------------


def _compile_spatial(tree: SpatialTree, plan: Plan) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    _pin_options(spec, plan, tree.scene)
    frames = {FIXED: spec.worldbody}
    for edge in tree.edges:
        frames[edge.body] = _add_spatial_body(frames[edge.parent], edge, tree)
    for joint in tree.closures:
        _add_spatial_closure(spec, frames, tree, joint, _solref(plan))
    for load in tree.scene.loads:
        assert isinstance(load, SpringDamper)  # every other load is refused before
        _add_spatial_spring(spec, frames, tree, load)
    return spec.compile()


def _add_spatial_body(parent: mujoco.MjsBody, edge: SpatialEdge, tree: SpatialTree) -> mujoco.MjsBody:
    """The frame sits at the centre of mass along the body's axes."""
    body = tree.scene.bodies[edge.body]
    place, theta = tree.seen_from(edge.parent, edge.body)
    frame = parent.add_body(name=body.name, pos=place, quat=theta)
    frame.explicitinertial, frame.mass, frame.ipos = True, body.mass, (0.0, 0.0, 0.0)
    if isinstance(body, SpatialBody):
        frame.fullinertia = body.inertia
    else:
        frame.inertia = (1.0,) * 3  # a particle that only slides never turns
    kinds = mujoco.mjtJoint
    joint = edge.joint
    pos = tree.local(edge.body, joint.point) if joint is not None else np.zeros(3)
    turns = joint is not None and getattr(joint, "axis", None) is not None
    axis = tree.axes(edge.body).T @ joint.axis if turns else np.zeros(3)  # pyright: ignore[reportOptionalMemberAccess]
    for kind in _kinds(edge, body):
        for k, direction in enumerate(np.eye(3) if kind == "slides" else [axis]):
            code = {"slides": kinds.mjJNT_SLIDE, "slide": kinds.mjJNT_SLIDE, "hinge": kinds.mjJNT_HINGE,
                    "ball": kinds.mjJNT_BALL, "free": kinds.mjJNT_FREE}[kind]  # fmt: skip
            options = {} if kind == "free" else {"pos": pos}
            options |= {"axis": direction} if kind in ("slides", "slide", "hinge") else {}
            frame.add_joint(name=f"{body.name}/{kind}{k}", type=code, **options)
    return frame


def _kinds(edge: SpatialEdge, body) -> tuple[str, ...]:
    """Return MuJoCo's joints that an edge is made of."""
    if edge.joint is None:
        return ("free",) if isinstance(body, SpatialBody) else ("slides",)
    by_type = {"spherical": ("ball",), "revolute": ("hinge",), "prismatic": ("slide",), "weld": ()}
    return by_type.get(edge.joint.type, ("slide", "hinge"))


def _depth_first(tree: SpatialTree) -> list[SpatialEdge]:
    """MuJoCo numbers bodies depth first, children in the order they were added."""
    children: dict[int, list[SpatialEdge]] = {}
    for edge in tree.edges:
        children.setdefault(edge.parent, []).append(edge)
    result: list[SpatialEdge] = []
    stack = children.get(FIXED, [])[::-1]
    while stack:
        edge = stack.pop()
        result.append(edge)
        stack += children.get(edge.body, [])[::-1]
    return result


def _start_rates(tree: SpatialTree, edge: SpatialEdge) -> np.ndarray:
    body, joint = tree.scene.bodies[edge.body], edge.joint
    to_body = tree.axes(edge.body).T
    point = joint.point if joint is not None else body.position
    sliding = tree.velocity(edge.body, point) - tree.velocity(edge.parent, point)
    turning = tree.relative_spin(edge)
    axis = np.asarray(getattr(joint, "axis", None) or (0.0, 0.0, 0.0))
    axis = axis / (np.linalg.norm(axis) or 1.0)
    rates = {
        "free": np.concatenate((sliding, to_body @ turning)), "slides": sliding, "ball": to_body @ turning,
        "slide": np.array([axis @ sliding]), "hinge": np.array([axis @ turning]),
    }  # fmt: skip
    return np.concatenate([rates[kind] for kind in _kinds(edge, body)] or [np.zeros(0)])


def _add_spatial_closure(spec, frames, tree: SpatialTree, joint, solref: tuple[float, float]) -> None:
    if isinstance(joint, Distance):
        tendon = _spatial_tendon(spec, frames, tree, joint)
        initial = float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
        row = spec.add_equality(name=joint.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)
        row.data[0] = 0.0 if joint.length is None else joint.length - initial
        row.active, row.solref = True, solref
        return
    weld = isinstance(joint, Weld)
    points = [np.array(joint.point, dtype=float)]
    if isinstance(joint, Revolute) and joint.axis is not None:  # a hinge is two shared points on its axis
        axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
        points = [points[0] - 0.5 * axis, points[0] + 0.5 * axis]
    first, second = (joint.body_b, joint.body_a) if weld else (joint.body_a, joint.body_b)
    for k, point in enumerate(points):
        kind = mujoco.mjtEq.mjEQ_WELD if weld else mujoco.mjtEq.mjEQ_CONNECT
        row = spec.add_equality(name=f"{joint.name}/{k}", type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
        row.name1, row.name2 = _world_name(first), _world_name(second)
        row.data[0:3] = tree.local(tree.scene.body_index(joint.body_a), point)
        if weld:
            row.data[10] = 1.0  # m/rad, torque scale
        row.active, row.solref = True, solref


def _spatial_tendon(spec, frames, tree: SpatialTree, part):
    tendon = spec.add_tendon(name=part.name)
    for end, (body, point) in enumerate(((part.body_a, part.point_a), (part.body_b, part.point_b))):
        k = tree.scene.body_index(body)
        frames[k].add_site(name=f"{part.name}/{end}", pos=tree.local(k, point))
        tendon.wrap_site(f"{part.name}/{end}")
    return tendon


def _add_spatial_spring(spec, frames, tree: SpatialTree, load: SpringDamper) -> None:
    tendon = _spatial_tendon(spec, frames, tree, load)
    initial = float(np.linalg.norm(np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    tendon.stiffness, tendon.damping = _linear(load.stiffness), _linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)


def _observe_spatial(model: mujoco.MjModel, tree: SpatialTree, states: np.ndarray):
    """Return MuJoCo's own poses."""
    n = len(tree.scene.bodies)
    position, velocity, omega = np.zeros((3, len(states), n, 3))
    theta = np.zeros((len(states), n, 4))
    data = mujoco.MjData(model)
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    for k, state in enumerate(states):
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq :]
        mujoco.mj_forward(model, data)
        arm = data.xipos[index] - data.subtree_com[model.body_rootid[index]]  # cvel is about that point
        position[k], theta[k], omega[k] = data.xipos[index], data.xquat[index], data.cvel[index, :3]
        velocity[k] = data.cvel[index, 3:] + np.cross(data.cvel[index, :3], arm)
    return position, theta, velocity, omega


# --- the run ---------------------------------------------------------------------------------------


def _at_start(model: mujoco.MjModel, tree: JointTree | SpatialTree) -> mujoco.MjData:
    data = mujoco.MjData(model)
    if isinstance(tree, SpatialTree):  # the reference configuration is the start
        data.qvel[:] = np.concatenate([_start_rates(tree, edge) for edge in _depth_first(tree)])
        return data
    data.qpos[:], data.qvel[:] = 0.0, tree.rates()
    return data


def _advance(model: mujoco.MjModel, data: mujoco.MjData, plan: Plan, samples: int) -> tuple[np.ndarray, End]:
    """Step through the output times; each interval is one call into C."""
    states = np.zeros((len(plan.times), model.nq + model.nv))
    states[0] = np.concatenate((data.qpos, data.qvel))
    if samples == 1:  # a first call: one step
        mujoco.mj_step(model, data)
        return states, End(1)
    for k, count in enumerate(plan.counts, start=1):
        mujoco.mj_step(model, data, nstep=count)
        states[k, : model.nq], states[k, model.nq :] = data.qpos, data.qvel
        trouble = _trouble(data, plan.times[k], plan.step)
        if trouble:
            return states, end_of(states, plan.times, End(k, Status.RESET, trouble))
    return states, end_of(states, plan.times, End(len(plan.times)))


def _trouble(data: mujoco.MjData, time: float, step: float) -> str:
    """Return a sentence if MuJoCo warned or restarted: it goes on from t = 0 without an exception."""
    counts = {mujoco.mjtWarning(k).name: int(w.number) for k, w in enumerate(data.warning) if w.number}
    late = abs(data.time - time) > 0.5 * step
    if not counts and not late:
        return ""
    warned = f", with the warnings {counts}" if counts else ""
    return f"mujoco reset its state before t = {time:g} s and reports t = {data.time:g} s{warned}"


def _observe(model: mujoco.MjModel, tree: JointTree, states: np.ndarray):
    """Return MuJoCo's own poses and the wrenches from parents; angles add up along the tree, beyond one turn."""
    n = len(tree.scene.bodies)
    position, velocity = np.zeros((2, len(states), n, 2))
    wrench = np.zeros((len(states), n, 3))
    data = mujoco.MjData(model)
    index = np.array([model.body(name).id for name in tree.scene.body_names])
    for k, state in enumerate(states):
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq :]
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        reference = data.subtree_com[model.body_rootid[index]]  # of both cvel and cfrc_int
        arm = data.xipos[index] - reference
        position[k] = data.xipos[index, :2]
        velocity[k] = (data.cvel[index, 3:] + np.cross(data.cvel[index, :3], arm))[:, :2]
        moment = data.cfrc_int[index, :3] + np.cross(reference, data.cfrc_int[index, 3:])
        wrench[k] = np.column_stack((data.cfrc_int[index, 3:5], moment[:, 2]))
    _, angle, _, rate = tree.poses(states[:, : model.nq], states[:, model.nq :])
    return (position, angle, velocity, rate), wrench
