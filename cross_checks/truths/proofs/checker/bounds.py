"""Bounds of polynomial matrices on a step, in floats: flows, their defects and inverses. Time is 0 to 1."""

import numpy as np

from cross_checks.truths.proofs.checker.balls import GAMMA, Refused, up

ORDER = 20  # terms of V, W, the Jacobian and inverses: their defect is about 6^-ORDER


def size_of(matrix: np.ndarray) -> np.ndarray:
    """Return a bound of |matrix(t)| on the step."""
    return up(np.abs(matrix).sum(0))


def product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of a b, and a bound of their rounding."""
    whole = np.zeros((len(a) + len(b) - 1, a.shape[1], b.shape[2]))
    for j, own in enumerate(a):
        whole[j : j + len(b)] += own @ b
    return whole, up(GAMMA * up(size_of(a) @ size_of(b)))


def variations(jacobian: np.ndarray, n: int) -> np.ndarray:
    """Return V and W, V' = f_y V + f_z W, 0 = g_y V + g_z W, V(0) = 1, to ORDER terms."""
    flow = np.zeros((ORDER, len(jacobian[0]), n))
    flow[0, :n] = np.eye(n)
    inverse = np.linalg.inv(jacobian[0, n:, n:])
    for k in range(ORDER):
        if k:
            flow[k, :n] = sum(jacobian[j, :n] @ flow[k - 1 - j] for j in range(k)) / k
        flow[k, n:] = -inverse @ sum(jacobian[j, n:] @ flow[k - j] for j in range(k + 1))
    return flow


def defects_of(jacobian: np.ndarray, error: np.ndarray, flow: np.ndarray, n: int) -> np.ndarray:
    """Return bounds of the defects of the equations of V and W on the step."""
    (whole, rounding), size = product(jacobian, flow), size_of(flow)
    whole[: ORDER - 1, :n] -= np.arange(1, ORDER)[:, None, None] * flow[1:, :n]
    rounding[:n] += GAMMA * ORDER * size[:n]
    return up(size_of(whole) + up(rounding + error @ size))


def inverse_of(matrix: np.ndarray, error: float | np.ndarray = 0.0) -> tuple[np.ndarray, float]:
    """Return K near 1 / matrix(t), to ORDER terms, and c: |x| <= |K y| + c max|K y| where (matrix + error) x = y.

    1 - K matrix has row sums below 1 / 2 on the step, or Refused is raised; c bounds the rest of its Neumann series.
    """
    own = np.zeros((min(len(matrix), ORDER), *matrix.shape[1:]))
    own[0] = np.linalg.inv(matrix[0])
    for k in range(1, len(own)):
        own[k] = -own[0] @ sum(matrix[j] @ own[k - j] for j in range(1, k + 1))
    rest, rounding = product(own, matrix)
    rest[0] -= np.eye(matrix.shape[1])
    gap = up(size_of(rest) + up(rounding + size_of(own) @ (error + np.zeros_like(rounding))))
    most = float(up(gap.sum(1)).max(initial=0.0))
    if not most < 0.5:
        raise Refused("a matrix is singular within the step")
    return own, float(up(most / (1.0 - most)))


def inverse_bound(matrix: np.ndarray, error: float | np.ndarray = 0.0) -> np.ndarray:
    """Return a bound of |1 / matrix(t)| on the step."""
    own, rest = inverse_of(matrix, error)
    size = size_of(own)
    return up(size + rest * size.max(0, initial=0.0))
