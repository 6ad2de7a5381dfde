"""Small symmetric factorizations: L D L^T of 3x3 blocks in scalars, and a rank-revealing one for closures."""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.jit import jit


@jit
def ldl3(a00, a10, a11, a20, a21, a22):
    """Factor a symmetric positive definite 3x3 matrix; return (1/d0, 1/d1, 1/d2, l10, l20, l21)."""
    i0 = 1.0 / a00
    l10 = a10 * i0
    l20 = a20 * i0
    i1 = 1.0 / (a11 - l10 * a10)
    m21 = a21 - l20 * a10
    l21 = m21 * i1
    i2 = 1.0 / (a22 - l20 * a20 - l21 * m21)
    return i0, i1, i2, l10, l20, l21


@jit
def ldl3_solve(i0, i1, i2, l10, l20, l21, b0, b1, b2):
    """Solve with the factors of `ldl3`."""
    y1 = b1 - l10 * b0
    y2 = b2 - l20 * b0 - l21 * y1
    x2 = y2 * i2
    x1 = y1 * i1 - l21 * x2
    x0 = b0 * i0 - l10 * x1 - l20 * x2
    return x0, x1, x2


@jit
def pivoted_cholesky(a, scale, tolerance, lower, order, most):
    """Factor a positive semidefinite matrix with complete pivoting.

    a (n, n) is overwritten; scale (n,) > 0 makes pivots comparable: a row counts as dependent once its
    remaining pivot is below tolerance * scale. lower (n, n) receives P^T a P = L L^T in its first `rank`
    columns and order (n,) the permutation. The rank is `most` at most. Returns the rank and the smallest
    accepted relative pivot (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 10.3).
    """
    n = a.shape[0]
    for i in range(n):
        order[i] = i
        for j in range(n):
            lower[i, j] = 0.0
    smallest = 1.0
    for k in range(n):
        if k == most:
            return k, smallest
        best = k
        largest = -1.0
        for i in range(k, n):
            relative = a[order[i], order[i]] / scale[order[i]]
            if relative > largest:
                largest = relative
                best = i
        if not largest > tolerance:
            return k, smallest
        smallest = min(smallest, largest)
        order[k], order[best] = order[best], order[k]
        for j in range(k):
            lower[k, j], lower[best, j] = lower[best, j], lower[k, j]
        pivot = order[k]
        root = np.sqrt(a[pivot, pivot])
        lower[k, k] = root
        for i in range(k + 1, n):
            lower[i, k] = a[order[i], pivot] / root
        for i in range(k + 1, n):
            for j in range(k + 1, i + 1):
                value = a[order[i], order[j]] - lower[i, k] * lower[j, k]
                a[order[i], order[j]] = value
                a[order[j], order[i]] = value
    return n, smallest


@jit
def minimum_norm_solve(lower, order, rank, gram, b, x):
    """Solve a x = b in the minimum-norm least-squares sense from `pivoted_cholesky`.

    With P^T a P = L L^T, L (n, r): x = P L (L^T L)^-1 (L^T L)^-1 L^T P^T b. gram (n, n) is scratch.
    """
    n = b.shape[0]
    if rank == n:
        _cholesky_solve(lower, order, b, x)
        return
    y = np.zeros(rank)
    for i in range(rank):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += lower[k, i] * lower[k, j]
            gram[i, j] = total
        for k in range(n):
            y[i] += lower[k, i] * b[order[k]]
    _factor_in_place(gram, rank)
    _solve_in_place(gram, rank, y)
    _solve_in_place(gram, rank, y)
    for k in range(n):
        total = 0.0
        for j in range(rank):
            total += lower[k, j] * y[j]
        x[order[k]] = total


@jit
def _cholesky_solve(lower, order, b, x):
    n = b.shape[0]
    y = np.empty(n)
    for i in range(n):
        total = b[order[i]]
        for j in range(i):
            total -= lower[i, j] * y[j]
        y[i] = total / lower[i, i]
    for i in range(n - 1, -1, -1):
        total = y[i]
        for j in range(i + 1, n):
            total -= lower[j, i] * y[j]
        y[i] = total / lower[i, i]
    for i in range(n):
        x[order[i]] = y[i]


@jit
def _factor_in_place(a, n):
    """Cholesky-factor the leading n x n lower triangle of a."""
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                a[i, j] -= a[i, k] * a[j, k]
        root = np.sqrt(a[j, j])
        for i in range(j, n):
            a[i, j] /= root


@jit
def _solve_in_place(a, n, y):
    for i in range(n):
        for j in range(i):
            y[i] -= a[i, j] * y[j]
        y[i] /= a[i, i]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            y[i] -= a[j, i] * y[j]
        y[i] /= a[i, i]


@jit
def factor_ldl(a, n):
    """Factor the leading n x n lower triangle in place: strict part L, diagonal 1 / D."""
    for j in range(n):
        inverse = 1.0 / a[j, j]
        for i in range(j + 1, n):
            low = a[i, j] * inverse
            for k in range(j + 1, i + 1):
                a[i, k] -= low * a[k, j]
        for i in range(j + 1, n):
            a[i, j] *= inverse
        a[j, j] = inverse


@jit
def solve_ldl(a, n, b):
    """Solve in place with the factors of `factor_ldl`."""
    for i in range(1, n):
        total = b[i]
        for k in range(i):
            total -= a[i, k] * b[k]
        b[i] = total
    for i in range(n - 1, -1, -1):
        total = b[i] * a[i, i]
        for k in range(i + 1, n):
            total -= a[k, i] * b[k]
        b[i] = total
