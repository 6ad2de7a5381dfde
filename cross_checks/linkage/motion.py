"""One state of a linkage, compiled: the motion of its bodies, forces projected on its freedoms, joint reactions.

Coordinates stand link after link in Pinocchio's convention. A ball joint has a quaternion x, y, z, w and an angular
velocity in the link's axes. A free body has its displacement before that, and its velocity in the link's axes.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from cross_checks.linkage.links import ALONE, Linkage, Z, lifted
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.kernels.spatial.marks import add, cross, dot, minus, plus, put, times, triple
from mbs_ref.scene import GROUND
from mbs_ref.scene.euler_parameters import conjugate, from_axis_angle, product, rotation_matrices

SLIDE, TURN, BALL, FREE = range(4)
KINDS = {"slide": SLIDE, "turn": TURN, "ball": BALL, "free": FREE}
SIZES = {"ball": (4, 3), "free": (7, 6)}  # coordinates and rates; of all others 1 and 1


class LinkArrays(NamedTuple):
    """A linkage as compiled code reads it; links stand after their parents, ground is the last body."""

    body: np.ndarray  # (n_links,)
    parent: np.ndarray  # (n_links,)
    centre: np.ndarray  # (n_links, 3) m, the centre of mass from the link's origin
    first: np.ndarray  # (n_links + 1,) first freedom of each link
    origin: np.ndarray  # (n_links + 1, 3) m, of each body's link at t = 0
    kind: np.ndarray  # (n_freedoms,)
    axis: np.ndarray  # (n_freedoms, 3) unit, world at t = 0
    place: np.ndarray  # (n_freedoms,) first coordinate
    rate: np.ndarray  # (n_freedoms + 1,) first rate; the last entry is their number


class Motion(NamedTuple):
    """The motion of all bodies, in the scene's order; a history has the time as its first axis."""

    position: np.ndarray  # (n_bodies, 3) m, centres of mass
    turn: np.ndarray  # (n_bodies, 4) Euler parameters of the turns since t = 0
    velocity: np.ndarray  # (n_bodies, 3) m/s
    omega: np.ndarray  # (n_bodies, 3) rad/s, world axes
    angle: np.ndarray  # (n_bodies,) rad since t = 0, beyond one turn; of planar scenes


def arrays_of(linkage: Linkage) -> LinkArrays:
    """Return the numbers of a linkage."""
    links, ground = linkage.links, len(linkage.links)
    freedoms = [freedom for link in links for freedom in link.freedoms]
    sizes = np.array([SIZES.get(kind, (1, 1)) for kind, _ in freedoms], dtype=np.int64).reshape(-1, 2)
    starts = np.concatenate((np.zeros((1, 2), dtype=np.int64), np.cumsum(sizes, axis=0)))
    return LinkArrays(
        np.array([link.body for link in links]), np.array([link.parent % (ground + 1) for link in links]),
        np.array([link.centre for link in links]), np.cumsum([0, *(len(link.freedoms) for link in links)]),
        np.array([*(link.origin for link in linkage.of_body), np.zeros(3)]),
        np.array([KINDS[kind] for kind, _ in freedoms], dtype=np.int64),
        np.array([axis for _, axis in freedoms]).reshape(-1, 3),
        starts[:-1, 0].copy(), starts[:, 1].copy(),
    )  # fmt: skip


@strict_jit
def rotated(theta, u):
    """Return a vector turned by Euler parameters of norm one."""
    e = theta[1], theta[2], theta[3]
    twice = times(2.0, cross(e, u))
    return plus(u, plus(times(theta[0], twice), cross(e, twice)))


@strict_jit
def composed(p, q):
    """Return the Euler parameters of the turn q followed by p."""
    e, f = (p[1], p[2], p[3]), (q[1], q[2], q[3])
    vector = plus(plus(times(p[0], f), times(q[0], e)), cross(e, f))
    return p[0] * q[0] - dot(e, f), vector[0], vector[1], vector[2]


@strict_jit
def motion_of(tree, q, v):
    """Return the motion of coordinates and rates, and the axes of slides and turns (n_freedoms, 3) in the world."""
    n = tree.body.shape[0]
    origin, speed, omega = np.zeros((n + 1, 3)), np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    theta, angle = np.zeros((n + 1, 4)), np.zeros(n + 1)
    position, velocity = np.empty((n, 3)), np.empty((n, 3))
    axes = np.zeros((tree.kind.shape[0], 3))
    theta[n, 0] = 1.0
    for e in range(n):
        b, p = tree.body[e], tree.parent[e]
        turn = theta[p, 0], theta[p, 1], theta[p, 2], theta[p, 3]
        arm = rotated(turn, minus(tree.origin[b], tree.origin[p]))
        spin = triple(omega[p], 0)
        x, u = plus(origin[p], arm), plus(speed[p], cross(spin, arm))
        angle[b] = angle[p]
        for f in range(tree.first[e], tree.first[e + 1]):
            i, j, kind = tree.place[f], tree.rate[f], tree.kind[f]
            if kind == SLIDE:
                axis = rotated(turn, tree.axis[f])
                along = times(q[i], axis)
                x, u = plus(x, along), plus(u, plus(times(v[j], axis), cross(spin, along)))
                put(axes[f], 0, axis)
            elif kind == TURN:
                axis = rotated(turn, tree.axis[f])
                half = times(np.sin(0.5 * q[i]), tree.axis[f])
                turn = composed(turn, (np.cos(0.5 * q[i]), half[0], half[1], half[2]))
                spin = plus(spin, times(v[j], axis))
                angle[b] += q[i]
                put(axes[f], 0, axis)
            else:
                if kind == FREE:
                    x, i = plus(x, triple(q, i)), i + 3
                turn = composed(turn, (q[i + 3], q[i], q[i + 1], q[i + 2]))
                if kind == FREE:
                    u, j = plus(u, rotated(turn, triple(v, j))), j + 3
                spin = plus(spin, rotated(turn, triple(v, j)))
        centre = rotated(turn, tree.centre[e])
        put(origin[b], 0, x)
        put(speed[b], 0, u)
        put(omega[b], 0, spin)
        put(position[b], 0, plus(x, centre))
        put(velocity[b], 0, plus(u, cross(spin, centre)))
        theta[b, 0], theta[b, 1], theta[b, 2], theta[b, 3] = turn
    return Motion(position, theta[:n], velocity, omega[:n], angle[:n]), axes


