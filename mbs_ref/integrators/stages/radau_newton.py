"""Simplified Newton iteration for the stages of Radau IIA: one real and one complex system, compiled.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, sec. IV.8.
"""

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.dense import lu_factor, lu_solve, weighted_norm
from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import jit

_S6 = 6**0.5
C = np.array([(4 - _S6) / 10, (4 + _S6) / 10, 1.0])
E = np.array([-13 - 7 * _S6, -13 + 7 * _S6, -1.0]) / 3.0
MU_REAL = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
MU_COMPLEX = 3 + 0.5 * (3 ** (1 / 3) - 3 ** (2 / 3)) - 0.5j * (3 ** (5 / 6) + 3 ** (7 / 6))
# The inverse of the Butcher matrix is T diag(MU_REAL, MU_COMPLEX, conj) T^-1 in real form.
T = np.array(
    [
        [0.09443876248897524, -0.14125529502095421, 0.03002919410514742],
        [0.25021312296533332, 0.20412935229379994, -0.38294211275726192],
        [1.0, 1.0, 0.0],
    ]
)
TI = np.array(
    [
        [4.17871859155190428, 0.32768282076106237, 0.52337644549944951],
        [-4.17871859155190428, -0.32768282076106237, 0.47662355450055044],
        [0.50287263494578682, -2.57192694985560522, 0.59603920482822492],
    ]
)

NEWTON_ITERATIONS = 7
DIFFERENCE = 1.5e-8  # sqrt(eps), of an entry or its unit: balances truncation and roundoff in a forward difference


class Newton(NamedTuple):
    """What the iteration works with, in the source's letters; n is the size of the state."""

    jacobian: np.ndarray  # (n, n) df/dy
    real: np.ndarray  # (m, m) factors of MU_REAL / h I - J; m is n / 2 where q' = v, else n
    complex: np.ndarray  # (m, m) factors of MU_COMPLEX / h I - J
    real_pivots: np.ndarray  # (m,) int
    complex_pivots: np.ndarray  # (m,) int
    z: np.ndarray  # (3, n) stages less y; between steps, those of the last one
    w: np.ndarray  # (3, n) T^-1 z
    slopes: np.ndarray  # (3, n) f at the stages
    scale: np.ndarray  # (n,) what an error may be


class Solved(NamedTuple):
    """How an iteration ended."""

    converged: bool
    iterations: int
    rate: float  # contraction of the last two corrections


@jit
def newton_for(jacobian):
    """Return the workspace that belongs to a Jacobian."""
    n = jacobian.shape[0]
    m = n // 2 if _is_second_order(jacobian) else n
    return Newton(
        jacobian, np.empty((m, m)), np.empty((m, m), dtype=np.complex128),
        np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64),
        np.zeros((3, n)), np.empty((3, n)), np.empty((3, n)), np.empty(n),
    )  # fmt: skip


@jit
def fill_jacobian(model, work, t, y, f0, units, scratch, out):
    """Write df/dy by forward differences, one column an evaluation; `units` (n,) is what entries of y count in."""
    n = y.shape[0]
    shifted = y.copy()
    for j in range(n):
        delta = DIFFERENCE * max(units[j], abs(y[j]))
        shifted[j] = y[j] + delta
        step = shifted[j] - y[j]
        derivative(model, work, t, shifted, scratch)
        for i in range(n):
            out[i, j] = (scratch[i] - f0[i]) / step
        shifted[j] = y[j]


@jit
def _is_second_order(jacobian):
    """Return whether y = (q, v) with q' = v to the last bit, as in the plane."""
    n = jacobian.shape[0]
    half = n // 2
    for i in range(half):
        for j in range(n):
            if jacobian[i, j] != (1.0 if j == half + i else 0.0):
                return False
    return n % 2 == 0


@jit
def factor(newton, h):
    """Factor both systems for the step h (s); return whether they are regular."""
    return _factor_one(newton.jacobian, MU_REAL / h, newton.real, newton.real_pivots) and _factor_one(
        newton.jacobian, MU_COMPLEX / h, newton.complex, newton.complex_pivots
    )


@jit
def _factor_one(jacobian, mu, lu, pivots):
    """Factor mu I - J; where q' = v, of half the size: mu^2 I - mu dv'/dv - dv'/dq (sec. IV.8)."""
    n, size = jacobian.shape[0], lu.shape[0]
    if size == n:
        for i in range(n):
            for j in range(n):
                lu[i, j] = -jacobian[i, j]
            lu[i, i] += mu
    else:
        for i in range(size):
            for j in range(size):
                lu[i, j] = -jacobian[size + i, j] - mu * jacobian[size + i, size + j]
            lu[i, i] += mu * mu
    return lu_factor(lu, pivots)


@jit
def _solve(jacobian, mu, lu, pivots, b):
    """Solve (mu I - J) x = b in place with the factors of `_factor_one`."""
    size = lu.shape[0]
    if size == b.shape[0]:
        lu_solve(lu, pivots, b)
        return
    q = np.empty(size, b.dtype)
    for i in range(size):
        total = b[size + i] + mu * b[i]
        for j in range(size):
            total -= jacobian[size + i, size + j] * b[j]
        q[i] = total
    lu_solve(lu, pivots, q)
    for i in range(size):
        b[size + i] = mu * q[i] - b[i]
        b[i] = q[i]


