"""Exudyn: redundant coordinates with implicit methods, or minimal coordinates (KinematicTree) with explicit ones."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Engine, Loop, Method, Plan, Poses, Refusal
from cross_checks.engines.exudyn_ import contact
from cross_checks.engines.exudyn_ import run as solver
from cross_checks.engines.exudyn_.model import Redundant, build_tree, tree_refusals
from cross_checks.engines.exudyn_.parts import JOINTS, LOADS, STOPPED, add_joint, has_connector
from cross_checks.engines.exudyn_.run import CONTACT, EXPLICIT_CONTACT, METHODS, STAGES, TREE, Left
from cross_checks.linkage.forces import BY_SHARED_CODE, PARTS, Applied, shared_refusals
from cross_checks.linkage.links import FIXED, lifted, linkage_of
from mbs_ref import Settings
from mbs_ref.scene import CoordinateDrive, Load, PlanarBody, PointMass, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import parameter_matrix, rotation_matrices, rotation_vector
from mbs_ref.scene.traits import traits

ROTATION_VECTOR = "rotation_vector"
MOVED = 1e-7  # m, rad, m/s: by which states differ whose forces give a Jacobian, as in Exudyn's own differences


def takes_shared_forces(scene: Scene, method: str) -> bool:
    """Return whether some load or contact is none of Exudyn's own connectors."""
    return method not in EXPLICIT_CONTACT and bool(scene.contacts or _foreign(scene))


def _foreign(scene: Scene) -> tuple[Load, ...]:
    """Return the loads that no connector of Exudyn's represents."""
    return tuple(load for load in scene.loads if not has_connector(scene, load))


def build_redundant(scene: Scene, method: str) -> Redundant:
    container = exu.SystemContainer()
    model = Redundant(scene, container, container.AddSystem())
    model.bodies[FIXED] = model.mbs.AddObject(item.ObjectGround())
    for k, body in enumerate(scene.bodies):
        model.bodies[k] = model.mbs.AddObject(_body(model, body, method))
        weight = model.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=model.bodies[k]))
        model.mbs.AddLoad(item.LoadMassProportional(markerNumber=weight, loadVector=lifted(scene.gravity).tolist()))
        _watch_body(model, k)
    for joint in scene.joints:
        add_joint(model, joint)
    for load in scene.loads:
        if has_connector(scene, load):
            LOADS[type(load)](model, load)
    if takes_shared_forces(scene, method):
        _add_shared_forces(model)
    elif scene.contacts:
        (contact.add_contacts if method == CONTACT else contact.add_pair_contacts)(model)
    return model


def _body(model: Redundant, body, method: str):
    """Return the object of a body at its node."""
    own, turn, turning, kind = {}, (), (), item.NodePoint2D if model.scene.planar else item.NodePoint
    body_type = item.ObjectMassPoint2D if model.scene.planar else item.ObjectMassPoint
    if isinstance(body, PlanarBody):
        kind, body_type, own = item.NodeRigidBody2D, item.ObjectRigidBody2D, {"inertia": body.inertia}
        turn, turning = [body.angle], [body.angular_velocity]
    elif isinstance(body, SpatialBody):
        xx, yy, zz, xy, xz, yz = body.inertia
        body_type, own = item.ObjectRigidBody, {"inertia": [xx, yy, zz, yz, xz, xy]}
        kind, turn, turning = _turn(body, method)
    start = {"referenceCoordinates": [*body.position, *turn], "initialVelocities": [*body.velocity, *turning]}
    model.nodes.append(model.mbs.AddNode(kind(**start)))
    return body_type(mass=body.mass, nodeNumber=model.nodes[-1], **own)


def _turn(body: SpatialBody, method: str):
    """Return the node's type, and its coordinates and rates that turn the body."""
    theta = np.array(body.orientation)
    if method in (ROTATION_VECTOR, *EXPLICIT_CONTACT):  # explicit solvers take no norm constraint
        spin = rotation_matrices(theta).T @ body.angular_velocity
        return item.NodeRigidBodyRotVecLG, rotation_vector(theta), spin
    return item.NodeRigidBodyEP, theta, 0.5 * parameter_matrix(theta).T @ body.angular_velocity


def _watch_body(model: Redundant, k: int) -> None:
    kinds, turns = exu.OutputVariableType, not isinstance(model.scene.bodies[k], PointMass)
    if model.scene.planar:
        for kind in (kinds.Coordinates, kinds.Coordinates_t):
            model.watch(item.SensorNode, {"nodeNumber": model.nodes[k]}, kind, 3 if turns else 2)
        return
    of_rigid = ((kinds.AngularVelocity, 3), (kinds.RotationMatrix, 9)) if turns else ()
    for kind, width in ((kinds.Position, 3), (kinds.Velocity, 3), *of_rigid):
        model.watch(item.SensorBody, {"bodyNumber": model.bodies[k]}, kind, width)


