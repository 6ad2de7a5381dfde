"""Planar joints in redundant coordinates."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.planar_model import Redundant, in_body
from cross_checks.linkage.tree import FIXED
from cross_checks.workshop.prescribed import displacement
from mbs_ref.scene import CoordinateDrive, Distance, PlanarBody, Prismatic, Revolute, Weld


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
    along, across = in_body(angles[0], axis), in_body(angles[1], np.array([-axis[1], axis[0]]))
    model.mbs.AddObject(
        item.ObjectJointPrismatic2D(markerNumbers=markers, axisMarker0=[*along, 0.0], normalMarker1=[*across, 0.0])
    )


def _add_distance(model: Redundant, joint: Distance) -> None:
    markers = [model.marker(joint.body_a, joint.point_a), model.marker(joint.body_b, joint.point_b)]
    length = joint.length or float(np.hypot(*np.subtract(joint.point_b, joint.point_a)))
    _watch_force(model, joint.name, model.mbs.AddObject(rod(markers, length)), 1)


def rod(markers: list[int], length: float):
    return item.ObjectConnectorDistance(markerNumbers=markers, distance=length)


def _add_drive(model: Redundant, joint: CoordinateDrive) -> None:
    coordinate = ("x", "y", "angle").index(joint.coordinate)
    motion = displacement(joint.motion, joint.level)
    markers = [model.coordinate("ground", 0), model.coordinate(joint.body, coordinate)]

    def place(mbs, t, number, offset) -> float:
        return motion.value(t)

    def speed(mbs, t, number, offset) -> float:
        return motion.rate(t)

    model.mbs.AddObject(
        item.ObjectConnectorCoordinate(
            markerNumbers=markers,
            offsetUserFunction=place,
            offsetUserFunction_t=speed,
        )
    )
    model.notes += (f"drive {joint.name!r} calls Python at every residual",)


JOINTS = {
    Revolute: _add_revolute,
    Weld: _add_weld,
    Prismatic: _add_prismatic,
    Distance: _add_distance,
    CoordinateDrive: _add_drive,
}
