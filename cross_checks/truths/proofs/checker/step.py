"""Bounds of a log's formulas about the polynomials of one step, whose length is the unit of time."""

from fractions import Fraction

import numpy as np
from flint import acb, arb, arb_series, ctx  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import GAMMA, Polynomials, above, exact, precision, terms, up
from cross_checks.truths.proofs.checker.bounds import ORDER
from cross_checks.truths.proofs.checker.formulas import Formulas

LONGER = 3  # halves of the polynomial's terms: so many of its defect are computed, and the others bounded
DISCS = (1.5, 2.0, 3.0, 4.0, 5.0, 6.5)  # radii of discs in steps; the best one counts


class Step:
    """Polynomials of y and z for a time h; rows of f are multiplied by h. Series end in Cauchy's estimate on a disc."""

    def __init__(self, formulas: Formulas, h: Fraction, p: Polynomials) -> None:
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
                    rates = [c * j for j, c in enumerate(self.p[k])][1:]
                    value = exact(self.h) * value - arb_series(rates, count)
                sums.append(sum(map(above, terms(value, count))))
        for radius in DISCS:
            with precision(64):
                most = np.array([above(value) for value in self.formulas.run(self.roots, self._discs(radius))])
            tails.append((up(most * self.factor * radius ** -float(count) / (1 - 1 / radius)), radius))
        tail, radius = min(tails, key=lambda one: np.nan_to_num(one[0], nan=np.inf).max())
        return up(up(sums) + tail), radius

    def jacobian(self, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the series of the Jacobian by y and z to ORDER terms, and bounds of its error."""
        size = len(self.p)
        jacobian, error = np.zeros((ORDER, size, size)), np.zeros((size, size))
        with precision(64, ORDER):
            bounds = self.formulas.slopes(self.roots, self._discs(radius))
            series = self.formulas.slopes(self.roots, [arb_series(row[:ORDER], ORDER) for row in self.p])
        for i, (row, most) in enumerate(zip(series, bounds, strict=True)):
            for j, slope in row.items():
                own = terms(slope, ORDER)
                jacobian[:, i, j] = [float(c.mid()) for c in own]
                tail = above(most[j]) * radius ** -float(ORDER) / (1.0 - 1.0 / radius)
                error[i, j] = sum(float(c.rad()) for c in own) + tail
        error = up(error + GAMMA * np.abs(jacobian).sum(0))
        return jacobian * self.factor[:, None], up(error * self.factor[:, None])

    def second_order(self, e: np.ndarray) -> np.ndarray:
        """Return bounds of the second-order terms for deviations |e|."""
        reach = up(self.size[:, 1:].sum(1) + e)
        with precision(64, 3):
            rows = zip(self.p, reach, e, strict=True)
            boxes = [arb_series([arb(row[0].mid(), d), arb(0, float(s))], 3) for row, d, s in rows]
            values = self.formulas.run(self.roots, boxes)
            return up(self.factor * [above(terms(value, 3)[2]) for value in values])
