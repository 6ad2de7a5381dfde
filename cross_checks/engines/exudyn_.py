"""Exudyn: redundant coordinates with implicit methods, or minimal coordinates (KinematicTree) with explicit ones."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from math import gcd
from time import perf_counter
from typing import Any, ClassVar

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np
from exudyn.exudynCPP import SolverError

from cross_checks.applied import CLIPPED_CONTACTS, AppliedForces, contact_refusals
from cross_checks.engine import Engine, Method, Refusal
from cross_checks.joint_tree import FIXED, JointTree, joint_tree
from cross_checks.outcome import End, Plan, end_of, plan_run, trajectory
from cross_checks.prescribed import constant_value, displacement, factor
from mbs_ref.contact import CircleOnCircle, CircleOnLine, SpringDamperLaw
from mbs_ref.euler_parameters import from_matrix, parameter_matrix, rotation_matrices
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import (
    GROUND,
    CoordinateDrive,
    Cylindrical,
    Distance,
    Force,
    PlanarBody,
    PointBushing,
    Prismatic,
    Revolute,
    Scene,
    SpatialBody,
    Spherical,
    SpringDamper,
    Torque,
    TorqueVector,
    TorsionSpring,
    Weld,
)
from mbs_ref.settings import Settings
from mbs_ref.spatial_rows import normals
from mbs_ref.traits import traits
from mbs_ref.trajectory import Status, Timing, Trajectory

ORIGIN = (0.0, 0.0)
SPECTRAL_RADIUS = 0.9  # of generalized-alpha at infinite frequency: Exudyn's default, pinned
# tighter, Newton stops at singular poses (generalized-alpha at 1e-10); looser, the order is lost below 1e-8 m
NEWTON = {"relativeTolerance": 1e-9, "absoluteTolerance": 1e-9, "maxIterations": 25}
SMALLEST_STEP = 1e-13  # s, adaptive methods
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
SHARED = "loads and contacts come from the shared force code, called through Python"
TREE = "tree_"
CONTACT = "contact_rk44"
REACH = 100.0  # m, how far floors and the search for contact extend
SINGULAR = "stops at singular poses, or leaves them on another branch and reports success"

SOLVERS = {
    "generalized_alpha": exu.DynamicSolverType.GeneralizedAlpha,
    "rotation_vector": exu.DynamicSolverType.GeneralizedAlpha,
    "trapezoidal": exu.DynamicSolverType.TrapezoidalIndex2,
    "contact_rk44": exu.DynamicSolverType.RK44,
    "tree_dopri5": exu.DynamicSolverType.DOPRI5,
    "tree_rk44": exu.DynamicSolverType.RK44,
    "tree_rk67": exu.DynamicSolverType.RK67,
    "tree_euler": exu.DynamicSolverType.ExplicitEuler,
}
PLANAR, SPATIAL = frozenset({"planar"}), frozenset({"spatial"})
# right-hand sides a step
STAGES = {"contact_rk44": 4, "tree_rk44": 4, "tree_rk67": 9, "tree_euler": 1, "tree_dopri5": 7}
METHODS = (
    Method("generalized_alpha", "fixed", 2, "generalized-alpha, index 3, redundant coordinates", STEPS),
    Method("trapezoidal", "fixed", 2, "trapezoidal rule, index 2, redundant coordinates", STEPS, wrong_limit=SINGULAR),
    Method("rotation_vector", "fixed", 2, "generalized-alpha on rotation vectors (Lie group)", STEPS, requires=SPATIAL),
    Method("contact_rk44", "fixed", None, "Runge-Kutta 4 with GeneralContact; bodies without joints", STEPS,
           requires=frozenset({"contact"})),
    Method("tree_dopri5", "adaptive", 5, "KinematicTree, Dormand-Prince 5", RTOLS, requires=PLANAR),
    Method("tree_rk44", "fixed", 4, "KinematicTree, Runge-Kutta 4", STEPS, requires=PLANAR),
    Method("tree_rk67", "fixed", 6, "KinematicTree, Runge-Kutta 6 of 7 stages", STEPS, requires=PLANAR),
    Method("tree_euler", "fixed", 1, "KinematicTree, explicit Euler", STEPS, requires=PLANAR),
)


class Exudyn(Engine):
    """Exudyn through its item interface; adaptive halving of the step is always off for fixed steps."""

    name: ClassVar[str] = "exudyn"
    package: ClassVar[str] = "exudyn"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance", "coordinate_drive"}
        | {"force", "torque", "spring_damper", "torsion_spring"}
        | {"spatial", "spherical", "cylindrical", "torque_vector"}
        | {"point_bushing"}
        | CLIPPED_CONTACTS
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return exu.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        """In space some parts of the plane are not yet taught."""
        if scene.dimension == 2:
            return []
        parts = [*scene.joints, *scene.loads]
        untaught = [part for part in parts if type(part) not in SPATIAL_PARTS]
        return [Refusal(f"{p.name!r}: exudyn is not yet taught {p.type} in space", permanent=False) for p in untaught]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if scene.contacts and method.name == CONTACT:
            reasons += _contact_refusals(scene)
        elif method.name == CONTACT:
            reasons += [Refusal("loads are not taught", False)] if scene.loads else []
        reasons += contact_refusals(scene)
        if method.name.startswith(TREE) and scene.dimension == 2:
            reasons += _tree_refusals(scene)
        return reasons

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        exu.config.printToConsole = False
        start = perf_counter()
        model = _build(scene, plan.method.name)
        model.mbs.Assemble()
        options = _options(plan, scene)
        built = perf_counter()
        _first_call(model, plan, options)
        called = perf_counter()
        advance = _advance_fixed if plan.method.kind == "fixed" else _advance_adaptive
        rows, end, steps = advance(model, plan, options, settings.max_steps)
        looped = perf_counter()
        end = end_of(rows, plan.times, end)
        return trajectory(
            plan,
            model.poses(rows),
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=steps * STAGES.get(plan.method.name, 1),
            reactions=model.reactions(rows) if settings.reactions else {},
            notes=model.notes,
        )


ENGINE = Exudyn


def _build(scene: Scene, method: str):
    if scene.dimension == 3:
        return _build_spatial(scene, method)
    return _build_tree(scene) if method.startswith(TREE) else _build_redundant(scene, method)


def _tree_refusals(scene: Scene) -> list[Refusal]:
    tree = joint_tree(scene)
    reasons = [Refusal(f"joint {j.name!r} closes a loop, which a KinematicTree cannot", True) for j in tree.closures]
    for joint in scene.joints:
        inner_weld = isinstance(joint, Weld) and GROUND not in (joint.body_a, joint.body_b)
        if inner_weld or isinstance(joint, CoordinateDrive):
            reasons.append(Refusal(f"joint {joint.name!r}: a KinematicTree is not yet taught {joint.type}", False))
    return reasons


# --- redundant coordinates -------------------------------------------------------------------------


@dataclass
class Redundant:
    """An Exudyn system with a node for each body."""

    scene: Scene
    container: Any  # keeps the system alive
    mbs: Any
    nodes: list[int] = field(default_factory=list)
    bodies: dict[int, int] = field(default_factory=dict)  # scene body -> Exudyn object
    sensors: list[int] = field(default_factory=list)
    widths: list[int] = field(default_factory=list)  # numbers a sensor gives
    forces: dict[str, int] = field(default_factory=dict)  # joint -> first column of its recorded force
    notes: tuple[str, ...] = ()

    def poses(self, rows: np.ndarray):
        n = len(self.scene.bodies)
        position, velocity = np.zeros((2, len(rows), n, 2))
        angle, rate = np.zeros((2, len(rows), n))
        column = 0
        for k, body in enumerate(self.scene.bodies):
            width = 3 if isinstance(body, PlanarBody) else 2
            q, v = rows[:, column : column + width], rows[:, column + width : column + 2 * width]
            position[:, k], velocity[:, k] = body.position + q[:, :2], v[:, :2]
            if isinstance(body, PlanarBody):
                angle[:, k], rate[:, k] = body.angle + q[:, 2], v[:, 2]
            column += 2 * width
        return position, angle, velocity, rate

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return force on body b and torque about its mark; Exudyn gives the force on body a, or a rod's tension."""
        motion = Motion(self.scene, Trajectory(np.zeros(len(rows)), *self.poses(rows)))
        result = {}
        for joint in self.scene.joints:
            column = self.forces.get(joint.name)
            if column is None:
                continue
            force = np.zeros((len(rows), 3))
            if isinstance(joint, Distance):
                force[:, :2] = -rows[:, column : column + 1] * _along(motion, joint)
            else:
                force[:, :2] = -rows[:, column : column + 2]
            result[joint.name] = force
        return result

    def watch(self, sensor: Any, width: int) -> None:
        self.sensors.append(self.mbs.AddSensor(sensor))
        self.widths.append(width)

    def marker(self, body: str, point, rigid: bool = False) -> int:
        """Return a marker at a world point (t = 0) of a body or of ground."""
        k = self.scene.body_index(body)
        where = np.array(point)
        if k != FIXED:
            owner = self.scene.bodies[k]
            where = _in_body(getattr(owner, "angle", 0.0), where - np.array(owner.position))
        kind = item.MarkerBodyRigid if rigid else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[k], localPosition=[*where, 0.0]))

    def coordinate(self, body: str, coordinate: int) -> int:
        """Return a marker of a body's coordinate, or of a ground coordinate that stays 0."""
        k = self.scene.body_index(body)
        node = self.nodes[k] if k != FIXED else self.mbs.AddNode(item.NodePointGround())
        number = coordinate if k != FIXED else 0
        return self.mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))


