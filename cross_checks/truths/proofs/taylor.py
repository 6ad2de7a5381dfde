"""Taylor polynomials of y' = f(y, z), 0 = g(y, z) by Newton's method: what the prover proposes, unproven."""

from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_poly, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.bounds import ORDER, Step, variations
from cross_checks.truths.proofs.checker.formulas import Formulas, Polynomials, Refused, exact, precision, terms

LAST = 6  # coefficients that state the radius of convergence: series may have gaps
SLOWEST = 2.0**-4  # 1 / radius of convergence at most, in units of time of the polynomials
ITERATIONS = 30  # of Newton's method
ROUGH = 2.0**-10  # of a correction, above which the Jacobian is computed again
BEST = 2.0**-40  # of a correction, the least next one that is expected: the Jacobian is in floats


def propose(
    formulas: Formulas, h: Fraction, p: Polynomials, degree: int, bits: int, jacobian: np.ndarray | None = None
) -> tuple[Polynomials, float]:  # fmt: skip
    """Return polynomials of y and z in units of time h, from p near them, and their radius of convergence in h.

    The start of y is that of p. Each iteration doubles the terms, at most. The radius is the least by the last
    coefficients of the polynomials and of the Jacobian, whose series near p's is computed unless given. Refused where
    Newton's method does not converge.
    """
    n, last = formulas.n, ROUGH
    jacobian = np.zeros((0, len(p), len(p))) if jacobian is None else jacobian
    for _ in range(ITERATIONS):
        count = min(2 * len(p[0]), degree + 1)
        before = last if count == len(p[0]) else 1.0
        p = [[*row, *[arb(0)] * (count - len(row))] for row in p]
        if last > ROUGH or len(jacobian) < min(ORDER, count):
            jacobian = Step(formulas, h, p).slopes()[0]
        with precision(bits + 32, count):
            values = formulas.run([*formulas.f, *formulas.g], [arb_series(row, count) for row in p])
            unit, defects = exact(h), [terms(value, count) for value in values]
            for k, row in enumerate(p[:n]):
                defects[k] = [unit * c - row[j + 1] * (j + 1) for j, c in enumerate(defects[k][:-1])] + [arb(0)]
            source = np.array([list(map(float, row)) for row in defects]).T[:, :, None]
            change = variations(jacobian, np.zeros((n, 1)), source)[:, :, 0].T
            p = [[(c + d).mid() for c, d in zip(*pair, strict=True)] for pair in zip(p, change.tolist(), strict=True)]
        size = np.array([list(map(float, row)) for row in p])
        last = np.max(np.abs(change) / np.maximum(np.abs(size), 1.0))
        if count > degree and last * max(BEST, min(1.0, last / before)) < 2.0**-bits:
            return p, 1.0 / max(SLOWEST, _growth(jacobian), _growth(size.T))
    raise Refused("Newton's method finds no polynomial")


def _growth(series: np.ndarray) -> float:
    """Return by which factor the last coefficients grow; of a coefficient, relative to 1 and to the first one."""
    size, last = np.maximum(np.abs(series[0]), 1.0), np.arange(len(series) - LAST, len(series))
    largest = np.max(np.abs(series[last]) / size, axis=tuple(range(1, series.ndim)))
    return float((largest ** (1.0 / last)).max())


def rescaled(p: Polynomials, ratio: Fraction, bits: int) -> list[list[int]]:
    """Return the coefficients over 2^bits in another unit of time, `ratio` of the first."""
    with precision(bits + 32):
        factors: list[Any] = [exact(ratio**k * 2**bits) for k in range(len(p[0]))]
        pairs = [zip(row, factors, strict=True) for row in p]
        return [[int((factor * c).mid().floor().unique_fmpz()) for c, factor in own] for own in pairs]


def continued(p: Polynomials, ratio: Fraction, start: list[arb], bits: int) -> Polynomials:
    """Return the polynomials from another start, a time `ratio` later, in units of that time."""
    with precision(bits + 32):
        later = arb_poly([exact(ratio), exact(ratio)])
        moved = [[c.mid() for c in arb_poly(row)(later).coeffs()] for row in p]
        return [[x, *row[1:], *[arb(0)] * (len(p[0]) - max(1, len(row)))] for x, row in zip(start, moved, strict=True)]
