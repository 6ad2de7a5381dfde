"""The spanning tree of a spatial scene, for engines of minimal coordinates."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.scene import Cylindrical, Drive, Prismatic, Scene, SpatialBody, Universal
from mbs_ref.scene.euler_parameters import conjugate, product, rotation_matrices

FIXED = -1  # ground
ALONE = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class SpatialEdge:
    """One body on its parent; a body without a joint is free."""

    parent: int  # scene index, FIXED for ground
    body: int
    joint: Any | None


@dataclass(frozen=True)
class SpatialTree:
    """Parents come before their children; closures are the joints left over."""

    scene: Scene
    edges: tuple[SpatialEdge, ...]
    closures: tuple[Any, ...]

    def theta(self, k: int) -> np.ndarray:
        body = self.scene.bodies[k] if k != FIXED else None
        return np.array(body.orientation) if isinstance(body, SpatialBody) else ALONE

    def axes(self, k: int) -> np.ndarray:
        return rotation_matrices(self.theta(k))

    def centre(self, k: int) -> np.ndarray:
        return np.array(self.scene.bodies[k].position) if k != FIXED else np.zeros(3)

    def seen_from(self, parent: int, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return place and orientation of body k's frame in its parent's, at t = 0."""
        place = self.axes(parent).T @ (self.centre(k) - self.centre(parent))
        return place, product(conjugate(self.theta(parent)), self.theta(k))

    def local(self, k: int, point) -> np.ndarray:
        """Return a world point at t = 0 in body k's axes."""
        return self.axes(k).T @ (np.asarray(point, dtype=float) - self.centre(k))

    def spin(self, k: int) -> np.ndarray:
        body = self.scene.bodies[k] if k != FIXED else None
        return np.array(body.angular_velocity) if isinstance(body, SpatialBody) else np.zeros(3)

    def velocity(self, k: int, point) -> np.ndarray:
        """Return the velocity of the body's point that is at a world point at t = 0."""
        if k == FIXED:
            return np.zeros(3)
        return np.array(self.scene.bodies[k].velocity) + np.cross(self.spin(k), np.asarray(point) - self.centre(k))

    def relative_spin(self, edge: SpatialEdge) -> np.ndarray:
        return self.spin(edge.body) - self.spin(edge.parent)


HARD_TO_CLOSE = (Universal, Prismatic, Cylindrical)  # engines close loops by points and frames


def depth_first(tree: SpatialTree) -> list[SpatialEdge]:
    """Return the edges with every subtree in one piece, children in the order of the tree.

    MuJoCo numbers bodies so; Pinocchio takes it for granted, and gives a wrong mass matrix otherwise.
    """
    children: dict[int, list[SpatialEdge]] = {}
    for edge in tree.edges:
        children.setdefault(edge.parent, []).append(edge)
    result: list[SpatialEdge] = []
    stack = children.get(FIXED, [])[::-1]
    while stack:
        edge = stack.pop()
        result.append(edge)
        stack += children.get(edge.body, [])[::-1]
    return result


def spatial_tree(scene: Scene) -> SpatialTree:
    """Span the joint graph breadth first from ground; joints of one row, rods and planes, always close loops.

    Slides and universal joints go into the tree wherever another joint of the loop can close it.
    """
    joints = [joint for joint in scene.joints if sum(row.count for row in joint.rows(3)) > 1]
    near = {joint.name for joint in _spanned(scene, joints)[1]}
    rank = {j.name: 0 if isinstance(j, HARD_TO_CLOSE) else 1 + (j.name not in near) for j in joints}
    used = _forest(scene, sorted(joints, key=lambda joint: rank[joint.name]))
    edges, _ = _spanned(scene, [joint for joint in joints if joint.name in used])
    closures = (j for j in scene.joints if j.name not in used and not isinstance(j, Drive))
    return SpatialTree(scene, edges, tuple(closures))


def _forest(scene: Scene, joints: list[Any]) -> set[str]:
    """Return the names of the joints, taken in this order, that close no loop (Kruskal 1956)."""
    root = {name: name for name in ("ground", *scene.body_names)}

    def find(name: str) -> str:
        while root[name] != name:
            root[name] = root[root[name]]
            name = root[name]
        return name

    kept = set()
    for joint in joints:
        a, b = map(find, joint.ends)
        if a != b:
            root[a] = b
            kept.add(joint.name)
    return kept


def _spanned(scene: Scene, joints: list[Any]) -> tuple[tuple[SpatialEdge, ...], list[Any]]:
    """Span the graph of some joints breadth first from ground; return the edges and the joints in them."""
    index = {name: k for k, name in enumerate(scene.body_names)} | {"ground": FIXED}
    neighbours: dict[int, list[tuple[int, Any]]] = {k: [] for k in index.values()}
    for joint in joints:
        a, b = (index[end] for end in joint.ends)
        neighbours[a].append((b, joint))
        neighbours[b].append((a, joint))
    edges: list[SpatialEdge] = []
    seen: set[int] = set()
    for root in (FIXED, *range(len(scene.bodies))):
        if root in seen:
            continue
        if root != FIXED:
            edges.append(SpatialEdge(FIXED, root, None))
        seen.add(root)
        queue = deque([root])
        while queue:
            here = queue.popleft()
            for there, joint in neighbours[here]:
                if there not in seen:
                    seen.add(there)
                    edges.append(SpatialEdge(here, there, joint))
                    queue.append(there)
    return tuple(edges), [edge.joint for edge in edges if edge.joint is not None]