def _along(motion: Motion, rod: Distance) -> np.ndarray:
    """Return the unit vectors (n_t, 2) from point a to point b."""
    between = motion.point(rod.body_b, rod.point_b)[0] - motion.point(rod.body_a, rod.point_a)[0]
    return between / np.linalg.norm(between, axis=1, keepdims=True)


def _in_body(angle: float, r: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * r[0] + s * r[1], c * r[1] - s * r[0]])


def _build_redundant(scene: Scene, method: str) -> Redundant:
    container = exu.SystemContainer()
    model = Redundant(scene, container, container.AddSystem())
    model.bodies[FIXED] = model.mbs.AddObject(item.ObjectGround())
    for k, body in enumerate(scene.bodies):
        _add_body(model, k, body)
    for joint in scene.joints:
        JOINTS[type(joint)](model, joint)
    if method != CONTACT and (scene.contacts or any(isinstance(load, PointBushing) for load in scene.loads)):
        _add_shared_forces(model)
        return model
    for load in scene.loads:
        LOADS[type(load)](model, load)
    if scene.contacts:
        _add_contacts(model)
    return model


def _add_body(model: Redundant, k: int, body) -> None:
    planar = isinstance(body, PlanarBody)
    q = [*body.position, body.angle] if planar else list(body.position)
    v = [*body.velocity, body.angular_velocity] if planar else list(body.velocity)
    node_type = item.NodeRigidBody2D if planar else item.NodePoint2D
    node = model.mbs.AddNode(node_type(referenceCoordinates=q, initialVelocities=v))
    inertia = {"inertia": body.inertia} if planar else {}
    body_type = item.ObjectRigidBody2D if planar else item.ObjectMassPoint2D
    model.nodes.append(node)
    model.bodies[k] = model.mbs.AddObject(body_type(mass=body.mass, nodeNumber=node, **inertia))
    marker = model.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=model.bodies[k]))
    model.mbs.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=[*model.scene.gravity, 0.0]))
    for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t):
        model.watch(_node_sensor(node, kind), len(q))


