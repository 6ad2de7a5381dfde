"""The spanning tree of a scene's joints, for engines in minimal coordinates."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass

from mbs_ref.scene import GROUND, PointMass, Scene
from mbs_ref.scene.joints import Cylindrical, Distance, PointOnPlane, Prismatic, Revolute, Spherical, Universal, Weld

FIXED = -1  # the index of ground
Holding = Revolute | Prismatic | Weld | Spherical | Universal | Cylindrical | Distance | PointOnPlane
CLOSES_EASILY = Revolute | Spherical | Distance  # engines close loops by shared points and by rods


@dataclass(frozen=True)
class Edge:
    """One body on its parent; a body without a joint is free."""

    body: int
    parent: int  # FIXED for ground
    joint: Holding | None


def spanning_tree(scene: Scene) -> tuple[tuple[Edge, ...], tuple[Holding, ...]]:
    """Return the edges, each subtree in one piece, and the joints outside of the tree, which close loops.

    The tree contains as many slides, welds and universal joints as possible (Prim 1957), and is as shallow as ties
    allow. MuJoCo numbers bodies depth first; Pinocchio gives a wrong mass matrix for any other order.
    """
    index = {GROUND: FIXED, **{name: k for k, name in enumerate(scene.body_names)}}
    holding = [joint for joint in scene.joints if isinstance(joint, Holding)]
    neighbours: dict[int, list[tuple[int, Holding]]] = {k: [] for k in range(FIXED, len(scene.bodies))}
    for joint in holding:
        a, b = (index[end] for end in joint.ends)
        for here, there in ((a, b), (b, a)):
            if _can_hang(scene, joint, there):
                neighbours[here].append((there, joint))
    children: dict[int, list[Edge]] = {k: [] for k in neighbours}
    for edge in _prim(neighbours):
        children[edge.parent].append(edge)
    edges = tuple(_depth_first(children, FIXED))
    used = {edge.joint.name for edge in edges if edge.joint is not None}
    return edges, tuple(joint for joint in holding if joint.name not in used)


def _can_hang(scene: Scene, joint: Holding, body: int) -> bool:
    """Return whether the joint alone holds the body; a rod in the plane turns a particle about its other end."""
    if isinstance(joint, Distance):
        particle = body != FIXED and isinstance(scene.bodies[body], PointMass)
        return scene.dimension == 2 and particle and joint.point_a != joint.point_b
    return not isinstance(joint, PointOnPlane)


def _prim(neighbours: dict[int, list[tuple[int, Holding]]]) -> Iterator[Edge]:
    """Yield the edges; a component without ground starts from its first body, which is free."""
    seen: set[int] = set()
    count = 0
    for root in neighbours:
        heap: list = [(False, 0, 0, Edge(root, FIXED, None))]
        while heap:
            _, depth, _, edge = heapq.heappop(heap)
            if edge.body in seen:
                continue
            seen.add(edge.body)
            if edge.body != FIXED:
                yield edge
            for other, joint in neighbours[edge.body]:
                count += 1
                heapq.heappush(
                    heap, (isinstance(joint, CLOSES_EASILY), depth + 1, count, Edge(other, edge.body, joint))
                )


def _depth_first(children: dict[int, list[Edge]], body: int) -> Iterator[Edge]:
    stack = children[body][::-1]
    while stack:
        edge = stack.pop()
        yield edge
        stack += children[edge.body][::-1]
