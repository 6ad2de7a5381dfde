"""Rods hinged in a row: Lagrange's and Hamilton's equations in absolute angles."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cross_checks.truths.made_by import Formulation
from mbs_ref.kernels.jit import strict_jit

EXTENDED_UP_TO = 12  # rods; beyond, an elimination in Python is too slow


@dataclass(frozen=True)
class Rods:
    """Rods with their centres of mass in the middle, the first hinged to the origin; angles from the x axis."""

    length: np.ndarray  # (n,) m
    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (n,) kg m^2, about the centres
    gravity: float  # m/s^2, downward
    angle: np.ndarray  # (n,) rad, at t = 0, at rest

    @cached_property
    def carried(self) -> np.ndarray:
        """Mass (kg) hanging on the far end of each rod, with half its own."""
        beyond = np.cumsum(self.mass[::-1])[::-1] - self.mass
        return 0.5 * self.mass + beyond

    def coupling(self) -> np.ndarray:
        """Return c (n, n), kg m^2: the mass matrix is c_ij cos(theta_i - theta_j)."""
        index = np.arange(len(self.length))
        c = np.outer(self.length, self.length) * self.carried[np.maximum.outer(index, index)]
        c[index, index] = self.inertia + self.length**2 * (self.carried - 0.25 * self.mass)
        return c

    def crossed(self, sin: np.ndarray, cos: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Return sum_j c_ij sin(theta_i - theta_j) w_j (n,), by running sums."""
        return sin * self._spread(cos * w) - cos * self._spread(sin * w)

    def _spread(self, x: np.ndarray) -> np.ndarray:
        """Return sum_j l_i l_j carried_max(i,j) x_j (n,)."""
        moment = self.length * x
        nearer = np.cumsum(moment)
        beyond = np.cumsum((self.carried * moment)[::-1])[::-1] - self.carried * moment
        return self.length * (self.carried * nearer + beyond)

    def poses(self, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the centres (n, 2) m and the angles."""
        along = self.length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.cumsum(along, axis=0) - along / 2, angle


def lagrange(rods: Rods) -> Formulation:
    """Return y = (theta, theta'), with d_ij = theta_i - theta_j:

    sum_j c_ij [cos(d_ij) theta_j'' + sin(d_ij) theta_j'^2] + g l_i carried_i cos(theta_i) = 0.
    """
    c, weight = rods.coupling(), rods.gravity * rods.length * rods.carried

    def derivative(t, y):
        angle, rate = np.split(y, 2)
        cos, sin = np.cos(angle), np.sin(angle)
        pull = rods.crossed(sin, cos, rate**2) + weight * cos
        return np.concatenate([rate, -solve(_mass(c, cos, sin), pull)])

    start = np.concatenate([rods.angle, np.zeros_like(rods.angle)])
    return Formulation(derivative, start, lambda t, y: rods.poses(y[: len(rods.length)]))


def hamilton(rods: Rods) -> Formulation:
    """Return y = (theta, p) with p = M theta', d_ij = theta_i - theta_j:

    p_i' = -theta_i' sum_j c_ij sin(d_ij) theta_j' - g l_i carried_i cos(theta_i).
    """
    c, weight = rods.coupling(), rods.gravity * rods.length * rods.carried

    def derivative(t, y):
        angle, momentum = np.split(y, 2)
        cos, sin = np.cos(angle), np.sin(angle)
        rate = solve(_mass(c, cos, sin), momentum)
        return np.concatenate([rate, -rate * rods.crossed(sin, cos, rate) - weight * cos])

    start = np.concatenate([rods.angle, np.zeros_like(rods.angle)])
    return Formulation(derivative, start, lambda t, y: rods.poses(y[: len(rods.length)]))


def _mass(c: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    return c * (np.outer(cos, cos) + np.outer(sin, sin))


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve a positive definite system in the precision of `right` (compiled code knows double only)."""
    if right.dtype == np.float64:
        return factor_and_solve(matrix, right)
    n = len(right)
    work = np.column_stack([matrix, right])
    for k in range(n):
        work[k] /= work[k, k]
        work[k + 1 :] -= work[k + 1 :, k, None] * work[k]
    x = work[:, n]
    for k in range(n - 1, 0, -1):
        x[:k] -= work[:k, k] * x[k]
    return x


@strict_jit
def factor_and_solve(matrix, right):
    """Plain loops: a threaded LAPACK call is 30 times slower at this size on a busy machine."""
    n = len(right)
    low, x = matrix.copy(), right.copy()
    for j in range(n):
        for k in range(j):
            for i in range(j, n):
                low[j, i] -= low[k, i] * low[k, j]  # the factor is stored transposed: rows are contiguous
        pivot = np.sqrt(low[j, j])
        for i in range(j, n):
            low[j, i] /= pivot
    for j in range(n):
        x[j] /= low[j, j]
        for i in range(j + 1, n):
            x[i] -= low[j, i] * x[j]
    for j in range(n - 1, -1, -1):
        for i in range(j + 1, n):
            x[j] -= low[j, i] * x[i]
        x[j] /= low[j, j]
    return x