def _node_sensor(node: int, kind: Any):
    return item.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kind)


def _pin(model: Redundant, joint: Revolute | Weld) -> int:
    markers = [model.marker(body, joint.point) for body in (joint.body_a, joint.body_b)]
    return model.mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=markers))


def _add_revolute(model: Redundant, joint: Revolute) -> None:
    _watch_force(model, joint.name, _pin(model, joint), 3)


def _watch_force(model: Redundant, joint: str, number: int, width: int) -> None:
    kind = exu.OutputVariableType.Force
    sensor = item.SensorObject(objectNumber=number, storeInternal=True, writeToFile=False, outputVariableType=kind)
    model.forces[joint] = sum(model.widths)
    model.watch(sensor, width)


def _add_weld(model: Redundant, joint: Weld) -> None:
    _pin(model, joint)
    _lock_angle(model, joint)


def _lock_angle(model: Redundant, joint: Weld) -> None:
    """Lock the relative angle; a particle has none."""
    bodies = [model.scene.body_index(name) for name in (joint.body_a, joint.body_b)]
    if all(k == FIXED or isinstance(model.scene.bodies[k], PlanarBody) for k in bodies):
        markers = [model.coordinate(body, 2) for body in (joint.body_a, joint.body_b)]
        model.mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=markers))


def _add_prismatic(model: Redundant, joint: Prismatic) -> None:
    markers = [model.marker(body, joint.point, rigid=True) for body in (joint.body_a, joint.body_b)]
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    angles = [
        getattr(model.scene.bodies[k], "angle", 0.0) if k != FIXED else 0.0
        for k in map(model.scene.body_index, (joint.body_a, joint.body_b))
    ]
    along, across = _in_body(angles[0], axis), _in_body(angles[1], np.array([-axis[1], axis[0]]))
    model.mbs.AddObject(
        item.ObjectJointPrismatic2D(markerNumbers=markers, axisMarker0=[*along, 0.0], normalMarker1=[*across, 0.0])
    )


def _add_distance(model: Redundant, joint: Distance) -> None:
    markers = [model.marker(joint.body_a, joint.point_a), model.marker(joint.body_b, joint.point_b)]
    length = joint.length or float(np.hypot(*np.subtract(joint.point_b, joint.point_a)))
    _watch_force(model, joint.name, model.mbs.AddObject(_rod(markers, length)), 1)


def _rod(markers: list[int], length: float):
    return item.ObjectConnectorDistance(markerNumbers=markers, distance=length)


def _add_drive(model: Redundant, joint: CoordinateDrive) -> None:
    coordinate = ("x", "y", "angle").index(joint.coordinate)
    motion = displacement(joint.motion, joint.level)
    markers = [model.coordinate("ground", 0), model.coordinate(joint.body, coordinate)]
    model.mbs.AddObject(
        item.ObjectConnectorCoordinate(
            markerNumbers=markers,
            offsetUserFunction=lambda mbs, t, number, offset: motion.value(t),
            offsetUserFunction_t=lambda mbs, t, number, offset: motion.rate(t),
        )
    )
    model.notes += (f"drive {joint.name!r} calls Python at every residual",)


