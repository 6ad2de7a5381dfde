"""A scene in minimal coordinates: an Exudyn KinematicTree of slides and turns."""

from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.linkage.forces import SHARED, applied
from cross_checks.linkage.links import FIXED, Link, Linkage, linkage_of
from cross_checks.linkage.motion import arrays_of, motion_of, poses_of
from mbs_ref.scene import CoordinateDrive, Scene
from mbs_ref.scene.base.part import normals


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


@dataclass
class Chain:
    """The lists that define a KinematicTree."""

    types: list = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    turns: list = field(default_factory=list)
    offsets: list = field(default_factory=list)
    inertias: list = field(default_factory=list)
    centres: list = field(default_factory=list)
    masses: list[float] = field(default_factory=list)
    frames: dict[int, tuple[int, np.ndarray, np.ndarray]] = field(
        default_factory=lambda: {FIXED: (-1, np.eye(3), np.zeros(3))}
    )  # body -> its link's number, axes (3, 3) and origin (3,) m in the world at t = 0

    def hang(self, link: Link) -> None:
        """Add a body's freedoms, each along z of a frame of its own."""
        number, axes, origin = self.frames[link.parent]
        last = len(link.freedoms) - 1
        for k, (kind, axis) in enumerate(link.freedoms):
            first, _ = normals(axis)
            own = np.column_stack((first, np.cross(axis, first), axis))
            mass, inertia = (link.mass, link.inertia * link.rigid) if k == last else (0.0, np.zeros((3, 3)))
            self.types.append(exu.JointType.PrismaticZ if kind == "slide" else exu.JointType.RevoluteZ)
            self.parents.append(number)
            self.turns.append(axes.T @ own)
            self.offsets.append(axes.T @ (link.origin - origin))
            self.masses.append(mass)
            self.centres.append(own.T @ link.centre)
            self.inertias.append(own.T @ inertia @ own)
            number, axes, origin = len(self.types) - 1, own, link.origin
        self.frames[link.body] = number, axes, origin


def tree_refusals(scene: Scene) -> list[Refusal]:
    linkage = linkage_of(scene)
    loops = (Refusal(f"joint {j.name!r} closes a loop, which a KinematicTree cannot", True) for j in linkage.closures)
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
    chain, loads = Chain(), applied(linkage)
    for link in linkage.links:
        chain.hang(link)
    options: dict[str, Any] = {"gravity": list(linkage.gravity)}
    if loads is not None:

        def forces(mbs, t, number, q, v) -> np.ndarray:
            return loads.generalized(t, np.array(q), np.array(v))

        options = {"forceUserFunction": forces}
    number = mbs.AddObject(
        item.ObjectKinematicTree(
            nodeNumber=node, **options, jointTypes=chain.types, linkParents=chain.parents,
            jointTransformations=exu.Matrix3DList(chain.turns), jointOffsets=exu.Vector3DList(chain.offsets),
            linkInertiasCOM=exu.Matrix3DList(chain.inertias), linkCOMs=exu.Vector3DList(chain.centres),
            linkMasses=chain.masses,
        )
    )  # fmt: skip
    kinds = (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    options = {"nodeNumber": node, "storeInternal": True, "writeToFile": False}
    sensors = [mbs.AddSensor(item.SensorNode(**options, outputVariableType=kind)) for kind in kinds]
    return Tree(linkage, container, mbs, number, sensors, chain.centres, () if loads is None else (SHARED,))
