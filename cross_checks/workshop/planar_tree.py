"""Planar scenes in relative coordinates: a spanning tree of joints, its rates and its kinematics.

Every engine in minimal coordinates shares this: which joint hangs a body on which parent, which
joints are left to close loops, and how relative coordinates (zero at t = 0) become world poses.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from mbs_ref.scene import GROUND, Distance, PlanarBody, PointMass, Prismatic, Revolute, Scene, Weld

Kind = Literal["revolute", "prismatic", "weld", "free", "free_point"]
TreeJoint = Revolute | Prismatic | Weld | Distance  # what may hang a body on another, or close a loop
SIZE: dict[str, int] = {"revolute": 1, "prismatic": 1, "weld": 0, "free": 3, "free_point": 2}
FIXED = -1  # the index of ground


@dataclass(frozen=True)
class Edge:
    """How a body hangs on its parent; coordinates count from the poses at t = 0."""

    body: int
    parent: int  # FIXED for ground
    kind: Kind
    joint: str | None  # None where the body is free
    point: np.ndarray  # (2,) m, world at t = 0
    axis: np.ndarray  # (2,) unit, world at t = 0; prismatic only
    start: int  # first coordinate
    size: int


@dataclass(frozen=True)
class JointTree:
    """A scene's bodies in depth-first order, each after its parent."""

    scene: Scene
    edges: tuple[Edge, ...]
    closures: tuple[TreeJoint, ...]  # revolute, prismatic, weld and distance joints outside the tree

    @property
    def size(self) -> int:
        """The number of relative coordinates."""
        return sum(edge.size for edge in self.edges)

    @cached_property
    def position(self) -> np.ndarray:  # (n_bodies + 1, 2) m at t = 0; the last row is ground
        return np.array([*(body.position for body in self.scene.bodies), (0.0, 0.0)])

    @cached_property
    def angle(self) -> np.ndarray:  # (n_bodies + 1,) rad at t = 0, of the frame a body carries
        """A point mass turns with the body it is pinned to, and starts at zero."""
        return np.array([*(b.angle if isinstance(b, PlanarBody) else 0.0 for b in self.scene.bodies), 0.0])

    @cached_property
    def turning(self) -> np.ndarray:  # (n_bodies,) 1 where a body has an orientation, 0 for point masses
        return np.array([float(isinstance(body, PlanarBody)) for body in self.scene.bodies])

    @cached_property
    def edge_of(self) -> dict[int, Edge]:
        return {edge.body: edge for edge in self.edges}

    def path(self, body: int) -> list[Edge]:
        """Return the edges from the body down to ground."""
        result = []
        while body != FIXED:
            result.append(self.edge_of[body])
            body = result[-1].parent
        return result

    def rates(self) -> np.ndarray:
        """Return the coordinates' rates at t = 0, (n_q,), from the bodies' own velocities."""
        v = np.array([*(body.velocity for body in self.scene.bodies), (0.0, 0.0)])
        w = np.array([*(getattr(b, "angular_velocity", 0.0) for b in self.scene.bodies), 0.0])
        rates = np.zeros(self.size)
        for edge in self.edges:
            if not self.turning[edge.body]:
                w[edge.body] = self._particle_spin(edge, v, w)
            rates[edge.start : edge.start + edge.size] = self._edge_rates(edge, v, w, edge.body, edge.parent)
        return rates

    def _particle_spin(self, edge: Edge, v: np.ndarray, w: np.ndarray) -> float:
        """Return the rate (rad/s) of the frame a point mass carries: its rod's, or its parent's."""
        b, p = edge.body, edge.parent
        if edge.kind == "revolute":
            rod = self.position[b] - edge.point
            hook = v[p] + w[p] * turned(edge.point - self.position[p])
            return float((v[b] - hook) @ turned(rod) / (rod @ rod))
        return float(w[p])  # ground's, of a free one

    def _edge_rates(self, edge: Edge, v: np.ndarray, w: np.ndarray, b: int, p: int) -> list[float]:
        if edge.kind == "revolute":
            return [w[b] - w[p]]
        if edge.kind == "prismatic":
            at_point = [v[k] + w[k] * turned(edge.point - self.position[k]) for k in (b, p)]
            return [float(edge.axis @ (at_point[0] - at_point[1]))]
        return [*v[b], w[b]][: edge.size]

    @np.errstate(over="ignore", invalid="ignore")
    def poses(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return position (n_t, n, 2), angle (n_t, n), velocity and angular velocity of coordinates (n_t, n_q).

        Coordinates of a run that diverged give NaN or infinite poses, by which the judge tells.
        """
        n = len(self.scene.bodies)
        position, velocity = np.zeros((2, len(q), n + 1, 2))
        angle, rate = np.zeros((2, len(q), n + 1))
        for edge in self.edges:
            b, p, s = edge.body, edge.parent, edge.start
            spin = {"revolute": (q[:, s : s + 1], v[:, s : s + 1]), "free": (q[:, s + 2 : s + 3], v[:, s + 2 : s + 3])}
            turn, turn_rate = (sum(x.T) for x in spin.get(edge.kind, (np.zeros((len(q), 1)),) * 2))
            # a frame's turn since t = 0 is what its points follow
            angle[:, b], rate[:, b] = angle[:, p] + turn, rate[:, p] + turn_rate
            if edge.kind in ("free", "free_point"):
                position[:, b] = self.position[b] + q[:, s : s + 2]
                velocity[:, b] = v[:, s : s + 2]
                continue
            arm = rotated(angle[:, p], edge.point - self.position[p])
            if edge.kind == "prismatic":
                along = rotated(angle[:, p], edge.axis)
                arm = arm + along * q[:, s : s + 1]
                velocity[:, b] = along * v[:, s : s + 1]
            back = rotated(angle[:, b], self.position[b] - edge.point)
            position[:, b] = (position[:, p] if p != FIXED else 0.0) + arm + back
            velocity[:, b] += velocity[:, p] + rate[:, p, None] * turned(arm) + rate[:, b, None] * turned(back)
        turning = self.turning
        return position[:, :n], (self.angle[:n] + angle[:, :n]) * turning, velocity[:, :n], rate[:, :n] * turning

    def project(self, q: np.ndarray, position: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Return the coordinates' generalized forces (n_q,) of forces (n, 3) at the centres of mass: N, N, N m.

        q (n_q,) are the coordinates and position (n, 2) the centres of mass that belong to them. A subtree's
        forces reduce to a force and a moment about the world's origin, taken from the leaves inwards.
        """
        forces = forces * np.column_stack((np.ones((len(forces), 2)), self.turning))
        moment = forces[:, 2] + position[:, 0] * forces[:, 1] - position[:, 1] * forces[:, 0]
        wrench = np.column_stack((forces[:, :2], moment))
        frame = self._frames(q)
        result = np.zeros(self.size)
        for edge in reversed(self.edges):
            result[edge.start : edge.start + edge.size] = self._edge_forces(edge, wrench[edge.body], frame, position)
            if edge.parent != FIXED:
                wrench[edge.parent] += wrench[edge.body]
        return result

    def _frames(self, q: np.ndarray) -> np.ndarray:
        """Return the turn of each body's frame since t = 0, (n + 1,); ground's is 0."""
        turn = np.zeros(len(self.scene.bodies) + 1)
        for edge in self.edges:
            own = q[edge.start + edge.size - 1] if edge.kind in ("revolute", "free") else 0.0
            turn[edge.body] = turn[edge.parent] + own
        return turn

    def _edge_forces(self, edge: Edge, wrench: np.ndarray, turn: np.ndarray, position: np.ndarray) -> list[float]:
        force, moment = wrench[:2], wrench[2]
        if edge.kind == "prismatic":
            return [float(rotated(turn[[edge.parent]], edge.axis)[0] @ force)]
        if edge.kind == "weld":
            return []
        b = edge.body
        pivot = position[b] + rotated(turn[[b]], edge.point - self.position[b])[0]
        about = moment - pivot[0] * force[1] + pivot[1] * force[0]
        return [about] if edge.kind == "revolute" else [*force, about][: edge.size]


def turned(r: np.ndarray) -> np.ndarray:
    """Return vectors (..., 2) turned by +90 degrees, the derivative of a rotation."""
    return np.stack([-r[..., 1], r[..., 0]], axis=-1)


def rotated(angle: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Return a vector (2,) rotated by each angle (n_t,)."""
    return np.cos(angle)[:, None] * r + np.sin(angle)[:, None] * turned(r)


def local(tree: JointTree, body: int, r: np.ndarray) -> np.ndarray:
    """Return a world direction at t = 0 in the body's own axes."""
    c, s = np.cos(tree.angle[body]), np.sin(tree.angle[body])
    return np.array([c * r[0] + s * r[1], c * r[1] - s * r[0]])


def joint_tree(scene: Scene) -> JointTree:
    """Return a spanning tree that keeps every weld and prismatic joint it can (Prim), as shallow as ties allow."""
    neighbours: dict[int, list[tuple[int, TreeJoint]]] = {k: [] for k in range(-1, len(scene.bodies))}
    index = {GROUND: FIXED, **{name: k for k, name in enumerate(scene.body_names)}}
    closable = [j for j in scene.joints if isinstance(j, TreeJoint)]
    for joint in closable:
        a, b = index[joint.body_a], index[joint.body_b]
        if _can_hang(scene, joint, b):
            neighbours[a].append((b, joint))
        if _can_hang(scene, joint, a):
            neighbours[b].append((a, joint))
    chosen = _prim(neighbours)
    children: dict[int, list[int]] = {k: [] for k in neighbours}
    for body, (parent, _) in chosen.items():
        children[parent].append(body)
    used = {joint.name for _, joint in chosen.values() if joint is not None}
    rest = tuple(joint for joint in closable if joint.name not in used)
    return JointTree(scene, _depth_first(scene, chosen, children), rest)


def _can_hang(scene: Scene, joint: TreeJoint, body: int) -> bool:
    """A massless rod carries a particle exactly: the joint is then a pin at the rod's other end."""
    if not isinstance(joint, Distance):
        return True
    return body != FIXED and isinstance(scene.bodies[body], PointMass) and joint.point_a != joint.point_b


def _prim(neighbours: dict[int, list[tuple[int, TreeJoint]]]) -> dict[int, tuple[int, TreeJoint | None]]:
    """Return body -> (parent, joint); a component without ground starts from its first body, free."""
    chosen: dict[int, tuple[int, TreeJoint | None]] = {}
    seen: set[int] = set()
    for root in neighbours:
        if root in seen:
            continue
        heap: list = [(False, 0, 0, root, FIXED, None)]
        count = 0
        while heap:
            _, depth, _, body, parent, joint = heapq.heappop(heap)
            if body in seen:
                continue
            seen.add(body)
            if body != FIXED:
                chosen[body] = (parent, joint)
            for other, link in neighbours[body]:
                count += 1
                heapq.heappush(heap, (isinstance(link, Revolute | Distance), depth + 1, count, other, body, link))
    return chosen


def _depth_first(scene: Scene, chosen: dict, children: dict[int, list[int]]) -> tuple[Edge, ...]:
    """Number the coordinates in preorder, as engines that store subtrees contiguously need."""
    edges: list[Edge] = []
    start, stack = 0, list(reversed(children[FIXED]))
    while stack:
        body = stack.pop()
        parent, joint = chosen[body]
        planar: Any = scene.bodies[body]
        kind = _kind(joint, planar)
        point = _hanging_point(scene, joint, body)
        axis = np.array(joint.axis) if isinstance(joint, Prismatic) else np.zeros(2)
        axis = axis / (np.linalg.norm(axis) or 1.0)
        edges.append(Edge(body, parent, kind, joint.name if joint else None, point, axis, start, SIZE[kind]))
        start += SIZE[kind]
        stack.extend(reversed(children[body]))
    return tuple(edges)


def _hanging_point(scene: Scene, joint: TreeJoint | None, body: int) -> np.ndarray:
    if joint is None:
        return np.array(scene.bodies[body].position)
    if isinstance(joint, Distance):
        return np.array(joint.point_a if scene.body_names[body] == joint.body_b else joint.point_b)
    return np.array(joint.point)


def _kind(joint: TreeJoint | None, body: PlanarBody | PointMass) -> Kind:
    if joint is None:
        return "free" if isinstance(body, PlanarBody) else "free_point"
    if isinstance(joint, Distance):
        return "revolute"
    if isinstance(joint, Revolute) and isinstance(body, PointMass):
        return "weld"  # a particle has no orientation, so a pin holds it still
    return joint.type