def _add_force(model: Redundant, load: Force) -> None:
    vector = np.array(load.vector)
    body = model.scene.bodies[model.scene.body_index(load.body)]
    fixed = load.frame == "body" and isinstance(body, PlanarBody)
    if fixed:
        vector = _in_body(body.angle, vector)
    marker = model.marker(load.body, load.point, rigid=fixed)
    _add_load(model, item.LoadForceVector, marker, [*vector, 0.0], load, bodyFixed=fixed)


def _add_torque(model: Redundant, load: Torque) -> None:
    body = model.scene.bodies[model.scene.body_index(load.body)]
    marker = model.marker(load.body, body.position, rigid=True)
    _add_load(model, item.LoadTorqueVector, marker, [0.0, 0.0, load.torque], load)


def _add_load(model: Redundant, kind, marker: int, vector: list[float], load: Force | Torque, **options) -> None:
    constant = constant_value(load.factor)
    if constant is not None:
        model.mbs.AddLoad(kind(markerNumber=marker, loadVector=[constant * c for c in vector], **options))
        return
    signal = factor(load.factor)
    options["loadVectorUserFunction"] = lambda mbs, t, unit: [signal.value(t) * c for c in unit]
    model.mbs.AddLoad(kind(markerNumber=marker, loadVector=vector, **options))
    model.notes += (f"load {load.name!r} calls Python at every residual",)


def _add_spring(model: Redundant, load: SpringDamper) -> None:
    markers = [model.marker(load.body_a, load.point_a), model.marker(load.body_b, load.point_b)]
    initial = float(np.hypot(*np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    law = {"springForceUserFunction": _pull_only} if load.tension_only else {}
    model.mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=markers, referenceLength=rest, stiffness=load.stiffness, damping=load.damping, **law
        )
    )
    if load.tension_only:
        model.notes += (f"load {load.name!r} calls Python at every residual",)


def _pull_only(mbs, t, number, stretch, stretch_rate, stiffness, damping, force) -> float:
    return max(0.0, stiffness * stretch + damping * stretch_rate) if stretch > 0.0 else 0.0


def _add_torsion(model: Redundant, load: TorsionSpring) -> None:
    markers = [model.coordinate(body, 2) for body in (load.body_a, load.body_b)]
    bodies = [model.scene.body_index(name) for name in (load.body_a, load.body_b)]
    angles = [getattr(model.scene.bodies[k], "angle", 0.0) if k != FIXED else 0.0 for k in bodies]
    initial = angles[1] - angles[0]
    rest = initial if load.rest_angle is None else load.rest_angle
    model.mbs.AddObject(
        item.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=markers, stiffness=load.stiffness, damping=load.damping, offset=rest - initial
        )
    )


JOINTS = {
    Revolute: _add_revolute,
    Weld: _add_weld,
    Prismatic: _add_prismatic,
    Distance: _add_distance,
    CoordinateDrive: _add_drive,
}
LOADS = {Force: _add_force, Torque: _add_torque, SpringDamper: _add_spring, TorsionSpring: _add_torsion}


# --- forces of the shared force code ------------------------------------------------------------------


def _add_shared_forces(model: Redundant) -> None:
    """Apply all loads and contacts through one item over all nodes, which calls Python."""
    applied = AppliedForces(joint_tree(model.scene))
    weight = np.outer([body.mass for body in model.scene.bodies], [*model.scene.gravity, 0.0])
    start = np.array([[*body.position, getattr(body, "angle", 0.0)] for body in model.scene.bodies])

    def forces(mbs, t, number, q, v) -> np.ndarray:
        q, v = np.reshape(q, (-1, 3)) + start, np.reshape(v, (-1, 3))
        return (applied.of_poses(t, q, v) - weight).ravel()  # the bodies have their weight already

    size = 3 * len(model.nodes)
    zero = np.zeros((size, size))
    model.mbs.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=model.nodes, massMatrix=zero, stiffnessMatrix=zero, dampingMatrix=zero,
            forceVector=np.zeros(size), forceUserFunction=forces,
        )
    )  # fmt: skip
    model.notes += (SHARED,)


# --- contact ---------------------------------------------------------------------------------------


def _contact_refusals(scene: Scene) -> list[Refusal]:
    reasons = [f"joint {joint.name!r}: Exudyn's explicit solvers take no joint" for joint in scene.joints]
    for contact in scene.contacts:
        where = f"contact {contact.name!r}"
        if not isinstance(contact.law, SpringDamperLaw) or not isinstance(contact, CircleOnLine | CircleOnCircle):
            reasons.append(f"{where}: GeneralContact takes circles with spring_damper_law, not {contact.law.type}")
            continue
        if contact.friction is not None:
            reasons.append(f"{where}: friction is not yet taught to exudyn here")
        rule = "gap" if isinstance(contact, CircleOnLine) else "force"
        if getattr(contact.law, "release", rule) != rule:
            reasons.append(f"{where}: GeneralContact lets go of {contact.type} by release = {rule!r}")
        if isinstance(contact, CircleOnLine) and (contact.body_b != GROUND or contact.extent != "line"):
            reasons.append(f"{where}: only an endless line on ground is taught")
    reasons += _mixed_refusals(scene)
    return [Refusal(reason, permanent=False) for reason in reasons]


