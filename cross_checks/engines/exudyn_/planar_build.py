"""A planar scene as an Exudyn system in redundant coordinates."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn as exu
import exudyn.itemInterface as item

from cross_checks.engines.exudyn_.contact import add_contacts
from cross_checks.engines.exudyn_.methods import CONTACT
from cross_checks.engines.exudyn_.planar_joints import JOINTS
from cross_checks.engines.exudyn_.planar_loads import LOADS
from cross_checks.engines.exudyn_.planar_model import Redundant, node_sensor
from cross_checks.engines.exudyn_.shared_forces import add_shared_forces
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene import PlanarBody, Scene


def build_redundant(scene: Scene, method: str) -> Redundant:
    container = exu.SystemContainer()
    model = Redundant(scene, container, container.AddSystem())
    model.bodies[FIXED] = model.mbs.AddObject(item.ObjectGround())
    for k, body in enumerate(scene.bodies):
        _add_body(model, k, body)
    for joint in scene.joints:
        JOINTS[type(joint)](model, joint)
    if method != CONTACT and (scene.contacts or any(type(load) not in LOADS for load in scene.loads)):
        add_shared_forces(model)
        return model
    for load in scene.loads:
        LOADS[type(load)](model, load)
    if scene.contacts:
        add_contacts(model)
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
        model.watch(node_sensor(node, kind), len(q))
