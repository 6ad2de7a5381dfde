"""Dense vectors and matrices: norms, LU with partial pivoting, real or complex, in place; small symmetric ones.

The latter are factored as L D L^T: 3x3 blocks in scalars, and small matrices in place.
"""

import numpy as np

from mbs_ref.kernels.jit import bare, jit


@jit
def all_finite(y):
    total = 0.0
    for k in range(y.shape[0]):
        total += y[k] * 0.0
    return total == 0.0


@jit
def weighted_norm(x, y0, y1, rtol, atol):
    """Root mean square of x / (atol + rtol max(|y0|, |y1|)) (Hairer, Norsett, Wanner I, eq II.4.11)."""
    total = 0.0
    for k in range(x.shape[0]):
        scaled = x[k] / (atol[k] + rtol * max(abs(y0[k]), abs(y1[k])))
        total += scaled * scaled
    return np.sqrt(total / x.shape[0])


@jit
def lu_factor(a, pivots):
    """Factor a (n, n) in place; pivots (n,) int. Return False where a pivot is zero or not finite."""
    n = a.shape[0]
    for k in range(n):
        best = k
        largest = abs(a[k, k])
        for i in range(k + 1, n):
            size = abs(a[i, k])
            if size > largest:
                largest = size
                best = i
        pivots[k] = best
        if not largest > 0.0:
            return False
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        inverse = 1.0 / a[k, k]
        for i in range(k + 1, n):
            factor = a[i, k] * inverse
            a[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= factor * a[k, j]
    return True


@jit
def lu_solve(a, pivots, b):
    """Solve in place with the factors of `lu_factor`."""
    n = a.shape[0]
    for k in range(n):
        best = pivots[k]
        b[k], b[best] = b[best], b[k]
    for i in range(1, n):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(n - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, n):
            total -= a[i, j] * b[j]
        b[i] = total / a[i, i]


@bare
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


@bare
def ldl3_solve(i0, i1, i2, l10, l20, l21, b0, b1, b2):
    """Solve with the factors of `ldl3`."""
    y1 = b1 - l10 * b0
    y2 = b2 - l20 * b0 - l21 * y1
    x2 = y2 * i2
    x1 = y1 * i1 - l21 * x2
    x0 = b0 * i0 - l10 * x1 - l20 * x2
    return x0, x1, x2


@bare
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


@bare
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