def _mixed_refusals(scene: Scene) -> list[str]:
    """GeneralContact gives stiffness to shapes, not to pairs, and lets every pair touch."""
    laws = {repr(contact.law) for contact in scene.contacts}
    shapes = {shape for contact in scene.contacts for shape in _circles(contact)}
    bodies = [body for body, _, _ in shapes]
    reasons = []
    if len(laws) > 1:
        reasons.append("GeneralContact gives laws to shapes, not to pairs: all contacts must share one")
    if len(bodies) != len(set(bodies)):
        reasons.append("a body with two circles would touch with both")
    return reasons


def _circles(contact: CircleOnLine | CircleOnCircle) -> list[tuple[str, tuple[float, ...], float]]:
    if isinstance(contact, CircleOnLine):
        return [(contact.body_a, contact.center, contact.radius)]
    return [(contact.body_a, contact.center_a, contact.radius_a), (contact.body_b, contact.center_b, contact.radius_b)]


def _add_contacts(model: Redundant) -> None:
    """Two shapes in series: each has twice the pair's stiffness and half its damping."""
    contacts = model.scene.contacts
    law: Any = contacts[0].law
    general = model.mbs.AddGeneralContact()
    general.SetFrictionPairings(np.zeros((1, 1)))
    general.verboseMode = 0
    shape = {"contactStiffness": 2.0 * law.stiffness, "contactDamping": 0.5 * law.damping, "frictionMaterialIndex": 0}
    lines = [c for c in contacts if isinstance(c, CircleOnLine)]
    for line in {(c.point_1, c.point_2): c for c in lines}.values():
        _add_plane(model, general, line, shape)
    for body, center, radius in sorted({circle for contact in contacts for circle in _circles(contact)}):
        general.AddSphereWithMarker(markerIndex=model.marker(body, center), radius=radius, **shape)
    general.SetSearchTreeCellSize([1, 1, 1])
    general.SetSearchTreeBox(pMin=[-REACH, -REACH, -REACH], pMax=[REACH, REACH, REACH])


def _add_plane(model: Redundant, general, line: CircleOnLine, shape: dict) -> None:
    """A line as two triangles, wide and deep enough for the scene."""
    along = np.subtract(line.point_2, line.point_1) / np.hypot(*np.subtract(line.point_2, line.point_1))
    ends = [np.array([*(np.array(line.point_1) + s * REACH * along), z]) for s in (-1, 1) for z in (-REACH, REACH)]
    marker = model.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=model.bodies[FIXED], localPosition=[0.0, 0.0, 0.0]))
    general.AddTrianglesRigidBodyBased(
        rigidBodyMarkerIndex=marker, pointList=ends, triangleList=[[0, 1, 3], [0, 3, 2]], **shape
    )


# --- minimal coordinates ---------------------------------------------------------------------------


@dataclass
class Tree:
    """An Exudyn KinematicTree; a free body takes two massless slides and a turn."""

    tree: JointTree
    container: Any
    mbs: Any
    number: int  # of the KinematicTree
    sensors: list[int]
    notes: tuple[str, ...] = ()

    def poses(self, rows: np.ndarray):
        n = self.tree.size
        return self.tree.poses(rows[:, :n], rows[:, n:])

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        return {}


@dataclass
class Links:
    """The lists a KinematicTree is made of."""

    types: list = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    turns: list = field(default_factory=list)
    offsets: list = field(default_factory=list)
    inertias: list = field(default_factory=list)
    centres: list = field(default_factory=list)
    masses: list[float] = field(default_factory=list)

    def add(self, kind, parent: int, turn: float, offset: np.ndarray, body=None, centre=ORIGIN) -> int:
        """Add a link and return its number; without a body it is massless."""
        self.types.append(kind)
        self.parents.append(parent)
        self.turns.append(np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]))
        self.offsets.append([*offset, 0.0])
        self.centres.append([*centre, 0.0])
        self.masses.append(body.mass if body else 0.0)
        inertia = body.inertia if isinstance(body, PlanarBody) else 0.0
        self.inertias.append(inertia * np.eye(3))
        return len(self.types) - 1


