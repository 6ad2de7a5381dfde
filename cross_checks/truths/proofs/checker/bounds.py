"""Bounds on a step, whose length is the unit of time: of formulas about its polynomials, of flows and inverses."""

from fractions import Fraction

import numpy as np
from flint import acb, arb, arb_series, ctx  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.formulas import GAMMA, Formulas, Refused, above, exact, precision, terms, up

ORDER = 20  # terms of V, W, the Jacobian and inverses: their defect is about 6^-ORDER
LONGER = 3  # halves of the polynomial's terms: so many of its defect are computed, and the others bounded
DISCS = (1.5, 2.0, 3.0, 4.0, 5.0, 6.5)  # radii of discs in steps; the best one counts


class Step:
    """Polynomials of y and z for a time h; rows of f are multiplied by h. Series end in Cauchy's estimate on a disc."""

    def __init__(self, formulas: Formulas, h: Fraction, p: list[list[arb]]) -> None:
        self.formulas, self.h, self.p, self.roots = formulas, h, p, [*formulas.f, *formulas.g]
        self.size = np.array([[above(c) for c in row] for row in p])
        self.factor = np.where(np.arange(len(p)) < formulas.n, float(h), 1.0)

    def _discs(self, radius: float) -> list[acb]:
        """Return discs that hold the polynomials for |t| <= radius."""
        reach = up(self.size[:, 1:] @ (radius ** np.arange(1.0, self.size.shape[1])))
        return [acb(arb(row[0].mid(), d) + 0, arb(0, d)) for row, d in zip(self.p, reach, strict=True)]

    def defects(self) -> tuple[np.ndarray, float]:
        """Return bounds of |p' - h f(p)| and |g(p)|, and the radius of the best disc."""
        count, sums, tails = LONGER * len(self.p[0]) // 2, [], []
        with precision(ctx.prec, count):
            values = self.formulas.run(self.roots, [arb_series(row, count) for row in self.p])
            for k, value in enumerate(values):
                if k < self.formulas.n:
                    value = exact(self.h) * value - arb_series([c * j for j, c in enumerate(self.p[k])][1:], count)
                sums.append(sum(map(above, terms(value, count))))
        for radius in DISCS:
            with precision(64):
                most = np.array([above(value) for value in self.formulas.run(self.roots, self._discs(radius))])
            tails.append((up(most * self.factor * radius ** -float(count) / (1 - 1 / radius)), radius))
        tail, radius = min(tails, key=lambda one: np.nan_to_num(one[0], nan=np.inf).max())
        return up(up(sums) + tail), radius

    def slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the series of the Jacobian by y and z to at most ORDER terms, and bounds of their rounding."""
        size, count = len(self.p), min(ORDER, len(self.p[0]))
        jacobian, error = np.zeros((count, size, size)), np.zeros((size, size))
        with precision(64, count):
            series = self.formulas.slopes(self.roots, [arb_series(row[:count], count) for row in self.p])
        for i, row in enumerate(series):
            for j, slope in row.items():
                own = terms(slope, count)
                jacobian[:, i, j] = list(map(float, own))
                error[i, j] = float(sum(own, arb(0)).rad())  # a sum of balls has the sum of their radii, at least
        error = up(error + GAMMA * np.abs(jacobian).sum(0))
        return jacobian * self.factor[:, None], up(error * self.factor[:, None])

    def jacobian(self, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the series of the Jacobian, and bounds of its error on the step."""
        jacobian, error = self.slopes()
        with precision(64):
            for i, row in enumerate(self.formulas.slopes(self.roots, self._discs(radius))):
                for j, slope in row.items():
                    error[i, j] += self.factor[i] * above(slope) * radius ** -float(ORDER) / (1.0 - 1.0 / radius)
        return jacobian, up(error)

    def second_order(self, e: np.ndarray) -> np.ndarray:
        """Return bounds of the second-order terms for deviations |e|."""
        reach = up(self.size[:, 1:].sum(1) + e)
        with precision(64, 3):
            rows = zip(self.p, reach, e, strict=True)
            boxes = [arb_series([arb(row[0].mid(), d), arb(0, float(s))], 3) for row, d, s in rows]
            values = self.formulas.run(self.roots, boxes)
            return up(self.factor * [above(terms(value, 3)[2]) for value in values])


