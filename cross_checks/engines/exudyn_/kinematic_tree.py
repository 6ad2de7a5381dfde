"""A planar scene in minimal coordinates: an Exudyn KinematicTree."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cross_checks.engine import Refusal
from cross_checks.engines.exudyn_.planar_model import in_body, node_sensor
from cross_checks.workshop.planar_forces import SHARED, AppliedForces
from cross_checks.workshop.planar_tree import FIXED, JointTree, joint_tree
from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Scene, Weld

ORIGIN = (0.0, 0.0)


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


def tree_refusals(scene: Scene) -> list[Refusal]:
    tree = joint_tree(scene)
    reasons = [Refusal(f"joint {j.name!r} closes a loop, which a KinematicTree cannot", True) for j in tree.closures]
    for joint in scene.joints:
        inner_weld = isinstance(joint, Weld) and GROUND not in (joint.body_a, joint.body_b)
        if inner_weld or isinstance(joint, CoordinateDrive):
            reasons.append(Refusal(f"joint {joint.name!r}: a KinematicTree is not yet taught {joint.type}", False))
    return reasons


def build_tree(scene: Scene) -> Tree:
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

        def forces(mbs, t, number, q, v) -> np.ndarray:
            return applied.generalized(t, np.array(q), np.array(v))

        options = {"forceUserFunction": forces}
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
    sensors = [mbs.AddSensor(node_sensor(node, kind)) for kind in kinds]
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
        offset = in_body(heading[p], edge.point - origin[p])
        centre = in_body(phi, tree.position[b] - edge.point)
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
