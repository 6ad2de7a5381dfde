"""Bodies on spherical joints: Newton's and Euler's equations, and Hamilton's, in absolute orientations.

The centre of body i is r_i = o_i + sum_j A_j c_ij with constant c_ij. With d_ij = A_j c_ij its velocity is
sum_j omega_j x d_ij: the angular velocities are free, and no constraint is left.
"""

from dataclasses import dataclass

import numpy as np

from cross_checks.truths.made_by import Formulation
from cross_checks.truths.made_by.mechanisms.rod_chain import solve
from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical, symmetric
from mbs_ref.scene.euler_parameters import rotation_matrices

EXTENDED_UP_TO = 4  # bodies; beyond, an elimination in Python takes minutes


@dataclass(frozen=True)
class SphericalTree:
    """A tree of spherical joints that hangs on ground."""

    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (n, 3, 3) kg m^2 about the centres, body axes
    gravity: np.ndarray  # (3,) m/s^2
    pivot: np.ndarray  # (n, 3) m, o_i
    arms: np.ndarray  # (n, n, 3) m, c_ij
    theta: np.ndarray  # (n, 4) Euler parameters at t = 0
    omega: np.ndarray  # (n, 3) rad/s at t = 0, world axes

    def turned(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return d (n, n, 3), the inertias in world axes and the mass matrix (3 n, 3 n) of the angular velocities."""
        n = len(self.mass)
        axes = rotation_matrices(theta)
        d = np.einsum("jab,ijb->ija", axes, self.arms)
        inertia = axes @ self.inertia @ np.swapaxes(axes, 1, 2)
        weighed = self.mass[:, None, None] * d
        blocks = -np.einsum("ika,ijb->jakb", d, weighed)
        inner = np.einsum("ija,ika->jk", d, weighed)
        for a in range(3):
            blocks[:, a, :, a] += inner
        for j in range(n):
            blocks[j, :, j, :] += inertia[j]
        return d, inertia, blocks.reshape(3 * n, 3 * n)

    def poses(self, t, y) -> tuple[np.ndarray, np.ndarray]:
        """Return the centres (n, 3) and Euler parameters (n, 4)."""
        theta = y[: 4 * len(self.mass)].reshape(-1, 4)
        return self.pivot + np.einsum("jab,ijb->ia", rotation_matrices(theta), self.arms), theta


def spherical_tree(scene: Scene) -> SphericalTree:
    """Read a scene whose joints are spherical, each body after its parent."""
    n = len(scene.bodies)
    bodies = [body for body in scene.bodies if isinstance(body, SpatialBody)]
    theta = np.array([body.orientation for body in bodies])
    back = np.swapaxes(rotation_matrices(theta), 1, 2)
    centre = np.array([body.position for body in bodies])
    pivot, arms = np.zeros((n, 3)), np.zeros((n, n, 3))
    for joint in (joint for joint in scene.joints if isinstance(joint, Spherical)):
        a, b, point = joint.body_a, scene.body_index(joint.body_b), np.array(joint.point)
        if a == GROUND:
            pivot[b] = point
        else:
            k = scene.body_index(a)
            pivot[b], arms[b] = pivot[k], arms[k]
            arms[b, k] = arms[k, k] + back[k] @ (point - centre[k])
        arms[b, b] = back[b] @ (centre[b] - point)
    return SphericalTree(
        np.array([b.mass for b in bodies]), np.array([symmetric(b.inertia) for b in bodies]), np.array(scene.gravity),
        pivot, arms, theta, np.array([b.angular_velocity for b in bodies]),
    )  # fmt: skip


def newton_euler(tree: SphericalTree) -> Formulation:
    """Return y = (theta, omega): moments of forces less those of inertia, about each body's joint."""

    def derivative(t, y):
        theta, omega = _split(tree, y)
        d, inertia, matrix = tree.turned(theta)
        inward = np.sum(np.cross(omega, np.cross(omega, d)), axis=1) - tree.gravity
        moment = np.cross(d, tree.mass[:, None, None] * inward[:, None]).sum(axis=0)
        moment = moment + np.cross(omega, np.einsum("jab,jb->ja", inertia, omega))
        return np.concatenate([_rates(theta, omega).ravel(), solve(matrix, -moment.ravel())])

    return Formulation(derivative, np.concatenate([tree.theta.ravel(), tree.omega.ravel()]), tree.poses)


def hamilton(tree: SphericalTree) -> Formulation:
    """Return y = (theta, p) with p = M omega: p_j' = sum_i m_i [(omega_j x d_ij) x v_i + d_ij x g]."""

    def derivative(t, y):
        theta, p = _split(tree, y)
        d, _, matrix = tree.turned(theta)
        omega = solve(matrix, p.ravel()).reshape(-1, 3)
        parts = np.cross(omega, d)
        velocity = parts.sum(axis=1)
        pull = np.cross(parts, velocity[:, None]) + np.cross(d, tree.gravity.astype(y.dtype))
        change = np.einsum("i,ija->ja", tree.mass, pull)
        return np.concatenate([_rates(theta, omega).ravel(), change.ravel()])

    p = tree.turned(tree.theta)[2] @ tree.omega.ravel()
    return Formulation(derivative, np.concatenate([tree.theta.ravel(), p]), tree.poses)


def _split(tree: SphericalTree, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n = 4 * len(tree.mass)
    return y[:n].reshape(-1, 4), y[n:].reshape(-1, 3)


def _rates(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return theta' = E^T omega / 2."""
    e0, e = theta[:, :1], theta[:, 1:]
    return 0.5 * np.concatenate([-np.sum(e * omega, axis=1, keepdims=True), e0 * omega + np.cross(omega, e)], axis=1)
