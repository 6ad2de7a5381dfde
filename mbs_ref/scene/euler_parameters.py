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
    result = np.empty(np.broadcast_shapes(p.shape, q.shape), np.result_type(p, q))
    (p0, p1, p2, p3), (q0, q1, q2, q3) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    result[..., 0] = p0 * q0 - (p1 * q1 + p2 * q2 + p3 * q3)
    result[..., 1] = p0 * q1 + q0 * p1 + (p2 * q3 - p3 * q2)
    result[..., 2] = p0 * q2 + q0 * p2 + (p3 * q1 - p1 * q3)
    result[..., 3] = p0 * q3 + q0 * p3 + (p1 * q2 - p2 * q1)
    return result


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


def rotated(theta, vectors) -> np.ndarray:
    """Return A(theta / |theta|) u of vectors u (..., 3), without the matrices."""
    theta, vectors = floats(theta), floats(vectors)
    result = np.empty((*np.broadcast_shapes(theta.shape[:-1], vectors.shape[:-1]), 3), np.result_type(theta, vectors))
    (e0, e1, e2, e3), (x, y, z) = np.moveaxis(theta, -1, 0), np.moveaxis(vectors, -1, 0)
    a, b, c = e2 * z - e3 * y, e3 * x - e1 * z, e1 * y - e2 * x
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    result[..., 0] = x + s * (e0 * a + e2 * c - e3 * b)
    result[..., 1] = y + s * (e0 * b + e3 * a - e1 * c)
    result[..., 2] = z + s * (e0 * c + e1 * b - e2 * a)
    return result


def turn_size(theta) -> np.ndarray:
    """Return the angle (...) of turns in [0, pi], rad; theta need not have unit length, nor a sign."""
    e0, e1, e2, e3 = np.moveaxis(floats(theta), -1, 0)
    return 2.0 * np.arctan2(np.sqrt(e1 * e1 + e2 * e2 + e3 * e3), np.abs(e0))


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