def _build_tree(scene: Scene) -> Tree:
    tree = joint_tree(scene)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    zero = [0.0] * tree.size
    node = mbs.AddNode(
        item.NodeGenericODE2(
            referenceCoordinates=zero,
            initialCoordinates=zero,
            initialCoordinates_t=list(tree.rates()),
            numberOfODE2Coordinates=tree.size,
        )
    )
    links = _links(tree)
    options: dict[str, Any] = {"gravity": [*scene.gravity, 0.0]}
    if scene.loads or scene.contacts:
        applied = AppliedForces(tree)
        options = {"forceUserFunction": lambda mbs, t, number, q, v: applied.generalized(t, np.array(q), np.array(v))}
    number = mbs.AddObject(
        item.ObjectKinematicTree(
            nodeNumber=node,
            **options,
            jointTypes=links.types,
            linkParents=links.parents,
            jointTransformations=exu.Matrix3DList(links.turns),
            jointOffsets=exu.Vector3DList(links.offsets),
            linkInertiasCOM=exu.Matrix3DList(links.inertias),
            linkCOMs=exu.Vector3DList(links.centres),
            linkMasses=links.masses,
        )
    )
    kinds = (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    sensors = [mbs.AddSensor(_node_sensor(node, kind)) for kind in kinds]
    return Tree(tree, container, mbs, number, sensors, () if "gravity" in options else (SHARED,))


def _links(tree: JointTree) -> Links:
    """Link frames sit at joint points, parallel to the world at t = 0, but along the axis of a slide."""
    links = Links()
    last: dict[int, int] = {FIXED: -1}
    heading: dict[int, float] = {FIXED: 0.0}
    origin: dict[int, np.ndarray] = {FIXED: np.zeros(2)}
    kinds = exu.JointType
    for edge in tree.edges:
        p, b = edge.parent, edge.body
        body = tree.scene.bodies[b]
        phi = float(np.arctan2(edge.axis[1], edge.axis[0])) if edge.kind == "prismatic" else 0.0
        offset = _in_body(heading[p], edge.point - origin[p])
        centre = _in_body(phi, tree.position[b] - edge.point)
        if edge.kind == "weld":  # to ground: a link of it
            last[b], heading[b], origin[b] = last[p], heading[p], origin[p]
            continue
        chain = {
            "revolute": [kinds.RevoluteZ],
            "prismatic": [kinds.PrismaticX],
            "free_point": [kinds.PrismaticX, kinds.PrismaticY],
            "free": [kinds.PrismaticX, kinds.PrismaticY, kinds.RevoluteZ],
        }[edge.kind]
        parent, turn = last[p], phi - heading[p]
        for kind in chain[:-1]:
            parent, turn, offset = links.add(kind, parent, turn, offset), 0.0, np.zeros(2)
        last[b] = links.add(chain[-1], parent, turn, offset, body, centre)
        heading[b], origin[b] = phi, edge.point
    return links


# --- space -----------------------------------------------------------------------------------------


@dataclass
class Spatial:
    """An Exudyn system of spatial bodies, read through sensors of world positions and rotation matrices."""

    scene: Scene
    container: Any
    mbs: Any
    bodies: dict[int, int] = field(default_factory=dict)  # scene body -> Exudyn object
    sensors: list[int] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def poses(self, rows: np.ndarray):
        n = len(self.scene.bodies)
        position, velocity, omega = np.zeros((3, len(rows), n, 3))
        theta = np.tile([1.0, 0.0, 0.0, 0.0], (len(rows), n, 1))
        column = 0
        for k, body in enumerate(self.scene.bodies):
            position[:, k], velocity[:, k] = rows[:, column : column + 3], rows[:, column + 3 : column + 6]
            column += 6
            if isinstance(body, SpatialBody):
                omega[:, k] = rows[:, column : column + 3]
                turned = rows[:, column + 3 : column + 12].reshape(-1, 3, 3)
                theta[:, k] = [from_matrix(m) if np.isfinite(m).all() else np.full(4, np.nan) for m in turned]
                column += 12
        return position, theta, velocity, omega

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        return {}

    def axes(self, body: str) -> np.ndarray:
        """Return the body's axes (3, 3) at t = 0."""
        k = self.scene.body_index(body)
        owner = self.scene.bodies[k] if k != FIXED else None
        return rotation_matrices(owner.orientation) if isinstance(owner, SpatialBody) else np.eye(3)

    def marker(self, body: str, point) -> int:
        """Return a marker at a world point (t = 0)."""
        k = self.scene.body_index(body)
        where = np.array(point, dtype=float)
        if k != FIXED:
            where = self.axes(body).T @ (where - self.scene.bodies[k].position)
        rigid = k == FIXED or isinstance(self.scene.bodies[k], SpatialBody)
        kind = item.MarkerBodyRigid if rigid else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[k], localPosition=where.tolist()))

    def frame(self, body: str, point, axes: np.ndarray) -> int:
        """Return a marker at a world point (t = 0) with the given world axes (3, 3)."""
        k = self.scene.body_index(body)
        centre = self.scene.bodies[k].position if k != FIXED else np.zeros(3)
        to_body = self.axes(body).T
        place = exu.HT(rotation=to_body @ axes, translation=to_body @ np.subtract(point, centre))
        return self.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=self.bodies[k], localHT=place))

    def pair(self, part, point_a, point_b) -> list[int]:
        return [self.marker(part.body_a, point_a), self.marker(part.body_b, point_b)]


