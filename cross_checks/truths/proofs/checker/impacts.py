"""Impacts of free bodies without friction, in the numbers of the checker's mechanics.

Between impacts every gap stays positive. In the window of an impact one gap falls from positive to negative: all
motions of the enclosure pass through its one root (transversality).
"""

from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import (
    GAMMA,
    Number,
    Polynomials,
    Refused,
    above,
    beside,
    exact,
    terms,
    up,
)
from cross_checks.truths.proofs.checker.mechanics import dot, minus
from cross_checks.truths.proofs.checker.model import Model, matrix_of, newton, solve
from cross_checks.truths.proofs.coverage import PAIRS

WIDE = 2.0**40  # of z after an impact
FINEST = 12  # halvings of a step where a gap may close


class Impacts:
    """The contacts of a model. `times` has the name and the time (s) of every impact so far."""

    def __init__(self, model: Model) -> None:
        self.model, self.mechanics, self.parts = model, model.mechanics, model.scene.contacts
        self.opening = ""  # the contact of an impact that the last step ended with
        self.times: list[tuple[str, arb]] = []

    def gap(self, part: Any, bodies: list[list[Number]]) -> tuple[Number, Number, list[Number], list[int]]:
        """Return a gap (m), its rate (m/s), the normal from body b to body a, and both bodies (ground: -1)."""
        vector, ball = self.mechanics.vector, self.mechanics.ball
        ends = [self.mechanics.index[name] for name in part.ends]
        states = [bodies[k] if k >= 0 else [arb(0)] * 14 for k in ends]
        apart, speed = minus(*(own[:3] for own in states)), minus(*(own[8:11] for own in states))
        if part.type in PAIRS:
            normal, radius = apart, ball(part.radius_a) + ball(part.radius_b)
        elif part.type == "circle_on_line":
            start, end, radius = vector(part.point_1), vector(part.point_2), ball(part.radius)
            apart, normal = minus(apart, start), [start[1] - end[1], end[0] - start[0], arb(0)]
        else:
            apart, normal, radius = minus(apart, vector(part.point)), vector(part.normal), ball(part.radius)
        size = dot(normal, normal).sqrt()
        normal = [x / size for x in normal]
        return dot(normal, apart) - radius, dot(normal, speed), normal, ends

    def watch(self, p: Polynomials, e: np.ndarray, window: Fraction) -> None:
        """Refuse unless no gap closes in a step, but one at its end, in the window, where it is not 0."""
        self._keep_open(p, e, Fraction(0), 1 - window, FINEST)
        self.opening = ""
        if not window:
            return
        spans = exact(1 - window), between(1 - window, Fraction(1)), arb(1)
        bodies = [self.model.bodies(beside(p, e, s)) for s in spans]
        closing = [part for part in self.parts if not self.gap(part, bodies[1])[0] > 0]
        gaps = [self.gap(part, at) for part in closing for at in bodies]
        if len(closing) != 1 or not (gaps[0][0] > 0 and gaps[1][1] < 0 and gaps[2][0] < 0):
            raise Refused("an impact may be grazing, or one of several at once")
        self.opening = closing[0].name

    def _keep_open(self, p: Polynomials, e: np.ndarray, low: Fraction, high: Fraction, depth: int) -> None:
        bodies, last = (self.model.bodies(beside(p, e, s)) for s in (between(low, high), exact(high)))
        for part in self.parts:
            gap, rate, *_ = self.gap(part, bodies)
            opens = part.name == self.opening and not low and rate > 0
            if gap > 0 or opens or (rate < 0 and self.gap(part, last)[0] > 0):
                continue
            if not depth:
                raise Refused(f"contact {part.name} may close")
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
        (part,) = (part for part in self.parts if part.name == self.opening)
        y = beside(p, e, whole)
        rates, rebound = self._rates(y), self._rebound(part, y)
        lasting, wider = between(Fraction(0), window * h), between(-window * h, 2 * window * h)
        wide = [x + wider * rate for x, rate in zip(rebound, self._rates(rebound), strict=True)]
        later = self._rates(wide)
        end = [x + lasting * rate for x, rate in zip(rebound, later, strict=True)]
        if not all(a.contains(b) for a, b in zip(wide, end, strict=True)):
            raise Refused("the motion after an impact is not enclosed")
        for other in self.parts:
            gap, rate, *_ = self.gap(other, self.model.bodies(end))
            if not (rate if other is part else gap) > 0:
                raise Refused("an impact does not open its contact, or closes another")
        slopes = beside([[c * k for k, c in enumerate(row)][1:] for row in p], 0 * e, whole)
        drift = [lasting * (rate - slope / exact(h)) for rate, slope in zip(rates, slopes, strict=True)]

        def near(s: arb) -> list[arb]:
            """Return where the motion from p is, at or within a time of the window."""
            return [x + d for x, d in zip(beside(p, 0 * e, s), drift, strict=True)]

        (gap, *_), (_, rate, *_) = (self.gap(part, self.model.bodies(near(s))) for s in (middle, whole))
        instant = middle - gap / (rate * exact(h * self.model.units[1]))
        left, rebounding = (1 - instant) * exact(h), self._rebound(part, near(instant))
        image = [x + left * rate for x, rate in zip(rebounding, later, strict=True)]
        self.times.append((part.name, between(t + h * (1 - window), t + h) * exact(self.model.units[1])))
        rows = self._saltation(part, y, wide, rates, later, window * h).tolist()
        matrix = np.array([[float(x) for x in row] for row in rows])
        rest = [[float(x.rad()) for x in row] for row in rows]
        return image, self.enclose(end), matrix, up(up(rest) + GAMMA * np.abs(matrix))

    def _saltation(
        self, part: Any, y: list[arb], wide: list[arb], rates: list[arb], later: list[arb], lasting: Fraction
    ) -> arb_mat:
        """Return M (R M + (R f - f+) u), u = -n M / (n f): R of the rebound, n of the gap, M of motion."""
        n, columns = len(y), []
        for k in range(n):
            along = [arb_series([x, int(j == k)], 2) for j, x in enumerate(y)]
            values = [self.gap(part, self.model.bodies(along))[0], *self._rebound(part, along)]
            columns.append([terms(value, 2)[1] for value in values])
        normal, *rows = map(list, zip(*columns, strict=True))
        growth = (exact(lasting) * (self._slope(y) + self._slope(wide))).exp() - 1
        moved = arb_mat([[(j == k) + arb(0, 1) * growth for k in range(n)] for j in range(n)])
        gradient, turn, f = arb_mat([normal]) * moved, arb_mat(rows), arb_mat(n, 1, rates)
        jump = (turn * f - arb_mat(n, 1, later)) * (-1 / (arb_mat([normal]) * f)[0, 0])
        return moved * (turn * moved + jump * gradient)

    def _rebound(self, part: Any, y: list[Number]) -> list[Number]:
        """Return y after an impact: v+ = -e v- along the normal."""
        formulas, (length, unit, _), bodies = self.model.formulas, self.model.units, self.model.bodies(y)
        _, rate, normal, ends = self.gap(part, bodies)
        ball, masses = self.mechanics.ball, [body.mass for body in self.model.scene.bodies]
        inverse = {k: 1 / ball(masses[k]) for k in ends if k >= 0}
        impulse, y = -(1 + ball(part.law.restitution)) * rate / sum(inverse.values(), arb(0)), list(y)
        for k, way in ((k, way) for k, way in zip(ends, (1, -1), strict=True) if k >= 0):
            for place, v, x in zip(formulas.outputs[k][8:11], bodies[k][8:11], normal, strict=True):
                operation, column, _ = formulas.lines[place]
                v = v + impulse * inverse[k] * way * x
                if operation == "y":
                    y[column] = v / exact(length / unit)
                elif not all(c.is_zero() for c in terms(v, 2)):
                    raise Refused("a velocity is no coordinate")
        return y

    def enclose(self, y: list[arb]) -> list[arb]:
        """Return balls of the one z below WIDE with g(y, z) = 0, for every y in balls (interval Newton)."""
        m = self.model.formulas.m
        z = newton(self.model.formulas, y, [arb(0)] * m, [arb(0, WIDE)] * m) if m else []
        if not all(above(x) < WIDE for x in z):
            raise Refused("after an impact, the accelerations are not enclosed")
        return z

    def _rates(self, y: list[arb]) -> list[arb]:
        return self.model.formulas.run(self.model.formulas.f, [*y, *self.enclose(y)])

    def _slope(self, y: list[arb]) -> arb:
        """Return a bound of the norm of the derivatives of the rates by y."""
        formulas, state, n = self.model.formulas, [*y, *self.enclose(y)], len(y)
        f, g = (matrix_of(formulas.slopes(rows, state), len(state)) for rows in (formulas.f, formulas.g))
        through = solve(arb_mat([row[n:] for row in g]), arb_mat([row[:n] for row in g])).entries() if g else []
        by_y, by_z = ([x for row in f for x in row[part]] for part in (slice(n), slice(n, None)))
        return _size(by_y) + _size(by_z) * _size(through)


def _size(values: list[arb]) -> arb:
    return sum(map(abs, values), arb(0))


def between(low: Fraction, high: Fraction) -> arb:
    """Return the ball that has low and high at its ends."""
    return exact((low + high) / 2) + exact((high - low) / 2) * arb(0, 1)
