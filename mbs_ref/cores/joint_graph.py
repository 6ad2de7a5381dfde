"""The joint graph: which joints share a slot, the spanning tree, the loop closures."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbs_ref.scene import CoordinateDrive, Distance, PointDrive, Prismatic, Revolute, Scene, Weld
from mbs_ref.scene.traits import joint_ends

MAX_ROWS = 3  # a planar body cannot lose more than three freedoms to one neighbour


def row_count(joint: Any) -> int:
    """Return the number of constraint rows of a planar joint."""
    return {"revolute": 2, "prismatic": 2, "weld": 3}.get(joint.type, 1)


@dataclass
class Edge:
    """Joints between one pair of bodies whose rows are independent in every pose: one slot."""

    a: int  # scene index, -1 for ground
    b: int
    joints: list[int] = field(default_factory=list)  # indices into scene.joints
    rows: int = 0


@dataclass
class Layout:
    """Elimination order and slots: tree edges first (slot = place of the child), closures after."""

    order: list[int]  # elimination number -> scene index; parents first
    parent: list[int]  # elimination number -> elimination number, len(order) for ground or none
    tree_edge: list[Edge | None]  # of each body in elimination order
    closures: list[Edge]


def _translation(joint: Any, scene: Scene) -> tuple[tuple[float, ...], np.ndarray] | None:
    """Return the point and the directions (k, 2) a joint fixes, or None."""
    if isinstance(joint, Revolute | Weld):
        return joint.point, np.eye(2)
    if isinstance(joint, PointDrive):
        return joint.point, np.array([joint.direction]) / np.linalg.norm(joint.direction)
    if isinstance(joint, CoordinateDrive) and joint.coordinate != "angle":
        centre = scene.bodies[scene.body_index(joint.body)].position
        return centre, np.array([[1.0, 0.0] if joint.coordinate == "x" else [0.0, 1.0]])
    return None


def _fixes_angle(joint: Any) -> bool:
    return isinstance(joint, Weld) or getattr(joint, "coordinate", None) == "angle"


def _fits(edge: Edge, joint: Any, scene: Scene) -> bool:
    """Return whether a planar joint's rows stay independent of the edge's in every pose."""
    present = [scene.joints[k] for k in edge.joints]
    if edge.rows + row_count(joint) > MAX_ROWS:
        return False
    if any(isinstance(j, Prismatic | Distance) for j in [*present, joint]):
        return False
    if sum(_fixes_angle(j) for j in [*present, joint]) > 1:
        return False
    fixed = [t for t in (_translation(j, scene) for j in [*present, joint]) if t is not None]
    if len({point for point, _ in fixed}) > 1:
        return False
    directions = np.vstack([d for _, d in fixed]) if fixed else np.zeros((0, 2))
    return np.linalg.matrix_rank(directions, tol=0.1) == len(directions)


def edges(scene: Scene, rows: Callable[[Any], int], fits: Callable[[Edge, Any, Scene], bool]) -> list[Edge]:
    """Group the joints into slots: those of a pair of bodies whose rows `fits` finds independent."""
    result: list[Edge] = []
    by_pair: dict[frozenset[int], list[Edge]] = {}
    for k, joint in enumerate(scene.joints):
        a, b = (scene.body_index(end) for end in joint_ends(joint))
        group = by_pair.setdefault(frozenset((a, b)), [])
        edge = next((e for e in group if fits(e, joint, scene)), None)
        if edge is None:
            edge = Edge(a, b)
            group.append(edge)
            result.append(edge)
        edge.joints.append(k)
        edge.rows += rows(joint)
    return result


def layout(scene: Scene) -> Layout:
    """Lay out a planar scene."""
    return span_graph(scene, edges(scene, row_count, _fits))


def span_graph(scene: Scene, every: list[Edge]) -> Layout:
    """Span the joint graph breadth first, ground first, stronger joints first."""
    neighbours: dict[int, list[Edge]] = {i: [] for i in range(-1, len(scene.bodies))}
    for edge in sorted(every, key=lambda e: -e.rows):
        neighbours[edge.a].append(edge)
        neighbours[edge.b].append(edge)
    number = {-1: len(scene.bodies)}
    result = Layout([], [], [], [])
    used: set[int] = set()

    def visit(body: int, parent: int, edge: Edge | None) -> None:
        number[body] = len(result.order)
        result.order.append(body)
        result.parent.append(number[parent])
        result.tree_edge.append(edge)

    def span(root: int) -> None:
        queue = deque([root])
        while queue:
            here = queue.popleft()
            for edge in neighbours[here]:
                there = edge.b if edge.a == here else edge.a
                if there not in number:
                    visit(there, here, edge)
                    used.add(id(edge))
                    queue.append(there)

    span(-1)
    for body in range(len(scene.bodies)):
        if body not in number:
            visit(body, -1, None)
            span(body)
    result.closures = [edge for edge in every if id(edge) not in used]
    return result
