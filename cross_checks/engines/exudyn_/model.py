"""An Exudyn system of a scene: in redundant coordinates, or in minimal ones as a KinematicTree of slides and turns.

In redundant coordinates it has a node for each body, markers on it, and sensors that read it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.linkage.forces import SHARED, applied
from cross_checks.linkage.links import ALONE, FIXED, Linkage, Z, lifted, linkage_of
from cross_checks.linkage.motion import arrays_of, motion_of, poses_of
from mbs_ref import Trajectory
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import CoordinateDrive, Distance, Scene, SpatialBody
from mbs_ref.scene.base.part import normals
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

    def watch(self, sensor: type, number: dict[str, int], kind: Any, width: int) -> None:
        """Add a sensor of so many numbers at an item."""
        options = {"storeInternal": True, "writeToFile": False, "outputVariableType": kind}
        self.sensors.append(self.mbs.AddSensor(sensor(**number, **options)))
        self.widths.append(width)

    def poses(self, rows: np.ndarray):
        """Return the poses and rates of all bodies, whose sensors are the first."""
        values = iter(np.split(rows, np.cumsum(self.widths)[:-1], axis=1))
        read = _planar if self.scene.planar else _spatial
        each = [read(body, values) for body in self.scene.bodies]
        return tuple(np.stack(part, axis=1) for part in zip(*each, strict=True))

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
        return (self.axes(body).T @ (lifted(point) - self.centre(body))).tolist()

    def centre(self, body: str) -> np.ndarray:
        """Return the body's centre of mass (3,) m at t = 0, or the world's origin."""
        k = self.scene.body_index(body)
        return lifted(self.scene.bodies[k].position) if k != FIXED else np.zeros(3)

    def marker(self, body: str, point, rigid: bool | None = None) -> int:
        """Return a marker at a world point (t = 0); a rigid one takes torques, as all on rigid bodies in space do."""
        k = self.scene.body_index(body)
        if rigid is None:
            rigid = not self.scene.planar and (k == FIXED or isinstance(self.scene.bodies[k], SpatialBody))
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


def _planar(body: Any, values: Iterator[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Return the pose and the rates of a body by recorded coordinates, which count from the start, and their rates."""
    q, v = (np.pad(next(values), ((0, 0), (0, 1)))[:, :3] for _ in range(2))  # a particle has no third
    return body.position + q[:, :2], getattr(body, "angle", 0.0) + q[:, 2], v[:, :2], v[:, 2]


def _spatial(body: Any, values: Iterator[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Return them by recorded position and velocity, and by a rigid body's angular velocity and rotation matrix."""
    position, velocity = next(values), next(values)
    if not isinstance(body, SpatialBody):
        return position, np.tile(ALONE, (len(position), 1)), velocity, np.zeros_like(velocity)
    omega, turned = next(values), next(values).reshape(-1, 3, 3)
    theta = [from_matrix(m) if np.isfinite(m).all() else np.full(4, np.nan) for m in turned]
    return position, np.array(theta), velocity, omega


@dataclass
class Tree:
    """An Exudyn KinematicTree; a joint of several freedoms is a chain whose first links have no mass."""

    linkage: Linkage
    container: Any
    mbs: Any
    number: int  # of the KinematicTree
    sensors: list[int]
    centres: list[np.ndarray]  # of mass, in the frames of its links
    notes: tuple[str, ...] = ()

    def poses(self, rows: np.ndarray):
        arrays, n = arrays_of(self.linkage), rows.shape[1] // 2
        return poses_of(self.linkage, (motion_of(arrays, row[:n].copy(), row[n:].copy())[0] for row in rows))

    def reactions(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        return {}


def _chain(linkage: Linkage) -> Iterator[tuple]:
    """Yield type, parent, turn, offset, inertia, centre and mass of the links: a body's freedoms, each along its z."""
    frames = {FIXED: (-1, np.eye(3), np.zeros(3))}  # body -> its link, axes (3, 3) and origin (3,) m at t = 0
    count = 0
    for link in linkage.links:
        number, axes, origin = frames[link.parent]
        for k, (kind, axis) in enumerate(link.freedoms, start=1):
            first, _ = normals(axis)
            own = np.column_stack((first, np.cross(axis, first), axis))
            last = float(k == len(link.freedoms))
            yield (
                exu.JointType.PrismaticZ if kind == "slide" else exu.JointType.RevoluteZ, number, axes.T @ own,
                axes.T @ (link.origin - origin), own.T @ (last * link.rigid * link.inertia) @ own,
                own.T @ link.centre, last * link.mass,
            )  # fmt: skip
            number, axes, origin, count = count, own, link.origin, count + 1
        frames[link.body] = number, axes, origin


def tree_refusals(scene: Scene) -> list[Refusal]:
    linkage = linkage_of(scene)
    loops = (Refusal(f"joint {j.name!r} closes a loop; a KinematicTree has none", True) for j in linkage.closures)
    strange = [joint.name for joint in scene.joints if isinstance(joint, CoordinateDrive)]
    for link in linkage.links:
        inner = not link.freedoms and link.parent != FIXED
        if inner or any(kind in ("ball", "free") for kind, _ in link.freedoms):
            strange.append(link.joint or link.name)
    sentence = "{!r}: a KinematicTree supports slides and turns, and welds to ground, alone"
    return [*loops, *(Refusal(sentence.format(name), False) for name in strange)]


def build_tree(scene: Scene) -> Tree:
    linkage = linkage_of(scene)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    size = len(linkage.rates)
    node = mbs.AddNode(
        item.NodeGenericODE2(
            referenceCoordinates=[0.0] * size, initialCoordinates=[0.0] * size,
            initialCoordinates_t=list(linkage.rates), numberOfODE2Coordinates=size,
        )
    )  # fmt: skip
    loads, columns = applied(linkage), zip(*_chain(linkage), strict=True)
    types, parents, turns, offsets, inertias, centres, masses = map(list, columns)
    options: dict[str, Any] = {"gravity": list(linkage.gravity)}
    if loads is not None:

        def forces(mbs, t, number, q, v) -> np.ndarray:
            return loads.generalized(t, np.array(q), np.array(v))

        options = {"forceUserFunction": forces}
    number = mbs.AddObject(
        item.ObjectKinematicTree(
            nodeNumber=node, **options, jointTypes=types, linkParents=parents,
            jointTransformations=exu.Matrix3DList(turns), jointOffsets=exu.Vector3DList(offsets),
            linkInertiasCOM=exu.Matrix3DList(inertias), linkCOMs=exu.Vector3DList(centres), linkMasses=masses,
        )
    )  # fmt: skip
    kinds = (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    options = {"nodeNumber": node, "storeInternal": True, "writeToFile": False}
    sensors = [mbs.AddSensor(item.SensorNode(**options, outputVariableType=kind)) for kind in kinds]
    return Tree(linkage, container, mbs, number, sensors, centres, () if loads is None else (SHARED,))