def size_of(matrix: np.ndarray) -> np.ndarray:
    """Return a bound of |matrix(t)| on the step."""
    return up(np.abs(matrix).sum(0))


def product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of a b, and a bound of their rounding."""
    whole = np.zeros((len(a) + len(b) - 1, a.shape[1], b.shape[2]))
    for j, own in enumerate(a):
        whole[j : j + len(b)] += own @ b
    return whole, up(GAMMA * up(size_of(a) @ size_of(b)))


def times(a: np.ndarray, a_error: np.ndarray, b: np.ndarray, b_error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the product of two matrices, and a bound of its error by theirs and by rounding."""
    return a @ b, up(up(up(np.abs(a) + a_error) @ b_error) + up(a_error + GAMMA * np.abs(a)) @ np.abs(b))


def variations(jacobian: np.ndarray, start: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Return V and W, V' = f_y V + f_z W + source, 0 = g_y V + g_z W + source, to as many terms as the source has."""
    n, flow, rows = len(start), np.zeros_like(source), jacobian.swapaxes(0, 1).reshape(len(jacobian[0]), -1)
    flow[0, :n], inverse = start, np.linalg.inv(jacobian[0, n:, n:])
    for k, own in enumerate(source):
        past = flow[max(0, k + 1 - len(jacobian)) : k + 1][::-1].reshape(-1, flow.shape[2])
        total = own + rows[:, : len(past)] @ past
        flow[k, n:] = -inverse @ total[n:]
        if k + 1 < len(source):
            flow[k + 1, :n] = (total[:n] + jacobian[0, :n, n:] @ flow[k, n:]) / (k + 1)
    return flow


def defects_of(jacobian: np.ndarray, error: np.ndarray, flow: np.ndarray, n: int) -> np.ndarray:
    """Return bounds of the defects of the equations of V and W on the step."""
    (whole, rounding), size = product(jacobian, flow), size_of(flow)
    whole[: ORDER - 1, :n] -= np.arange(1, ORDER)[:, None, None] * flow[1:, :n]
    rounding[:n] += GAMMA * ORDER * size[:n]
    return up(size_of(whole) + up(rounding + error @ size))


def inverse_of(matrix: np.ndarray, error: float | np.ndarray = 0.0) -> tuple[np.ndarray, float]:
    """Return K near 1 / matrix(t), to ORDER terms, and c: |x| <= |K y| + c max|K y| where (matrix + error) x = y.

    1 - K matrix has row sums below 1 / 2 on the step, or Refused is raised; c bounds the rest of its Neumann series.
    """
    own = np.zeros((min(len(matrix), ORDER), *matrix.shape[1:]))
    own[0] = np.linalg.inv(matrix[0])
    for k in range(1, len(own)):
        own[k] = -own[0] @ sum(matrix[j] @ own[k - j] for j in range(1, k + 1))
    rest, rounding = product(own, matrix)
    rest[0] -= np.eye(matrix.shape[1])
    gap = up(size_of(rest) + up(rounding + size_of(own) @ (error + np.zeros_like(rounding))))
    most = float(up(gap.sum(1)).max(initial=0.0))
    if not most < 0.5:
        raise Refused("a matrix is singular within the step")
    return own, float(up(most / (1.0 - most)))


def inverse_bound(matrix: np.ndarray, error: float | np.ndarray = 0.0) -> np.ndarray:
    """Return a bound of |1 / matrix(t)| on the step."""
    own, rest = inverse_of(matrix, error)
    size = size_of(own)
    return up(size + rest * size.max(0, initial=0.0))
