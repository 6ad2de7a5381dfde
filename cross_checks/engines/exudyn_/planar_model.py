"""An Exudyn system of planar bodies in redundant coordinates, read through sensors of coordinates."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import exudyn.itemInterface as item
import numpy as np

from cross_checks.linkage.tree import FIXED
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Distance, PlanarBody, Scene
from mbs_ref.trajectory import Trajectory


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
            where = in_body(getattr(owner, "angle", 0.0), where - np.array(owner.position))
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


def in_body(angle: float, r: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * r[0] + s * r[1], c * r[1] - s * r[0]])


def node_sensor(node: int, kind: Any):
    return item.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kind)
