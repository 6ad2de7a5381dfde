"""Dense vectors and matrices: norms, LU with partial pivoting, real or complex, in place; small symmetric ones.

The latter are factored as L D L^T, in blocks of three whose numbers are scalars.
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
def ldl3_solve(factors, b):
    """Solve for three numbers with the factors of `ldl3`."""
    i0, i1, i2, l10, l20, l21 = factors
    y1 = b[1] - l10 * b[0]
    y2 = b[2] - l20 * b[0] - l21 * y1
    x2 = y2 * i2
    x1 = y1 * i1 - l21 * x2
    x0 = b[0] * i0 - l10 * x1 - l20 * x2
    return x0, x1, x2


# Factor a 3x3 block, its lower triangle given at (k, k), as `ldl3` does; read such factors there; read a row of three.
ldl3_at = bare(lambda a, k: ldl3(
    a[k, k], a[k + 1, k], a[k + 1, k + 1], a[k + 2, k], a[k + 2, k + 1], a[k + 2, k + 2]
))  # fmt: skip
factors_at = bare(lambda a, k: (
    a[k, k], a[k + 1, k + 1], a[k + 2, k + 2], a[k + 1, k], a[k + 2, k], a[k + 2, k + 1]
))  # fmt: skip
_three = bare(lambda a, r, k: (a[r, k], a[r, k + 1], a[r, k + 2]))
_product = bare(lambda x, y: x[0] * y[0] + x[1] * y[1] + x[2] * y[2])


@bare
def put_factors(a, k, m):
    """Write factors as `factors_at` reads them."""
    a[k, k], a[k + 1, k + 1], a[k + 2, k + 2], a[k + 1, k], a[k + 2, k], a[k + 2, k + 1] = m


# Factor a 3x3 block in place, and return a solution with its factors.
factor3 = bare(lambda a: put_factors(a, 0, ldl3_at(a, 0)))
solve3 = bare(lambda a, b: ldl3_solve(factors_at(a, 0), b))


@bare
def factor6(a):
    """Factor (A, B^T; B, C), its lower triangle given, in place: factors of A and C - B A^-1 B^T, and A^-1 B^T on top.

    Blocks of three are in scalars: what is stored in between is what the compiler would have to read again.
    """
    m = ldl3_at(a, 0)
    b0, b1, b2 = _three(a, 3, 0), _three(a, 4, 0), _three(a, 5, 0)
    x0, x1, x2 = ldl3_solve(m, b0), ldl3_solve(m, b1), ldl3_solve(m, b2)
    rest = ldl3(
        a[3, 3] - _product(b0, x0), a[4, 3] - _product(b1, x0), a[4, 4] - _product(b1, x1),
        a[5, 3] - _product(b2, x0), a[5, 4] - _product(b2, x1), a[5, 5] - _product(b2, x2),
    )  # fmt: skip
    put_factors(a, 0, m)
    put_factors(a, 3, rest)
    for k in range(3):
        a[k, 3], a[k, 4], a[k, 5] = x0[k], x1[k], x2[k]


@bare
def solve6(a, top, bottom):
    """Return both halves of the solution for a right-hand side in halves, with the factors of `factor6`."""
    y = ldl3_solve(factors_at(a, 0), top)
    b0, b1, b2 = _three(a, 3, 0), _three(a, 4, 0), _three(a, 5, 0)
    rest = bottom[0] - _product(b0, y), bottom[1] - _product(b1, y), bottom[2] - _product(b2, y)
    z = ldl3_solve(factors_at(a, 3), rest)
    x0, x1, x2 = _three(a, 0, 3), _three(a, 1, 3), _three(a, 2, 3)
    return (y[0] - _product(x0, z), y[1] - _product(x1, z), y[2] - _product(x2, z)), z