@strict_jit
def project(tree, motion, axes, wrench):
    """Return the generalized forces (n_v,) of forces and torques (n_bodies, 6) at the centres of mass: N, N m."""
    n = tree.body.shape[0]
    total = np.zeros((n + 1, 6))  # about the world's origin, of a body and all it carries
    for b in range(n):
        put(total[b], 0, wrench[b])
        put(total[b], 3, plus(triple(wrench[b], 3), cross(motion.position[b], wrench[b])))
    generalized = np.zeros(tree.rate[-1])
    for e in range(n - 1, -1, -1):
        b, p = tree.body[e], tree.parent[e]
        turn = motion.turn[b]
        force = triple(total[b], 0)
        pivot = minus(motion.position[b], rotated(turn, tree.centre[e]))
        about = minus(triple(total[b], 3), cross(pivot, force))
        for f in range(tree.first[e], tree.first[e + 1]):
            j, kind = tree.rate[f], tree.kind[f]
            if kind == SLIDE:
                generalized[j] = dot(axes[f], force)
            elif kind == TURN:
                generalized[j] = dot(axes[f], about)
            else:
                back = turn[0], -turn[1], -turn[2], -turn[3]
                if kind == FREE:
                    put(generalized, j, rotated(back, force))
                    j += 3
                put(generalized, j, rotated(back, about))
        add(total[p], 0, force)
        add(total[p], 3, triple(total[b], 3))
    return generalized


def poses_of(linkage: Linkage, motions: Iterable[Motion]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return world poses and velocities of the scene's dimension over time; particles have no orientation."""
    motion = Motion(*(np.array(part) for part in zip(*motions, strict=True)))
    rigid = linkage.rigid
    if linkage.scene.dimension == 2:
        angle = (linkage.angle + motion.angle) * rigid
        return motion.position[..., :2], angle, motion.velocity[..., :2], motion.omega[..., 2] * rigid
    theta = np.where(rigid[:, None] == 1.0, product(motion.turn, linkage.theta), ALONE)
    return motion.position, theta, motion.velocity, motion.omega * rigid[:, None]


# What a trajectory holds of force and torque in space, by dimension; in the plane force in x and y, torque about z.
COMPONENTS = {2: [0, 1, 5], 3: [0, 1, 2, 3, 4, 5]}


def tree_reactions(linkage: Linkage, poses: tuple[np.ndarray, ...], wrench: np.ndarray) -> dict[str, np.ndarray]:
    """Return the tree joints' force on body b (N) and torque (N m) about its mark: (n_t, 3 or 6), world axes.

    poses are position, orientation, velocity and angular velocity; wrench (n_t, n_bodies, 6) is what a body gets
    from its parent: force (N) and moment about the world's origin (N m).
    """
    joints: dict[str, Any] = {joint.name: joint for joint in linkage.scene.joints}
    held = [(link, joints[link.joint]) for link in linkage.links if link.joint is not None]
    return {
        joint.name: about(linkage, poses, joint, (1.0 if link.name == joint.body_b else -1.0) * wrench[:, link.body])
        for link, joint in held
    }


def about(linkage: Linkage, poses: tuple[np.ndarray, ...], joint, wrench: np.ndarray) -> np.ndarray:
    """Return force and torque about a joint's mark of a wrench (n_t, 6) about the world's origin: (n_t, 3 or 6)."""
    moved = wrench[:, 3:] - np.cross(_mark(linkage, poses, joint), wrench[:, :3])
    return np.concatenate((wrench[:, :3], moved), axis=1)[:, COMPONENTS[linkage.scene.dimension]]


def _mark(linkage: Linkage, poses: tuple[np.ndarray, ...], joint) -> np.ndarray:
    """Return where the joint's mark on body b is, (n_t, 3) m; on body a where b is ground."""
    end = "body_a" if joint.body_b == GROUND else "body_b"
    k = linkage.scene.body_index(getattr(joint, end))
    position, orientation = poses[0][:, k], poses[1][:, k]
    if linkage.scene.dimension == 2:
        turn = from_axis_angle(Z, (orientation - linkage.angle[k]) * linkage.rigid[k])
        position = np.column_stack((position, np.zeros(len(position))))
    else:
        turn = product(orientation, conjugate(linkage.theta[k]))
    return position + rotation_matrices(turn) @ (lifted(joint.mark(end)) - lifted(linkage.scene.bodies[k].position))
