"""The joint graph: which joints share a slot, the spanning tree, the loop closures."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import cross
from mbs_ref.scene.base.rows import Prescribed, PrescribedAngle, Product, Row, SameAngle, SharedPoint, Turn, UserRow
from mbs_ref.scene.scene import of_last_scene

MAX_ROWS = 3  # a planar body cannot lose more than three freedoms to one neighbour
INDEPENDENT = 0.1  # least singular value of unit directions that count as independent
PARALLEL = 1e-9  # sine of the angle between axes that count as one


@dataclass
class Edge:
    """Joints between one pair of bodies whose rows are independent in every pose: one slot."""

    a: int  # scene index, -1 for ground
    b: int
    joints: list[int] = field(default_factory=list)  # indices into scene.joints
    rows: list[Row] = field(default_factory=list)


@dataclass
class Layout:
    """Elimination order and slots: tree edges first (slot = place of the child), closures after."""

    order: list[int]  # elimination number -> scene index; parents first
    parent: list[int]  # elimination number -> elimination number, len(order) for ground or none
    tree_edge: list[Edge | None]  # of each body in elimination order
    closures: list[Edge]


def _placed(row: Row, scene: Scene, joint: Any) -> Row:
    if isinstance(row, Prescribed) and row.point is None:
        return replace(row, point=scene.bodies[scene.places[joint.ends[1]]].position)
    return row


def row_count(rows: Sequence[Row]) -> int:
    return sum([row.count for row in rows])


@of_last_scene
def graph_of(scene: Scene) -> tuple[list[list[Row]], Layout]:
    """Return the elementary rows of every joint, those on a centre of mass with its place, and the layout."""
    dimension = scene.dimension
    rows = [[_placed(row, scene, joint) for row in joint.rows(dimension)] for joint in scene.joints]
    return rows, _span_graph(scene, _edges(scene, rows))


def _edges(scene: Scene, rows: list[list[Row]]) -> list[Edge]:
    """Group the joints into slots: those of a pair of bodies whose rows are independent in every pose."""
    fits = {2: _fits_in_plane, 3: _fits_in_space}[scene.dimension]
    result, places = list[Edge](), scene.places
    by_pair: dict[frozenset[int], list[Edge]] = {}
    for k, joint in enumerate(scene.joints):
        a, b = [places[end] for end in joint.ends]
        group = by_pair.setdefault(frozenset((a, b)), [])
        edge = next((e for e in group if fits(e.rows, rows[k])), None)
        if edge is None:
            edge = Edge(a, b)
            group.append(edge)
            result.append(edge)
        edge.joints.append(k)
        edge.rows += rows[k]
    return result


def _fits_in_plane(present: list[Row], added: list[Row]) -> bool:
    """One angle and, at one point, independent directions."""
    every = [*present, *added]
    angles = [row for row in every if isinstance(row, SameAngle | PrescribedAngle)]
    held = [row for row in every if isinstance(row, SharedPoint | Prescribed)]
    if len(angles) + len(held) < len(every) or len(angles) > 1 or row_count(every) > MAX_ROWS:
        return False
    return _are_independent(held)


def _fits_in_space(present: list[Row], added: list[Row]) -> bool:
    """A turn goes with a joint that keeps its axis; prescribed directions at one point go together."""
    if any(isinstance(row, Turn) for row in added):
        axis = _kept_axis(present)
        turn = next(row for row in added if isinstance(row, Turn))
        return axis is not None and float(np.linalg.norm(cross(axis, cross(turn.zero, turn.quarter)))) < PARALLEL
    held = [row for row in (*present, *added) if isinstance(row, Prescribed)]
    return len(held) == len(present) + len(added) and _are_independent(held)


def _kept_axis(rows: list[Row]) -> np.ndarray | None:
    """Return the axis (3,) that the rows of one joint keep in both bodies and leave free to turn about."""
    products = [row for row in rows if isinstance(row, Product)]
    if len(products) != 2 or any(isinstance(row, Turn) for row in rows):
        return None
    first, second = (row.along_b for row in products)
    return first if np.array_equal(first, second) else None


def _are_independent(held: Sequence[SharedPoint | Prescribed]) -> bool:
    if len({row.point_a if isinstance(row, SharedPoint) else row.point for row in held}) > 1:
        return False
    directions = [np.eye(row.count) if isinstance(row, SharedPoint) else row.direction[None] for row in held]
    return not held or np.linalg.matrix_rank(np.vstack(directions), tol=INDEPENDENT) == row_count(held)


def _span_graph(scene: Scene, every: list[Edge]) -> Layout:
    """Span the joint graph breadth first, ground first, stronger joints first."""
    # a user's row may leave a body free at some pose, and closes a loop
    spanning = [edge for edge in every if UserRow not in map(type, edge.rows)]
    neighbours: dict[int, list[Edge]] = {i: [] for i in range(-1, len(scene.bodies))}
    for edge in sorted(spanning, key=lambda e: -row_count(e.rows)):
        neighbours[edge.a].append(edge)
        neighbours[edge.b].append(edge)
    number, queue = {-1: len(scene.bodies)}, deque([-1])
    result = Layout([], [], [], [])

    def visit(body: int, parent: int, edge: Edge | None) -> None:
        number[body] = len(result.order)
        result.order.append(body)
        result.parent.append(number[parent])
        result.tree_edge.append(edge)
        queue.append(body)

    for root in range(-1, len(scene.bodies)):
        if root not in number:
            visit(root, -1, None)
        while queue:
            here = queue.popleft()
            for edge in neighbours[here]:
                there = edge.b if edge.a == here else edge.a
                if there not in number:
                    visit(there, here, edge)
    used = set(map(id, result.tree_edge))
    result.closures = [edge for edge in every if id(edge) not in used]
    return result
