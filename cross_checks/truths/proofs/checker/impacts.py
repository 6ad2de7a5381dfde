"""Impacts by the formulas of a log, which the model has compared with the checker's mechanics.

Between impacts every clearance stays positive. In the window of an impact one falls from positive to negative: all
motions of the enclosure pass through its one root (transversality).
"""

from fractions import Fraction

import numpy as np
from flint import arb, arb_mat  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.formulas import GAMMA, Polynomials, Refused, above, beside, exact, up
from cross_checks.truths.proofs.checker.model import Model, matrix_of, newton, solve

WIDE = 2.0**40  # of z after an impact
ITERATIONS = 4  # for an enclosure of the motion after an impact
FINEST = 12  # halvings of a step where a gap may close


class Impacts:
    """The contacts of a model. `times` has the name and the time (s) of every impact so far."""

    def __init__(self, model: Model) -> None:
        self.model, self.formulas, self.names = model, model.formulas, [part.name for part in model.scene.contacts]
        self.opening = -1  # the contact of an impact that the last step ended with
        self.times: list[tuple[str, arb]] = []

    def gap(self, k: int, y: list[arb]) -> list[arb]:
        """Return the clearance of a contact and its rate, in the units of the formulas."""
        return self.formulas.run(self.model.contacts[k][:2], y)

    def watch(self, p: Polynomials, e: np.ndarray, window: Fraction) -> None:
        """Refuse unless no gap closes in a step, but one at its end, in the window, where it is not 0."""
        if self.names:
            self._keep_open(p, e, Fraction(0), 1 - window, FINEST)
        self.opening = -1
        if not window:
            return
        spans = exact(1 - window), between(1 - window, Fraction(1)), arb(1)
        states = [beside(p, e, s) for s in spans]
        closing = [k for k in range(len(self.names)) if not self.gap(k, states[1])[0] > 0]
        gaps = [self.gap(k, y) for k in closing for y in states]
        if len(closing) != 1 or not (gaps[0][0] > 0 and gaps[1][1] < 0 and gaps[2][0] < 0):
            raise Refused("an impact may be grazing, or one of several at once")
        (self.opening,) = closing

    def _keep_open(self, p: Polynomials, e: np.ndarray, low: Fraction, high: Fraction, depth: int) -> None:
        whole, last = (beside(p, e, s) for s in (between(low, high), exact(high)))
        for k, name in enumerate(self.names):
            gap, rate = self.gap(k, whole)
            opens = k == self.opening and not low and rate > 0
            if gap > 0 or opens or (rate < 0 and self.gap(k, last)[0] > 0):
                continue
            if not depth:
                raise Refused(f"contact {name} may close")
            self._keep_open(p, e, low, (low + high) / 2, depth - 1)
            self._keep_open(p, e, (low + high) / 2, high, depth - 1)
            return

    def after(
        self, p: Polynomials, e: np.ndarray, t: Fraction, h: Fraction, window: Fraction
    ) -> tuple[list[arb], list[arb], np.ndarray, np.ndarray]:
        """Return, at the end of a step from t, where the motion from p is and z of all, and the saltation matrix.

        The matrix has the derivatives of the end of a motion by where it is as the window begins; a bound of its error.
        """
        whole, middle = between(1 - window, Fraction(1)), exact(1 - window / 2)
        part, y = self.opening, beside(p, e, whole)
        rates, rebound = self._rates(y), self.model.after(part, y)
        lasting, wider = between(Fraction(0), window * h), between(-window * h, 2 * window * h)
        later = self._rates(rebound)
        for _ in range(ITERATIONS):
            wide = [x + wider * rate for x, rate in zip(rebound, later, strict=True)]
            later = self._rates(wide)
            end = [x + lasting * rate for x, rate in zip(rebound, later, strict=True)]
            if all(a.contains(b) for a, b in zip(wide, end, strict=True)):
                break
        else:
            raise Refused("the motion after an impact is not enclosed")
        for other in range(len(self.names)):
            gap, rate = self.gap(other, end)
            if not (rate if other == part else gap) > 0:
                raise Refused("an impact does not open its contact, or closes another")
        slopes = beside([[c * k for k, c in enumerate(row)][1:] for row in p], 0 * e, whole)
        drift = [lasting * (rate - slope / exact(h)) for rate, slope in zip(rates, slopes, strict=True)]

        def near(s: arb) -> list[arb]:
            """Return where the motion from p is, at or within a time of the window."""
            return [x + d for x, d in zip(beside(p, 0 * e, s), drift, strict=True)]

        (gap, _), (_, rate) = (self.gap(part, near(s)) for s in (middle, whole))
        instant = middle - gap / (rate * exact(h))
        left, rebounding = (1 - instant) * exact(h), self.model.after(part, near(instant))
        image = [x + left * rate for x, rate in zip(rebounding, later, strict=True)]
        self.times.append((self.names[part], between(t + h * (1 - window), t + h) * exact(self.model.units[1])))
        rows = self._saltation(part, y, wide, rates, later, window * h).tolist()
        matrix = np.array([[float(x) for x in row] for row in rows])
        rest = [[float(x.rad()) for x in row] for row in rows]
        return image, self.enclose(end), matrix, up(up(rest) + GAMMA * np.abs(matrix))

    def _saltation(
        self, part: int, y: list[arb], wide: list[arb], rates: list[arb], later: list[arb], lasting: Fraction
    ) -> arb_mat:
        """Return M (R M + (R f - f+) u), u = -n M / (n f): R of the rebound, n of the gap, M of motion.

        With |A| a bound of the derivatives of the rates by y, |M - 1| is at most exp(t |A|) - 1 in every entry.
        """
        n, (clearance, _, changes) = len(y), self.model.contacts[part]
        slopes = self.formulas.slopes([clearance, *(place for _, place in changes)], y)
        normal, *changed = matrix_of(slopes, n)
        moved, turn = (arb_mat(n, n, [int(j == k) for j in range(n) for k in range(n)]) for _ in range(2))
        for (column, _), row in zip(changes, changed, strict=True):
            for k, x in enumerate(row):
                turn[column, k] = x
        growth = ((self._slope(y) + self._slope(wide)) * exact(lasting)).exp() - moved
        moved += arb_mat(n, n, [x * arb(0, 1) for x in growth.entries()])
        gradient, f = arb_mat([normal]) * moved, arb_mat(n, 1, rates)
        jump = (turn * f - arb_mat(n, 1, later)) * (-1 / (arb_mat([normal]) * f)[0, 0])
        return moved * (turn * moved + jump * gradient)

    def enclose(self, y: list[arb]) -> list[arb]:
        """Return balls of the one z below WIDE with g(y, z) = 0, for every y in balls (interval Newton)."""
        m = self.formulas.m
        z = newton(self.formulas, y, [arb(0)] * m, [arb(0, WIDE)] * m) if m else []
        if not all(above(x) < WIDE for x in z):
            raise Refused("after an impact, the accelerations are not enclosed")
        return z

    def _rates(self, y: list[arb]) -> list[arb]:
        return self.formulas.run(self.formulas.f, [*y, *self.enclose(y)])

    def _slope(self, y: list[arb]) -> arb_mat:
        """Return bounds of the derivatives of the rates by y."""
        formulas, state, n = self.formulas, [*y, *self.enclose(y)], len(y)
        f, g = (arb_mat(matrix_of(formulas.slopes(rows, state), len(state))) for rows in (formulas.f, formulas.g))
        own = [arb_mat([row[part] for row in rows.tolist()]) for rows in (f, g) for part in (slice(n), slice(n, None))]
        own[2] = solve(own[3], own[2])
        f_y, f_z, through, _ = (arb_mat(x.nrows(), x.ncols(), list(map(abs, x.entries()))) for x in own)
        return f_y + f_z * through


def between(low: Fraction, high: Fraction) -> arb:
    """Return the ball that has low and high at its ends."""
    return exact((low + high) / 2) + exact((high - low) / 2) * arb(0, 1)