@jit
def guess_stages(newton, h_last, h):
    """Guess z from the collocation polynomial of the last step, h_last (s); 0 for none (sec. IV.8, eq 8.4)."""
    z = newton.z
    if h_last == 0.0:
        z[:] = 0.0
        return
    ratio = h / h_last
    for k in range(z.shape[1]):
        d1 = z[0, k] / C[0]
        d2 = (z[1, k] - z[0, k]) / (C[1] - C[0])
        d3 = (z[2, k] - z[1, k]) / (C[2] - C[1])
        e1 = (d2 - d1) / C[1]
        e2 = (d3 - d2) / (C[2] - C[0])
        f1 = (e2 - e1) / C[2]
        end = z[2, k]
        for a in range(3):
            x = 1.0 + C[a] * ratio
            z[a, k] = x * (d1 + (x - C[0]) * (e1 + (x - C[1]) * f1)) - end


@jit
def _transform(matrix, x, out):
    """Write the 3 x 3 matrix times x (3, n)."""
    for a in range(3):
        for k in range(x.shape[1]):
            out[a, k] = matrix[a, 0] * x[0, k] + matrix[a, 1] * x[1, k] + matrix[a, 2] * x[2, k]


@jit
def _evaluate_stages(model, work, t, h, y, newton, argument):
    """Write f at y + z."""
    for a in range(3):
        for k in range(y.shape[0]):
            argument[k] = y[k] + newton.z[a, k]
        derivative(model, work, t + C[a] * h, argument, newton.slopes[a])


@jit
def _correct(newton, h, real_part, complex_part):
    """Solve the two systems for a correction of w and add it; return its scaled norm (sec. IV.8, eq 8.5)."""
    slopes, w, scale = newton.slopes, newton.w, newton.scale
    n = scale.shape[0]
    for k in range(n):
        g0 = TI[0, 0] * slopes[0, k] + TI[0, 1] * slopes[1, k] + TI[0, 2] * slopes[2, k]
        g1 = TI[1, 0] * slopes[0, k] + TI[1, 1] * slopes[1, k] + TI[1, 2] * slopes[2, k]
        g2 = TI[2, 0] * slopes[0, k] + TI[2, 1] * slopes[1, k] + TI[2, 2] * slopes[2, k]
        real_part[k] = g0 - MU_REAL / h * w[0, k]
        complex_part[k] = g1 + 1j * g2 - MU_COMPLEX / h * (w[1, k] + 1j * w[2, k])
    _solve(newton.jacobian, MU_REAL / h, newton.real, newton.real_pivots, real_part)
    _solve(newton.jacobian, MU_COMPLEX / h, newton.complex, newton.complex_pivots, complex_part)
    total = 0.0
    for k in range(n):
        d1 = complex_part[k].real
        d2 = complex_part[k].imag
        total += (real_part[k] ** 2 + d1**2 + d2**2) / scale[k] ** 2
        w[0, k] += real_part[k]
        w[1, k] += d1
        w[2, k] += d2
    return np.sqrt(total / (3 * n))


@jit
def solve_stages(model, work, t, h, y, newton, tolerance, roundoff):
    """Iterate for z until what is left of it is below the tolerance; return how it ended.

    Corrections that stop shrinking below `roundoff` are roundoff: no iteration makes them smaller.
    """
    n = y.shape[0]
    argument, real_part, complex_part = np.empty(n), np.empty(n), np.empty(n, dtype=np.complex128)
    _transform(TI, newton.z, newton.w)
    before = -1.0
    rate = 0.0
    for iteration in range(NEWTON_ITERATIONS):
        _evaluate_stages(model, work, t, h, y, newton, argument)
        norm = _correct(newton, h, real_part, complex_part)
        if not np.isfinite(norm):
            return Solved(False, iteration + 1, 1.0)
        _transform(T, newton.w, newton.z)
        if before >= 0.0:
            rate = norm / before
            left = NEWTON_ITERATIONS - iteration - 1
            if rate >= 1.0 or rate**left / (1.0 - rate) * norm > tolerance:
                return Solved(norm < roundoff, iteration + 1, rate)
        if norm == 0.0 or (before >= 0.0 and rate / (1.0 - rate) * norm < tolerance):
            return Solved(True, iteration + 1, rate)
        before = norm
    return Solved(before < roundoff, NEWTON_ITERATIONS, rate)


@jit
def error_norm(model, work, t, h, y, f, newton, rtol, atol, again):
    """Return the scaled error estimate, with `again` filtered once more where it is large (sec. IV.8, eq 8.19-8.20)."""
    z, n = newton.z, y.shape[0]
    combined, err, new = np.empty(n), np.empty(n), np.empty(n)
    for k in range(n):
        combined[k] = (E[0] * z[0, k] + E[1] * z[1, k] + E[2] * z[2, k]) / h
        err[k] = f[k] + combined[k]
        new[k] = y[k] + z[2, k]
    _solve(newton.jacobian, MU_REAL / h, newton.real, newton.real_pivots, err)
    norm = weighted_norm(err, y, new, rtol, atol)
    if again and norm > 1.0:
        slope = np.empty(n)
        derivative(model, work, t, y + err, slope)
        for k in range(n):
            err[k] = slope[k] + combined[k]
        _solve(newton.jacobian, MU_REAL / h, newton.real, newton.real_pivots, err)
        norm = weighted_norm(err, y, new, rtol, atol)
    return norm
