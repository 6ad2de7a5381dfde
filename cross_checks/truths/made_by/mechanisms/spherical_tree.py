"""Bodies on spherical joints: Newton's and Euler's equations, and Hamilton's, in absolute orientations.

The centre of body i is r_i = o_i + sum_j A_j c_ij with constant c_ij. With d_ij = A_j c_ij its velocity is
sum_j omega_j x d_ij: the angular velocities are free, and no constraint is left.

Arrays hold components first.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cross_checks.truths.made_by import Formulation
from cross_checks.truths.made_by.mechanisms.rod_chain import solve
from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical, symmetric
from mbs_ref.scene.euler_parameters import rotation_matrices

EXTENDED_UP_TO = 4  # bodies; beyond, an elimination in Python takes minutes


def _bilinear() -> tuple[np.ndarray, np.ndarray]:
    """Return (A - 1) |theta|^2 / 2 (9, 16) of products theta_i theta_j, and theta' (4, 12) of theta_i omega_j."""
    axes, rates = np.zeros((3, 3, 4, 4)), np.zeros((4, 4, 3))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        axes[a, a, 1 + b, 1 + b] = axes[a, a, 1 + c, 1 + c] = -1.0
        axes[a, b, 1 + a, 1 + b] = axes[b, a, 1 + a, 1 + b] = 1.0
        axes[a, b, 0, 1 + c], axes[b, a, 0, 1 + c] = -1.0, 1.0
        rates[0, 1 + a, a], rates[1 + a, 0, a] = -0.5, 0.5
        rates[1 + a, 1 + c, b], rates[1 + a, 1 + b, c] = 0.5, -0.5
    return axes.reshape(9, 16), rates.reshape(4, 12)


ROTATION, RATES = _bilinear()


class SphericalTree(NamedTuple):
    """A tree of spherical joints that hangs on ground."""

    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (3, 3, n) kg m^2 about the centres, body axes
    gravity: np.ndarray  # (3, 1) m/s^2
    pivot: np.ndarray  # (3, n) m, o_i
    arms: np.ndarray  # (3, n, n) m, c_ij
    theta: np.ndarray  # (4, n) Euler parameters at t = 0
    omega: np.ndarray  # (3, n) rad/s at t = 0, world axes


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
    inertia, omega = np.array([symmetric(b.inertia) for b in bodies]), np.array([b.angular_velocity for b in bodies])
    mass, gravity = np.array([b.mass for b in bodies]), np.array(scene.gravity, dtype=float).reshape(3, 1)
    return SphericalTree(mass, np.moveaxis(inertia, 0, 2), gravity, pivot.T, np.moveaxis(arms, 2, 0), theta.T, omega.T)


def newton_euler(tree: SphericalTree) -> Formulation:
    """Return y = (theta, omega): moments of forces less those of inertia, about each body's joint."""
    return _formulation(tree, _newton_euler, tree.omega.ravel())


def hamilton(tree: SphericalTree) -> Formulation:
    """Return y = (theta, p) with p = M omega: p_j' = sum_i m_i [(omega_j x d_ij) x v_i + d_ij x g]."""
    return _formulation(tree, _hamilton, turned(tree, tree.theta)[2] @ tree.omega.ravel())


def _formulation(tree: SphericalTree, slope: Callable, rates: np.ndarray) -> Formulation:
    def derivative(t, y):
        return slope(tree, y[: 4 * len(tree.mass)].reshape(4, -1), y[4 * len(tree.mass) :])

    def poses(t, y):
        theta = y[: 4 * len(tree.mass)].reshape(4, -1)
        return (tree.pivot + turned(tree, theta)[0].sum(axis=2)).T, theta.T

    return Formulation(derivative, np.concatenate((tree.theta.ravel(), rates)), poses)


def _newton_euler(tree: SphericalTree, theta: np.ndarray, y: np.ndarray) -> np.ndarray:
    omega, (d, inertia, matrix) = y.reshape(3, -1), turned(tree, theta)
    spin = omega[:, None]
    inward = (spin * (spin * d).sum(axis=0) - d * (omega * omega).sum(axis=0)).sum(axis=2)
    moment = _moments(d, tree.mass * (inward - tree.gravity)) + _cross(omega, (inertia * omega).sum(axis=1))
    return np.concatenate((_rates(theta, omega).ravel(), solve(matrix, -moment.ravel())))


def _hamilton(tree: SphericalTree, theta: np.ndarray, y: np.ndarray) -> np.ndarray:
    d, _, matrix = turned(tree, theta)
    omega = solve(matrix, y).reshape(3, -1)
    parts = _cross(omega[:, None], d)
    change = _moments(parts, tree.mass * parts.sum(axis=2)) + _moments(d, tree.mass * tree.gravity)
    return np.concatenate((_rates(theta, omega).ravel(), change.ravel()))


def turned(tree: SphericalTree, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return d (3, n, n), the inertias in world axes (3, 3, n) and the matrix (3 n, 3 n) of the angular velocities."""
    n = len(tree.mass)
    axes = _axes(theta)
    d = (axes[:, :, None] * tree.arms).sum(axis=1)
    half = (axes[:, :, None] * tree.inertia).sum(axis=1)
    inertia = (half[:, None] * axes).sum(axis=2)
    along = d.transpose(1, 0, 2).reshape(n, 3 * n)
    products = (along.T @ (tree.mass[:, None] * along)).reshape(3, n, 3, n)
    matrix = -products.transpose(2, 1, 0, 3)
    each, inner = np.arange(3), products[0, :, 0] + products[1, :, 1] + products[2, :, 2]
    matrix[each, :, each] += inner
    matrix[:, np.arange(n), :, np.arange(n)] += inertia.transpose(2, 0, 1)
    return d, inertia, matrix.reshape(3 * n, 3 * n)


def _axes(theta: np.ndarray) -> np.ndarray:
    """Return the matrices (3, 3, n) from body axes into world axes."""
    products = (theta[:, None] * theta).reshape(16, -1)
    axes = (ROTATION @ products).reshape(3, 3, -1) * (2 / (theta * theta).sum(axis=0))
    axes[np.arange(3), np.arange(3)] += 1
    return axes


def _moments(arms: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return sum_i arms_ij x force_i (3, n)."""
    result = np.empty_like(force)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        result[a] = force[c] @ arms[b] - force[b] @ arms[c]
    return result


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _rates(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return theta' = E^T omega / 2 (4, n)."""
    return RATES @ (theta[:, None] * omega).reshape(12, -1)
