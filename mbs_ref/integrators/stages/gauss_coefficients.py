"""Gauss-Legendre collocation with eight stages, order 16, computed to fifty digits and split in two doubles."""

import math
from decimal import Decimal, localcontext
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats

STAGES = 8
DIGITS = 60


class Gauss(NamedTuple):
    """Coefficients over [0, 1]; *_low is what the double leaves out, without which energy drifts steadily."""

    c: Annotated[Floats, 8]  # nodes
    a: Annotated[Floats, 8, 8]  # velocities: v_i = v + h sum a_ij f_j
    abar: Annotated[Floats, 8, 8]  # positions: x_i = x + c_i h v + h^2 sum abar_ij f_j
    a_low: Annotated[Floats, 8, 8]
    abar_low: Annotated[Floats, 8, 8]
    b: Annotated[Floats, 8]  # weights of the velocity
    bbar: Annotated[Floats, 8]  # weights of the position, b_j (1 - c_j)
    b_low: Annotated[Floats, 8]
    bbar_low: Annotated[Floats, 8]
    legendre: Annotated[Floats, 2, 8]  # the two highest Legendre coefficients of the stage accelerations
    weight: Annotated[Floats, 8]  # barycentric weights of the nodes
    c_low: Annotated[Floats, 8]


def _legendre(n: int, x: Decimal) -> tuple[Decimal, Decimal]:
    """Return P_n(x) and P_(n-1)(x)."""
    old, new = Decimal(1), x
    for k in range(1, n):
        old, new = new, ((2 * k + 1) * x * new - k * old) / (k + 1)
    return new, old


def _nodes() -> tuple[list[Decimal], list[Decimal]]:
    """Return nodes and weights on [0, 1]: the roots of P_8, by Newton's method."""
    nodes, weights = [], []
    for start in np.polynomial.legendre.leggauss(STAGES)[0]:
        x = Decimal(float(start))
        for _ in range(6):
            p, q = _legendre(STAGES, x)
            slope = STAGES * (x * p - q) / (x * x - 1)
            x -= p / slope
        p, q = _legendre(STAGES, x)
        slope = STAGES * (x * p - q) / (x * x - 1)
        nodes.append((x + 1) / 2)
        weights.append(1 / ((1 - x * x) * slope * slope))
    return nodes, weights


def _integrals(nodes: list[Decimal], j: int) -> list[Decimal]:
    """Return the coefficients (constant first) of the integral of Lagrange's polynomial j."""
    poly = [Decimal(1)]
    for k, c in enumerate(nodes):
        if k != j:
            shifted = [Decimal(0), *poly]
            poly = [s - c * p for s, p in zip(shifted, [*poly, Decimal(0)], strict=True)]
            poly = [p / (nodes[j] - c) for p in poly]
    return [Decimal(0), *(p / (k + 1) for k, p in enumerate(poly))]


def _split(values: list) -> tuple[np.ndarray, np.ndarray]:
    exact = np.array(values, dtype=object)
    high = exact.astype(float)
    low = np.vectorize(lambda e, h: float(e - Decimal(float(h))))(exact, high)
    return high, low


@cache
def gauss() -> Gauss:
    """Return the coefficients (Hairer, Lubich, Wanner, Geometric Numerical Integration, sec. II.1.3)."""
    with localcontext() as context:
        context.prec = DIGITS
        c, b = _nodes()
        columns = [_integrals(c, j) for j in range(STAGES)]
        a = [[sum(p * x**k for k, p in enumerate(columns[j])) for j in range(STAGES)] for x in c]
        abar = [[sum(a[i][m] * a[m][j] for m in range(STAGES)) for j in range(STAGES)] for i in range(STAGES)]
        bbar = [w * (1 - x) for w, x in zip(b, c, strict=True)]
        high = [[(2 * k + 1) * b[j] * _legendre(k, 2 * c[j] - 1)[0] for j in range(STAGES)] for k in (6, 7)]
        weights = [1 / math.prod((x - y for y in c if y != x), start=Decimal(1)) for x in c]
        (ch, cl), (ah, al), (abh, abl), (bh, bl), (bbh, bbl) = (_split(v) for v in (c, a, abar, b, bbar))
    return Gauss(
        ch, ah, abh, al, abl, bh, bbh, bl, bbl, np.array(high, dtype=float), np.array(weights, dtype=float), cl
    )
