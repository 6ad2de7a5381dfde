"""A scene in minimal coordinates: an Exudyn KinematicTree of slides and turns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.linkage.forces import SHARED, applied
from cross_checks.linkage.links import FIXED, Linkage, linkage_of
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