def _add_shared_forces(model: Redundant) -> None:
    """Apply contacts, and loads without a connector, through one item over all nodes, which calls Python."""
    loads = _foreign(model.scene)
    linkage = linkage_of(model.scene.model_copy(update={"loads": loads}))
    applied, turns = Applied(linkage), linkage.angle if model.scene.planar else linkage.theta
    start = np.column_stack(([body.position for body in model.scene.bodies], turns))
    used = np.ones(start.shape, dtype=bool)
    used[linkage.rigid == 0.0, model.scene.dimension :] = False  # a particle's node has its place alone
    weight = np.zeros(start.shape)  # the bodies have it already
    weight[:, : model.scene.dimension] = np.outer([body.mass for body in model.scene.bodies], model.scene.gravity)

    def at(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        pose, rate = np.tile(start, (len(q), 1, 1)), np.zeros((len(q), *start.shape))
        pose[:, used] += q
        rate[:, used] = v
        return (applied.at_poses(t, pose, rate) - weight)[:, used]

    def forces(mbs, t, number, q, v) -> np.ndarray:
        return at(t, np.array([q]), np.array([v]))[0]

    def jacobian(mbs, t, number, q, v, of_q: float, of_v: float) -> np.ndarray:
        """Return -(of_q df/dq + of_v df/dv), from states moved along both at once (ObjectGenericODE2's J_user)."""
        move = MOVED / max(of_q, of_v) * np.vstack((np.zeros(size), np.eye(size)))
        found = at(t, q + of_q * move, v + of_v * move)
        return (found[0] - found[1:]).T * (max(of_q, of_v) / MOVED)

    size = int(used.sum())
    zero = np.zeros((size, size))
    model.mbs.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=model.nodes, massMatrix=zero, stiffnessMatrix=zero, dampingMatrix=zero,
            forceVector=np.zeros(size), forceUserFunction=forces, jacobianUserFunction=jacobian,
        )
    )  # fmt: skip
    shared = [
        *(("contacts",) if model.scene.contacts else ()),
        *sorted({f"loads of type {load.type}" for load in loads}),
    ]
    model.notes += (f"{', '.join(shared)} {BY_SHARED_CODE}",)


@dataclass(frozen=True)
class Built:
    """An assembled system, and the options of its solver."""

    model: Any  # Redundant or Tree
    options: Any
    loops: bool
    left: list[Left] = field(default_factory=list)  # what the run left, once it is over


class Exudyn(Engine):
    """Exudyn through its item interface; adaptive halving of the step is always off for fixed steps."""

    name: ClassVar[str] = "exudyn"
    package: ClassVar[str] = "exudyn"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    as_shipped: ClassVar[Settings | None] = Settings(method="generalized_alpha", step=1e-2)
    part_types: ClassVar[frozenset[str]] = PARTS | {"coordinate_drive", "stick_slip"}

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name in EXPLICIT_CONTACT:
            beyond = [f"load {load.name!r}: {method.name} does not yet support {load.type}" for load in scene.loads]
            beyond += [f"joint {joint.name!r}: Exudyn's explicit solvers support no joints" for joint in scene.joints]
            refusals = contact.general_contact_refusals if method.name == CONTACT else contact.pair_contact_refusals
            beyond += refusals(scene)
            reasons += [Refusal(reason, permanent=False) for reason in beyond]
        else:
            reasons += shared_refusals(scene)
        if method.name.startswith(TREE):
            return reasons + tree_refusals(scene)
        drives = (CoordinateDrive,) if scene.dimension == 3 else ()
        strange = [joint for joint in scene.joints if type(joint) not in JOINTS | STOPPED or isinstance(joint, drives)]
        sentence = f"joint {{!r}}: {method.name} does not yet support {{}}"
        reasons += [Refusal(sentence.format(joint.name, joint.type), False) for joint in strange]
        if method.name == ROTATION_VECTOR and takes_shared_forces(scene, method.name):
            reasons.append(Refusal(f"{method.name}: the shared force code lacks rotation vectors", False))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        exu.config.printToConsole = False
        name = plan.method.name
        model = build_tree(scene) if name.startswith(TREE) else build_redundant(scene, name)
        model.mbs.Assemble()
        options = solver.options_of(plan, scene, dense=solver.needs_dense(model.mbs, scene))
        return Built(model, options, "closed-loop" in traits(scene))

    def first_call(self, model: Built, plan: Plan) -> None:
        solver.first_call(model.model, plan, model.options)

    def advance(self, model: Built, plan: Plan) -> Left:
        if plan.method.kind == "fixed":
            return solver.advance_fixed(model.model, plan, model.options, loops=model.loops)
        return solver.advance_adaptive(model.model, plan, model.options)

    def collect(self, model: Built, plan: Plan, left: Left) -> Loop:
        rows, end = solver.sampled(model.model, plan, left)
        model.left.append(left)
        return Loop(rows, end, left.steps, left.steps * STAGES.get(plan.method.name, 1))

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        return model.model.poses(states)

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        return model.model.reactions(states)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return model.model.notes + tuple(why for left in model.left for why in left.retried)


ENGINE = Exudyn
