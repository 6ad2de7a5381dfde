"""Bounds of polynomial matrices on a step, in floats: flows, their defects and inverses."""

from math import comb

import numpy as np

from cross_checks.truths.proofs.checker.balls import GAMMA, Refused, up

ORDER = 20  # terms of V, W and the Jacobian: their defect is about 6^-ORDER
DEEPEST = 6  # halvings of a step for an inverse


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


def defects_of(jacobian: np.ndarray, error: np.ndarray, flow: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds of |V| and |W|, and of the defects of their equations, on the step."""
    whole = np.zeros((2 * ORDER, *flow.shape[1:]))
    for j in range(ORDER):
        whole[j : j + ORDER] += jacobian[j] @ flow
    whole[: ORDER - 1, :n] -= np.arange(1, ORDER)[:, None, None] * flow[1:, :n]
    size = up(np.abs(flow).sum(0))
    rounding = up(GAMMA * up(np.abs(jacobian).sum(0) @ size) + error @ size)
    rounding[:n] = up(rounding[:n] + GAMMA * ORDER * size[:n])
    return size, up(np.abs(whole).sum(0) + rounding)


def gap_of(inverse: np.ndarray, matrix: np.ndarray) -> float:
    """Return a bound of the row sums of |1 - inverse matrix|; Refused unless it is below 1."""
    gap = up(np.abs(np.eye(len(matrix)) - inverse @ matrix) + GAMMA * up(np.abs(inverse) @ np.abs(matrix)))
    most = float(up(gap.sum(1)).max(initial=0.0))
    if not most < 1.0:
        raise Refused("a matrix is singular to rounding")
    return most


def inverse_bound(
    matrix: np.ndarray, error: np.ndarray, low: float = 0.0, high: float = 1.0, depth: int = 0
) -> np.ndarray:
    """Return a bound of |matrix(t)^-1| for low <= t <= high, the matrix a series with an error."""
    size = matrix.shape[1]
    if not size:
        return np.zeros((0, 0))
    middle, half, count = (low + high) / 2, (high - low) / 2, len(matrix)
    shift = np.array(
        [[comb(k, j) * middle ** (k - j) * half**j if k >= j else 0.0 for k in range(count)] for j in range(count)]
    )
    moved = np.tensordot(shift, matrix, 1)
    blur = up(error + GAMMA * up(np.abs(matrix).sum(0)))
    inverse = np.linalg.inv(moved[0])
    rest = up(np.abs(inverse @ moved[1:]).sum(0) + GAMMA * up(np.abs(inverse) @ np.abs(moved).sum(0)))
    rest = up(rest + up(np.abs(inverse) @ blur) + np.abs(np.eye(size) - inverse @ moved[0]))
    most = float(up(rest.sum(1)).max())
    if most < 0.5:
        first = up(rest @ np.abs(inverse))
        return up(np.abs(inverse) + first + most / (1.0 - most) * first.max(0))
    if depth > DEEPEST:
        raise Refused("a matrix is singular within the step")
    return np.maximum(
        inverse_bound(matrix, error, low, middle, depth + 1), inverse_bound(matrix, error, middle, high, depth + 1)
    )
