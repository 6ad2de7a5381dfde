"""Dense vectors and matrices of a state's size: norms, and LU with partial pivoting, real or complex, in place."""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.jit import jit


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
