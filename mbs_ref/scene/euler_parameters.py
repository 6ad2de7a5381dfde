"""Euler parameters in NumPy: theta0 = cos(angle / 2), (theta1, theta2, theta3) = axis sin(angle / 2).

Arrays theta have the shape (..., 4). Source: Fox 1999, appendix; Haug, Computer Aided Kinematics and
Dynamics of Mechanical Systems (1989), sec. 9.3.
"""

import numpy as np


def floats(values) -> np.ndarray:
    """Return an array of floats, in extended precision where the values have it."""
    array = np.asarray(values)
    return array.astype(np.result_type(array, float), copy=False)


def from_axis_angle(axis, angle) -> np.ndarray:
    """Return theta (..., 4) of turns by `angle` (...) in rad about `axis` (3,) or (..., 3), of any length but zero."""
    axis, half = floats(axis), 0.5 * floats(angle)[..., None]
    unit = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.concatenate((np.cos(half), np.sin(half) * unit), axis=-1)


def product(first, second) -> np.ndarray:
    """Return theta of the rotation `second` followed by `first`: A(first) A(second)."""
    p, q = floats(first), floats(second)
    scalar = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate((scalar, vector), axis=-1)


def conjugate(theta) -> np.ndarray:
    """Return theta of the inverse rotation."""
    return floats(theta) * np.array([1.0, -1.0, -1.0, -1.0])


def rotation_matrices(theta) -> np.ndarray:
    """Return A(theta / |theta|), shape (..., 3, 3): from body axes into world axes."""
    theta = floats(theta)
    e0, e1, e2, e3 = np.moveaxis(theta, -1, 0)
    s = 2.0 / np.sum(theta**2, axis=-1)
    axes = np.empty((*theta.shape[:-1], 3, 3), dtype=s.dtype)
    axes[..., 0, 0] = 1.0 - s * (e2**2 + e3**2)
    axes[..., 0, 1] = s * (e1 * e2 - e0 * e3)
    axes[..., 0, 2] = s * (e1 * e3 + e0 * e2)
    axes[..., 1, 0] = s * (e1 * e2 + e0 * e3)
    axes[..., 1, 1] = 1.0 - s * (e1**2 + e3**2)
    axes[..., 1, 2] = s * (e2 * e3 - e0 * e1)
    axes[..., 2, 0] = s * (e1 * e3 - e0 * e2)
    axes[..., 2, 1] = s * (e2 * e3 + e0 * e1)
    axes[..., 2, 2] = 1.0 - s * (e1**2 + e2**2)
    return axes


def from_matrix(matrix) -> np.ndarray:
    """Return theta (4,) of a rotation matrix (3, 3), theta0 >= 0; by the largest parameter (Shepperd 1978)."""
    m = floats(matrix)
    squares = np.array([m.trace(), *m.diagonal()])
    k = int(np.argmax(squares))
    if k == 0:
        theta = np.array([1.0 + m.trace(), m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, n = k - 1, k % 3, (k + 1) % 3
        theta = np.empty(4, dtype=m.dtype)
        theta[0] = m[n, j] - m[j, n]
        theta[1 + i] = 1.0 + m[i, i] - m[j, j] - m[n, n]
        theta[1 + j] = m[j, i] + m[i, j]
        theta[1 + n] = m[n, i] + m[i, n]
    theta /= np.sqrt(np.sum(theta**2))
    return -theta if theta[0] < 0.0 else theta


def parameter_matrix(theta) -> np.ndarray:
    """Return E (3, 4): omega = 2 E theta' in world axes, theta' = E^T omega / 2."""
    e0, e1, e2, e3 = theta
    return np.array([[-e1, e0, -e3, e2], [-e2, e3, e0, -e1], [-e3, -e2, e1, e0]])


def rotation_vector(theta) -> np.ndarray:
    """Return the rotation vector (..., 3), rad, no longer than pi; theta need not have unit length, nor a sign."""
    theta = np.where(floats(theta)[..., :1] < 0.0, -floats(theta), theta)
    sine = np.linalg.norm(theta[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, theta[..., :1])
    return theta[..., 1:] * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