def _build_spatial(scene: Scene, method: str) -> Spatial:
    container = exu.SystemContainer()
    model = Spatial(scene, container, container.AddSystem())
    model.bodies[FIXED] = model.mbs.AddObject(item.ObjectGround())
    for k, body in enumerate(scene.bodies):
        model.bodies[k] = model.mbs.AddObject(_spatial_body(model, body, method))
        weight = model.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=model.bodies[k]))
        model.mbs.AddLoad(item.LoadMassProportional(markerNumber=weight, loadVector=list(scene.gravity)))
        _watch_body(model, k, isinstance(body, SpatialBody))
    for part in (*scene.joints, *scene.loads):
        SPATIAL_PARTS[type(part)](model, part)
    return model


def _spatial_body(model: Spatial, body, method: str):
    if not isinstance(body, SpatialBody):
        start = {"referenceCoordinates": list(body.position), "initialVelocities": list(body.velocity)}
        return item.ObjectMassPoint(mass=body.mass, nodeNumber=model.mbs.AddNode(item.NodePoint(**start)))
    xx, yy, zz, xy, xz, yz = body.inertia
    theta = np.array(body.orientation)
    if method == "rotation_vector":
        angle = 2.0 * np.arctan2(np.linalg.norm(theta[1:]), theta[0])
        scale = angle / np.linalg.norm(theta[1:]) if angle else 0.0
        turn, turning = scale * theta[1:], rotation_matrices(theta).T @ body.angular_velocity
        kind = item.NodeRigidBodyRotVecLG
    else:
        turn, turning = theta, 0.5 * parameter_matrix(theta).T @ body.angular_velocity
        kind = item.NodeRigidBodyEP
    node = model.mbs.AddNode(
        kind(referenceCoordinates=[*body.position, *turn], initialVelocities=[*body.velocity, *turning])
    )
    return item.ObjectRigidBody(mass=body.mass, inertia=[xx, yy, zz, yz, xz, xy], nodeNumber=node)


def _watch_body(model: Spatial, k: int, turns: bool) -> None:
    kinds = exu.OutputVariableType
    for kind in (kinds.Position, kinds.Velocity, *((kinds.AngularVelocity, kinds.RotationMatrix) if turns else ())):
        sensor = item.SensorBody(
            bodyNumber=model.bodies[k], storeInternal=True, writeToFile=False, outputVariableType=kind
        )
        model.sensors.append(model.mbs.AddSensor(sensor))


def _generic(model: Spatial, joint, axis, fixed: list[int]) -> None:
    """A joint along z of a frame whose z axis is the joint's; `fixed` tells the six relative motions it stops."""
    first, second = normals(axis)
    frame = np.column_stack((first, second, np.asarray(axis, dtype=float) / np.linalg.norm(axis)))
    markers = [model.frame(body, joint.point, frame) for body in (joint.body_a, joint.body_b)]
    model.mbs.AddObject(item.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=fixed))


def _spatial_spherical(model: Spatial, joint: Spherical) -> None:
    model.mbs.AddObject(item.ObjectJointSpherical(markerNumbers=model.pair(joint, joint.point, joint.point)))


def _spatial_distance(model: Spatial, joint: Distance) -> None:
    length = joint.length or float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
    model.mbs.AddObject(_rod(model.pair(joint, joint.point_a, joint.point_b), length))


def _spatial_spring(model: Spatial, load: SpringDamper) -> None:
    initial = float(np.linalg.norm(np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    law = {"springForceUserFunction": _pull_only} if load.tension_only else {}
    model.mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=model.pair(load, load.point_a, load.point_b),
            referenceLength=rest, stiffness=load.stiffness, damping=load.damping, **law,
        )
    )  # fmt: skip


def _spatial_push(model: Spatial, load: Force | TorqueVector) -> None:
    """A force or torque; along body axes Exudyn takes it in the body's own."""
    force = isinstance(load, Force)
    centre = model.scene.bodies[model.scene.body_index(load.body)].position
    marker = model.marker(load.body, load.point if force else centre)
    follows = load.frame == "body"
    vector = model.axes(load.body).T @ load.vector if follows else np.array(load.vector)
    kind = item.LoadForceVector if force else item.LoadTorqueVector
    _add_load(model, kind, marker, vector.tolist(), load, bodyFixed=follows)


SPATIAL_PARTS = {
    Spherical: _spatial_spherical,
    Revolute: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 1, 1, 1, 0]),
    Cylindrical: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 0, 1, 1, 0]),
    Prismatic: lambda model, joint: _generic(model, joint, joint.axis, [1, 1, 0, 1, 1, 1]),
    Weld: lambda model, joint: _generic(model, joint, (0.0, 0.0, 1.0), [1, 1, 1, 1, 1, 1]),
    Distance: _spatial_distance,
    SpringDamper: _spatial_spring,
    Force: _spatial_push,
    TorqueVector: _spatial_push,
}


# --- the run ---------------------------------------------------------------------------------------


