"""One state of a joint tree, compiled: world poses, and forces reduced to the tree's coordinates.

What JointTree.poses and JointTree.project do for histories, for the right-hand sides of engines, which ask
one state at a time; a test holds the two together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cross_checks.workshop.planar_tree import JointTree
from mbs_ref.kernels.jit import strict_jit

REVOLUTE, PRISMATIC, WELD, FREE, FREE_POINT = range(5)
KINDS = {"revolute": REVOLUTE, "prismatic": PRISMATIC, "weld": WELD, "free": FREE, "free_point": FREE_POINT}


class TreeArrays(NamedTuple):
    """A joint tree as compiled code takes it; edges stand after those of their parents, ground is the last body."""

    body: np.ndarray  # (n_edges,)
    parent: np.ndarray  # (n_edges,)
    kind: np.ndarray  # (n_edges,)
    start: np.ndarray  # (n_edges,) first coordinate
    point: np.ndarray  # (n_edges, 2) m, world at t = 0
    axis: np.ndarray  # (n_edges, 2) unit, world at t = 0
    position: np.ndarray  # (n_bodies + 1, 2) m at t = 0
    angle: np.ndarray  # (n_bodies + 1,) rad at t = 0
    turning: np.ndarray  # (n_bodies,) 0 for point masses
    size: int  # coordinates


def arrays_of(tree: JointTree) -> TreeArrays:
    """Return the tree's numbers."""
    ground = len(tree.scene.bodies)
    edges = tree.edges
    return TreeArrays(
        np.array([e.body for e in edges], dtype=np.int64),
        np.array([e.parent if e.parent >= 0 else ground for e in edges], dtype=np.int64),
        np.array([KINDS[e.kind] for e in edges], dtype=np.int64), np.array([e.start for e in edges], dtype=np.int64),
        np.array([e.point for e in edges], dtype=float).reshape(-1, 2),
        np.array([e.axis for e in edges], dtype=float).reshape(-1, 2),
        np.array(tree.position, dtype=float), np.array(tree.angle, dtype=float), np.array(tree.turning, dtype=float),
        tree.size,
    )  # fmt: skip


@strict_jit
def _rotated(turn, x, y):
    c, s = np.cos(turn), np.sin(turn)
    return c * x - s * y, s * x + c * y


@strict_jit
def frames(tree, q):
    """Return the turn of each body's frame since t = 0, (n_bodies + 1,) rad; ground's is 0."""
    turn = np.zeros(tree.angle.shape[0])
    for e in range(tree.body.shape[0]):
        kind = tree.kind[e]
        own = q[tree.start[e]] if kind == REVOLUTE else (q[tree.start[e] + 2] if kind == FREE else 0.0)
        turn[tree.body[e]] = turn[tree.parent[e]] + own
    return turn


@strict_jit
def motion_of(tree, q, v):
    """Return poses and velocities (n_bodies, 3) of coordinates and rates (n_q,): m, m, rad."""
    n = tree.turning.shape[0]
    pose, rate = np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    turn, spin = frames(tree, q), frames(tree, v)
    for e in range(tree.body.shape[0]):
        b, p, s, kind = tree.body[e], tree.parent[e], tree.start[e], tree.kind[e]
        if kind in (FREE, FREE_POINT):
            for k in range(2):
                pose[b, k] = tree.position[b, k] + q[s + k]
                rate[b, k] = v[s + k]
            continue
        ax, ay = _rotated(turn[p], tree.point[e, 0] - tree.position[p, 0], tree.point[e, 1] - tree.position[p, 1])
        if kind == PRISMATIC:
            ux, uy = _rotated(turn[p], tree.axis[e, 0], tree.axis[e, 1])
            ax, ay = ax + ux * q[s], ay + uy * q[s]
            rate[b, 0], rate[b, 1] = ux * v[s], uy * v[s]
        bx, by = _rotated(turn[b], tree.position[b, 0] - tree.point[e, 0], tree.position[b, 1] - tree.point[e, 1])
        pose[b, 0], pose[b, 1] = pose[p, 0] + ax + bx, pose[p, 1] + ay + by
        rate[b, 0] += rate[p, 0] - spin[p] * ay - spin[b] * by
        rate[b, 1] += rate[p, 1] + spin[p] * ax + spin[b] * bx
    for b in range(n):
        pose[b, 2], rate[b, 2] = (tree.angle[b] + turn[b]) * tree.turning[b], spin[b] * tree.turning[b]
    return pose[:n], rate[:n]


@strict_jit
def project(tree, q, pose, forces):
    """Return the generalized forces (n_q,) of forces (n_bodies, 3) at the centres of mass: N, N, N m."""
    n = tree.turning.shape[0]
    turn = frames(tree, q)
    wrench = np.zeros((n + 1, 3))  # about the world's origin, of a body and all it carries
    for b in range(n):
        wrench[b, 0], wrench[b, 1] = forces[b, 0], forces[b, 1]
        wrench[b, 2] = forces[b, 2] * tree.turning[b] + pose[b, 0] * forces[b, 1] - pose[b, 1] * forces[b, 0]
    generalized = np.zeros(tree.size)
    for e in range(tree.body.shape[0] - 1, -1, -1):
        b, p, s, kind = tree.body[e], tree.parent[e], tree.start[e], tree.kind[e]
        if kind == PRISMATIC:
            ux, uy = _rotated(turn[p], tree.axis[e, 0], tree.axis[e, 1])
            generalized[s] = ux * wrench[b, 0] + uy * wrench[b, 1]
        elif kind != WELD:
            bx, by = _rotated(turn[b], tree.point[e, 0] - tree.position[b, 0], tree.point[e, 1] - tree.position[b, 1])
            about = wrench[b, 2] - (pose[b, 0] + bx) * wrench[b, 1] + (pose[b, 1] + by) * wrench[b, 0]
            if kind == REVOLUTE:
                generalized[s] = about
            else:
                generalized[s], generalized[s + 1] = wrench[b, 0], wrench[b, 1]
                if kind == FREE:
                    generalized[s + 2] = about
        for k in range(3):
            wrench[p, k] += wrench[b, k]
    return generalized
