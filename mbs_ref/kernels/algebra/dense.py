"""Dense LU with partial pivoting, real or complex, in place: the implicit methods' small linear algebra."""

from __future__ import annotations

from mbs_ref.kernels.jit import jit


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
                swap = a[k, j]
                a[k, j] = a[best, j]
                a[best, j] = swap
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
        if best != k:
            swap = b[k]
            b[k] = b[best]
            b[best] = swap
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
