"""The spanning tree of a spatial scene, for engines of minimal coordinates."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.euler_parameters import conjugate, product, rotation_matrices
from mbs_ref.scene import DRIVES, Distance, PointOnPlane, Scene, SpatialBody

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


def spatial_tree(scene: Scene) -> SpatialTree:
    """Span the joint graph breadth first from ground; rods and planes always close loops."""
    index = {name: k for k, name in enumerate(scene.body_names)} | {"ground": FIXED}
    neighbours: dict[int, list[tuple[int, Any]]] = {k: [] for k in index.values()}
    for joint in scene.joints:
        if not isinstance(joint, (Distance, PointOnPlane, *DRIVES)):
            a, b = index[joint.body_a], index[joint.body_b]
            neighbours[a].append((b, joint))
            neighbours[b].append((a, joint))
    edges: list[SpatialEdge] = []
    seen: set[int] = set()
    used: set[str] = set()
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
                    used.add(joint.name)
                    edges.append(SpatialEdge(here, there, joint))
                    queue.append(there)
    closures = tuple(j for j in scene.joints if j.name not in used and not isinstance(j, DRIVES))
    return SpatialTree(scene, tuple(edges), closures)
