"""A spatial scene as an Exudyn system, in Euler parameters or rotation vectors."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.contact import add_contacts
from cross_checks.engines.exudyn_.methods import CONTACT, EXPLICIT_CONTACT
from cross_checks.engines.exudyn_.pair_contact import add_pair_contacts
from cross_checks.engines.exudyn_.spatial_model import Spatial
from cross_checks.engines.exudyn_.spatial_parts import SPATIAL_PARTS
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import parameter_matrix, rotation_matrices


def build_spatial(scene: Scene, method: str) -> Spatial:
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
    if scene.contacts:
        (add_contacts if method == CONTACT else add_pair_contacts)(model)
    return model


def _spatial_body(model: Spatial, body, method: str):
    if not isinstance(body, SpatialBody):
        start = {"referenceCoordinates": list(body.position), "initialVelocities": list(body.velocity)}
        return item.ObjectMassPoint(mass=body.mass, nodeNumber=model.mbs.AddNode(item.NodePoint(**start)))
    xx, yy, zz, xy, xz, yz = body.inertia
    theta = np.array(body.orientation)
    if method in ("rotation_vector", *EXPLICIT_CONTACT):  # explicit solvers take no norm constraint
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
