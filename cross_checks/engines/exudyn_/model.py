"""An Exudyn system in redundant coordinates: a node for each body, markers on it, and sensors that read it."""

from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.linkage.links import FIXED, Z, lifted
from mbs_ref import Trajectory
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Distance, PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, from_matrix, rotation_matrices


@dataclass
class Redundant:
    """An Exudyn system with a node for each body: planar bodies have nodes of three coordinates."""

    scene: Scene
    container: Any  # keeps the system alive
    mbs: Any
    nodes: list[int] = field(default_factory=list)
    bodies: dict[int, int] = field(default_factory=dict)  # scene body -> Exudyn object
    sensors: list[int] = field(default_factory=list)
    widths: list[int] = field(default_factory=list)  # numbers a sensor gives
    forces: dict[str, int] = field(default_factory=dict)  # joint -> first column of its recorded force
    notes: tuple[str, ...] = ()
    general: list = field(default_factory=list)  # see contact.general_contact

    @property
    def planar(self) -> bool:
        return self.scene.dimension == 2

    def watch(self, sensor: type, number: dict[str, int], kind: Any, width: int) -> None:
        """Add a sensor of so many numbers at an item."""
        options = {"storeInternal": True, "writeToFile": False, "outputVariableType": kind}
        self.sensors.append(self.mbs.AddSensor(sensor(**number, **options)))
        self.widths.append(width)

    def poses(self, rows: np.ndarray):
        return _planar_poses(self.scene, rows) if self.planar else _spatial_poses(self.scene, rows)

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return force on body b and torque about its mark; Exudyn gives the force on body a, or a rod's tension."""
        motion = Motion(self.scene, Trajectory(np.zeros(len(rows)), *self.poses(rows)))
        result = {}
        for joint in self.scene.joints:
            if joint.name in self.forces:
                column, force = self.forces[joint.name], np.zeros((len(rows), 3))
                along = -_along(motion, joint) if isinstance(joint, Distance) else -1.0
                force[:, :2] = along * rows[:, column : column + (1 if isinstance(joint, Distance) else 2)]
                result[joint.name] = force
        return result

    def axes(self, body: str) -> np.ndarray:
        """Return the body's axes (3, 3) at t = 0."""
        k = self.scene.body_index(body)
        owner = self.scene.bodies[k] if k != FIXED else None
        theta = getattr(owner, "orientation", None)
        return rotation_matrices(from_axis_angle(Z, getattr(owner, "angle", 0.0)) if theta is None else theta)

    def place(self, body: str, point) -> list[float]:
        """Return a world point (t = 0) in a body's frame, whose origin is the centre of mass."""
        k = self.scene.body_index(body)
        centre = lifted(self.scene.bodies[k].position) if k != FIXED else np.zeros(3)
        return (self.axes(body).T @ (lifted(point) - centre)).tolist()

    def marker(self, body: str, point, rigid: bool | None = None) -> int:
        """Return a marker at a world point (t = 0); a rigid one takes torques, as all on rigid bodies in space do."""
        k = self.scene.body_index(body)
        if rigid is None:
            rigid = not self.planar and (k == FIXED or isinstance(self.scene.bodies[k], SpatialBody))
        kind = item.MarkerBodyRigid if rigid else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[k], localPosition=self.place(body, point)))

    def frame(self, body: str, point, axes: np.ndarray) -> int:
        """Return a marker at a world point (t = 0) with the given world axes (3, 3)."""
        place = exu.HT(rotation=self.axes(body).T @ axes, translation=self.place(body, point))
        number = self.bodies[self.scene.body_index(body)]
        return self.mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=number, localHT=place))

    def pair(self, part, point_a, point_b) -> list[int]:
        return [self.marker(part.body_a, point_a), self.marker(part.body_b, point_b)]

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


def _planar_poses(scene: Scene, rows: np.ndarray):
    """Return the poses of recorded coordinates, which count from the start, and of their rates."""
    position, velocity = np.zeros((2, len(rows), len(scene.bodies), 2))
    angle, rate = np.zeros((2, len(rows), len(scene.bodies)))
    column = 0
    for k, body in enumerate(scene.bodies):
        width = 3 if isinstance(body, PlanarBody) else 2
        q, v = rows[:, column : column + width], rows[:, column + width : column + 2 * width]
        position[:, k], velocity[:, k] = body.position + q[:, :2], v[:, :2]
        if isinstance(body, PlanarBody):
            angle[:, k], rate[:, k] = body.angle + q[:, 2], v[:, 2]
        column += 2 * width
    return position, angle, velocity, rate


def _spatial_poses(scene: Scene, rows: np.ndarray):
    """Return the poses of recorded positions and velocities, and of rigid bodies' rates and rotation matrices."""
    position, velocity, omega = np.zeros((3, len(rows), len(scene.bodies), 3))
    theta = np.tile([1.0, 0.0, 0.0, 0.0], (len(rows), len(scene.bodies), 1))
    column = 0
    for k, body in enumerate(scene.bodies):
        position[:, k], velocity[:, k] = rows[:, column : column + 3], rows[:, column + 3 : column + 6]
        column += 6
        if isinstance(body, SpatialBody):
            omega[:, k] = rows[:, column : column + 3]
            turned = rows[:, column + 3 : column + 12].reshape(-1, 3, 3)
            theta[:, k] = [from_matrix(m) if np.isfinite(m).all() else np.full(4, np.nan) for m in turned]
            column += 12
    return position, theta, velocity, omega