def _options(plan: Plan, scene: Scene):
    """Leave nothing to defaults that surprise: halving of the step, modified Newton, output files."""
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    if "closed-loop" in traits(scene):  # sparse elimination fails at once on redundant rows and singular poses
        options.linearSolver.solverType = exu.LinearSolverType.EigenDense
        options.linearSolver.ignoreSingularJacobian = True
    options.parallel.numberOfThreads = 1
    time = options.timeIntegration
    time.verboseMode = 0
    adaptive = plan.method.kind == "adaptive"
    time.adaptiveStep = time.automaticStepSize = adaptive
    time.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    # useIndex2Constraints needs useNewmark, and is then TrapezoidalIndex2 to the last bit
    time.generalizedAlpha.useIndex2Constraints = time.generalizedAlpha.useNewmark = False
    time.newton.useModifiedNewton = False
    for name, value in NEWTON.items():
        setattr(time.newton, name, value)
    if adaptive:
        time.relativeTolerance, time.absoluteTolerance, time.minimumStepSize = plan.rtol, plan.atol, SMALLEST_STEP
    return options


def _solve(model, plan: Plan, options, keep: bool = False) -> str:
    """Run Exudyn's solver and return why it failed, or nothing."""
    try:
        done = model.mbs.SolveDynamic(
            options, solverType=SOLVERS[plan.method.name], updateInitialValues=keep, storeSolver=True
        )
    except SolverError as error:
        return f"exudyn: {error} at t = {model.mbs.systemData.GetTime():g} s"
    return "" if done else f"exudyn's solver returned False at t = {model.mbs.systemData.GetTime():g} s"


def _steps_done(model) -> int:
    """Exudyn's index points to the step to come."""
    return int(model.mbs.sys["dynamicSolver"].it.currentStepIndex) - 1


def _first_call(model, plan: Plan, options) -> None:
    """Take one step; the initial values stay as they are."""
    time = options.timeIntegration
    time.startTime, time.numberOfSteps = 0.0, 1
    time.endTime = plan.step or float(plan.times[1])
    options.solution.sensors.writePeriod = time.endTime
    _solve(model, plan, options)


def _stored(model) -> tuple[np.ndarray, np.ndarray]:
    """Return the sensors' times (n,) and values (n, ...)."""
    # all values of one sensor stand together, after its time
    data = [model.mbs.GetSensorStoredData(sensor) for sensor in model.sensors]
    return data[0][:, 0], np.hstack([d[:, 1:] for d in data])


def _advance_fixed(model, plan: Plan, options, max_steps: int) -> tuple[np.ndarray, End, int]:
    """Run the whole interval in one call; sensors record at a common divisor of the output intervals."""
    every = reduce(gcd, plan.counts)
    total = sum(plan.counts)
    time = options.timeIntegration
    time.startTime, time.endTime, time.numberOfSteps = 0.0, float(plan.times[-1]), total
    options.solution.sensors.writePeriod = every * plan.step
    failure = _solve(model, plan, options)
    at, values = _stored(model)
    rows = np.zeros((len(plan.times), values.shape[1]))
    wanted = np.concatenate(([0], np.cumsum(plan.counts))) // every
    # after a failure fewer samples are there, each at its own time
    pairs = zip(wanted, plan.times, strict=True)
    there = np.array([k < len(at) and abs(at[k] - t) < 0.5 * plan.step for k, t in pairs])
    samples = len(there) if there.all() else int(np.argmin(there))
    rows[:samples] = values[wanted[:samples]]
    steps = _steps_done(model)
    if failure:
        return rows, End(samples, Status.NOT_CONVERGED, failure), steps
    if samples < len(plan.times):
        return rows, End(samples, Status.RESET, f"exudyn left out the output at t = {plan.times[samples]:g} s"), steps
    return rows, End(samples), steps


def _advance_adaptive(model, plan: Plan, options, max_steps: int) -> tuple[np.ndarray, End, int]:
    """Call the solver for each output interval: one-step methods restart without loss."""
    system = model.mbs.systemData
    state = exu.ConfigurationType.Initial
    first = np.concatenate((system.GetODE2Coordinates(state), system.GetODE2Coordinates_t(state)))
    rows = np.zeros((len(plan.times), len(first)))
    rows[0] = first
    steps = 0
    time = options.timeIntegration
    for k, (begin, stop) in enumerate(zip(plan.times, plan.times[1:], strict=False), start=1):
        time.startTime, time.endTime, time.numberOfSteps = float(begin), float(stop), 1
        options.solution.sensors.writePeriod = float(stop)
        failure = _solve(model, plan, options, keep=True)
        steps += _steps_done(model)
        rows[k] = np.concatenate((system.GetODE2Coordinates(), system.GetODE2Coordinates_t()))
        if failure:
            return rows, End(k, Status.ENGINE_ERROR, failure), steps
        if steps > max_steps:
            return rows, End(k, Status.TOO_MANY_STEPS, f"max_steps = {max_steps} exceeded at t = {stop:g} s"), steps
    return rows, End(len(plan.times)), steps
