"""The proof of a log, step by step."""

from fractions import Fraction
from functools import reduce
from itertools import zip_longest
from typing import Any

import numpy as np
from flint import acb, arb, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import GAMMA, Refused, above, exact, precision, terms, up
from cross_checks.truths.proofs.checker.bounds import ORDER, defects_of, gap_of, inverse_bound, variations
from cross_checks.truths.proofs.checker.model import Impacts, Model

CONDITION = 1e6  # of the basis, above which it becomes orthogonal
FINEST = 12  # halvings of a step where a gap may close
LONGER = 3  # halves of the polynomial's terms: so many of its defect are computed, and the others bounded
ITERATIONS = 12  # for a box that maps into itself
DISCS = (1.5, 2.0, 3.0, 4.0, 5.0, 6.5)  # radii of discs in steps; the best one counts

Polynomials = list[list[arb]]


class Proof:
    """What the checker knows of one log: the model, and the enclosure at the end of the last step."""

    def __init__(self, header: dict[str, Any]) -> None:
        self.model, self.bits, self.t = Model(header), int(header["bits"]), Fraction(0)
        self.formulas, self.n = self.model.formulas, self.model.formulas.n
        self.times = [self.model.mechanics.number(t) / self.model.units[1] for t in header["times"]]
        if sorted(set(self.times)) != self.times or self.times[:1] < [Fraction(0)]:
            raise Refused("the times do not increase from 0")
        self.enclosures: list[list[list[arb]]] = []  # at the times reached: place, turn, velocity and spin of bodies
        self.contacts = Impacts(self.model.mechanics)
        self.opening: Any = None  # the contact of an impact that the last step ended with
        self.impacts: list[tuple[str, arb]] = []  # contact and time, s
        self._begin(self.model.start, self.model.z_start)

    def _begin(self, y: list[arb], z: list[arb]) -> None:
        """Begin with balls of y and z."""
        with precision(self.bits + 64):
            self.middle, self.z = ([x.mid() * 1 for x in values] for values in (y, z))
            self.box, self.z_box = (
                up([above(x - m) for x, m in zip(*pair, strict=True)]) for pair in ((y, self.middle), (z, self.z))
            )
        self.moved, self.moved_error = np.eye(self.n), np.zeros((self.n, self.n))

    def step(self, h: Fraction, rows: list[list[int]], window: Fraction = Fraction(0)) -> None:
        """Prove that the motion stays beside a polynomial for a time h; Refused where the bounds do not close.

        In the last part of the step, the window, an impact happens unless it is 0.
        """
        lengths = {len(row) for row in rows} if len(rows) == self.n + self.formulas.m else set()
        fits = h > 0 and len(lengths) == 1 and min(lengths) > ORDER
        if not fits or not 0 <= window < 1 or (window and not self.contacts.parts):
            raise Refused("a step has no length, or no polynomial for every coordinate")
        try:
            with np.errstate(all="ignore"), precision(self.bits + 64):  # what is not finite is refused
                self._step(h, [[arb((int(c), -self.bits)) for c in row] for row in rows], window)
        except (ZeroDivisionError, np.linalg.LinAlgError, FloatingPointError) as error:
            raise Refused(f"a bound is infinite: {error}") from error

    def _step(self, h: Fraction, p: Polynomials, window: Fraction) -> None:
        n = self.n
        basis, x0 = self._new_basis([row[0] for row in p[:n]])
        size = np.array([[above(c) for c in row] for row in p])
        w = up(self.z_box + [above(row[0] - z) for row, z in zip(p[n:], self.z, strict=True)])
        defect, disc = self._defects(h, p, size)
        jacobian, error = self._jacobian(float(h), p, size, disc)
        flow = variations(jacobian, n)
        flow_size, r = defects_of(jacobian, error, flow, n)
        inverse = inverse_bound(jacobian[:, n:, n:], error[n:, n:])
        back = up(np.abs(inverse_bound(flow[:, :n], np.zeros((n, n)))))
        back = up(inverse_bound(basis[None], np.zeros((n, n))) @ back)
        f_z = up(np.abs(jacobian[:, :n, n:]).sum(0) + error[:n, n:])
        box = up(x0 * 1.01)
        for _ in range(ITERATIONS):
            turned = up(np.abs(basis) @ box)
            e = up(flow_size @ turned)
            e[n:] = up(e[n:] + w)
            source = up(up(r @ turned) + defect + self._second_order(h, p, size, e))
            new_w = up(inverse @ source[n:])
            new_box = up(x0 + up(back @ up(source[:n] + up(f_z @ new_w))))
            if (new_box <= box).all() and (new_w <= w).all():
                break
            box, w = np.maximum(box, new_box * 1.1), np.maximum(w, new_w * 1.1)
        else:
            raise Refused("the box does not map into itself")
        if not np.isfinite(new_box).all():
            raise Refused("the box is infinite")
        if self.contacts.parts:
            self._watch(p[:n], e[:n], window)
        self._record(h, p, flow[:, :n], basis, new_box, window)
        if window:
            self._pass_impact(h, p, e, window)
            return
        self.moved = flow[:, :n].sum(0) @ basis
        self.moved_error = up(GAMMA * up(flow_size[:n] @ np.abs(basis)))
        ends = [sum(row, arb(0)) for row in p]
        self.middle, self.z = ends[:n], ends[n:]
        self.box, self.z_box, self.t = new_box, new_w, self.t + h

    def _new_basis(self, start: list[arb]) -> tuple[np.ndarray, np.ndarray]:
        """Return a basis of floats near the moved one, and the box of the state in it about the polynomial's start."""
        shift = up([above(x - m) for x, m in zip(start, self.middle, strict=True)])
        basis = self.moved / np.linalg.norm(self.moved, axis=0)
        if not np.linalg.cond(basis) < CONDITION:
            order = np.argsort(-np.linalg.norm(self.moved, axis=0) * self.box)
            basis = np.linalg.qr(self.moved[:, order])[0]
        inverse = np.linalg.inv(basis)
        gap = gap_of(inverse, basis)
        size = up(np.abs(inverse @ self.moved) + GAMMA * up(np.abs(inverse) @ np.abs(self.moved)))
        box = up(up(size @ self.box) + up(np.abs(inverse) @ up(shift + up(self.moved_error @ self.box))))
        return basis, up(box + gap / (1.0 - gap) * box.max())

    def _values(self, p: list[Any], slopes: bool = False) -> list[Any]:
        """Return f and g of y and z, as numbers of their kind."""
        return self.formulas.run([*self.formulas.f, *self.formulas.g], p[: self.n], p[self.n :], slopes)

    def _defects(self, h: Fraction, p: Polynomials, size: np.ndarray) -> tuple[np.ndarray, float]:
        """Return bounds of |p' - h f(p)| and |g(p)| on the step, and the radius of the best disc."""
        count, sums = LONGER * len(p[0]) // 2, []
        with precision(self.bits + 64, count):
            for k, value in enumerate(self._values([arb_series(row, count) for row in p])):
                own = terms(value, count)
                if k < self.n:
                    rates = [c * j for j, c in enumerate(p[k])][1:]
                    own = [a - exact(h) * b for a, b in zip_longest(rates, own, fillvalue=arb(0))]
                sums.append(up(sum(map(above, own))))
        factor, tails = np.where(np.arange(len(p)) < self.n, float(h), 1.0), []
        for radius in DISCS:
            most = np.array([above(value) for value in self._on_disc(p, size, radius)])
            tails.append((up(most * factor * radius ** -float(count) / (1 - 1 / radius)), radius))
        tail, radius = min(tails, key=lambda one: np.nan_to_num(one[0], nan=np.inf).max())
        return up(np.array(sums) + tail), radius

    def _on_disc(self, p: Polynomials, size: np.ndarray, radius: float, slopes: bool = False) -> list[Any]:
        """Return f and g for |t| <= radius steps."""
        reach = up(size[:, 1:] @ (radius ** np.arange(1.0, size.shape[1])))
        with precision(64):
            discs = [acb(arb(row[0].mid(), d) + 0, arb(0, d)) for row, d in zip(p, reach, strict=True)]
            return self._values(discs, slopes)

    def _jacobian(self, h: float, p: Polynomials, size: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the series of the Jacobian, rows of f times h, and bounds of its error on the step."""
        jacobian, error = np.zeros((ORDER, len(p), len(p))), np.zeros((len(p), len(p)))
        bounds, tail = self._on_disc(p, size, radius, True), radius ** -float(ORDER) / (1.0 - 1.0 / radius)
        with precision(64, ORDER):
            for i, row in enumerate(self._values([arb_series(row[:ORDER], ORDER) for row in p], True)):
                for j, slope in row.slopes.items():
                    own = terms(slope, ORDER)
                    jacobian[:, i, j] = [float(c.mid()) for c in own]
                    error[i, j] = sum(float(c.rad()) for c in own) + above(bounds[i].slopes[j]) * tail
        error = up(error + GAMMA * np.abs(jacobian).sum(0))
        jacobian[:, : self.n] *= h
        error[: self.n] *= h
        return jacobian, up(error)

    def _second_order(self, h: Fraction, p: Polynomials, size: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return bounds of the second-order terms of f (times h) and g for deviations |e|."""
        reach = up(size[:, 1:].sum(1) + e)
        with precision(64, 3):
            rows = zip(p, reach, e, strict=True)
            boxes = [arb_series([arb(row[0].mid(), d), arb(0, float(s))], 3) for row, d, s in rows]
            bound = np.array([above(terms(value, 3)[2]) for value in self._values(boxes)])
        bound[: self.n] *= float(h)
        return up(bound)

    def _record(
        self, h: Fraction, p: list[list[arb]], flow: np.ndarray, basis: np.ndarray, box: np.ndarray, window: Fraction
    ) -> None:
        """Append the enclosures of all bodies at the output times of the step."""
        while len(self.enclosures) < len(self.times) and self.times[len(self.enclosures)] <= self.t + h:
            s = (self.times[len(self.enclosures)] - self.t) / h
            if s > 1 - window:
                raise Refused("an output time is that of an impact")
            here = np.tensordot(float(s) ** np.arange(ORDER), flow, 1) @ basis
            spread = up(up(np.abs(here) + GAMMA * up(np.abs(flow).sum(0) @ np.abs(basis))) @ box)
            self.enclosures.append(self.model.bodies(beside(p[: self.n], spread, exact(s))))

    def _watch(self, p: Polynomials, e: np.ndarray, window: Fraction) -> None:
        """Refuse unless no gap closes in the step, but one at its end, in the window, where it is not 0."""
        self._keep_open(p, e, Fraction(0), 1 - window, FINEST)
        if not window:
            self.opening = None
            return
        last = [self.model.bodies(beside(p, e, s)) for s in (exact(1 - window), _ball(1 - window, Fraction(1)), arb(1))]
        closing = [part for part in self.contacts.parts if not self.contacts.gap(part, last[1])[0] > 0]
        gaps = [self.contacts.gap(part, bodies) for part in closing for bodies in last]
        if len(closing) != 1 or not (gaps[0][0] > 0 and gaps[1][1] < 0 and gaps[2][0] < 0):
            raise Refused("an impact may be grazing, or one of several at once")
        self.opening = closing[0]

    def _keep_open(self, p: Polynomials, e: np.ndarray, low: Fraction, high: Fraction, depth: int) -> None:
        bodies, last = (self.model.bodies(beside(p, e, s)) for s in (_ball(low, high), exact(high)))
        for part in self.contacts.parts:
            gap, rate, *_ = self.contacts.gap(part, bodies)
            opens = part is self.opening and not low and rate > 0
            if gap > 0 or opens or (rate < 0 and self.contacts.gap(part, last)[0] > 0):
                continue
            if not depth:
                raise Refused(f"contact {part.name} may close")
            self._keep_open(p, e, low, (low + high) / 2, depth - 1)
            self._keep_open(p, e, (low + high) / 2, high, depth - 1)
            return

    def _pass_impact(self, h: Fraction, p: Polynomials, e: np.ndarray, window: Fraction) -> None:
        """Begin anew at the end of the step: the window's states after the impulse, moved for as long as it lasts."""
        formulas, (length, unit, _) = self.formulas, self.model.units
        y = beside(p[: self.n], e[: self.n], _ball(1 - window, Fraction(1)))
        for k, velocity in self.contacts.after(self.opening, self.model.bodies(y)):
            for place, v in zip(formulas.outputs[k][8:11], velocity, strict=True):
                operation, column, _ = formulas.lines[place]
                if operation == "y":
                    y[column] = v / exact(length / unit)
                elif not v.is_zero():
                    raise Refused("a velocity is no coordinate")
        lasting = _ball(Fraction(0), window * h)
        wide = [x + 2 * lasting * rate for x, rate in zip(y, self._rates(y), strict=True)]
        end = [x + lasting * rate for x, rate in zip(y, self._rates(wide), strict=True)]
        if not all(a.contains(b) for a, b in zip(wide, end, strict=True)):
            raise Refused("the motion after an impact is not enclosed")
        for part in self.contacts.parts:
            gap, rate, *_ = self.contacts.gap(part, self.model.bodies(end))
            if not (rate if part is self.opening else gap) > 0:
                raise Refused("an impact does not open its contact, or closes another")
        self.impacts.append((self.opening.name, _ball(self.t + h * (1 - window), self.t + h) * exact(unit)))
        self._begin(end, formulas.enclose(end))
        self.t += h

    def _rates(self, y: list[arb]) -> list[arb]:
        return self.formulas.run(self.formulas.f, y, self.formulas.enclose(y))

    @property
    def radius(self) -> float:
        """The largest radius of a place (m), turn (rad), velocity or spin at the output times so far."""
        return max((float(up(float(x.rad()))) for one in self.enclosures for own in one for x in own), default=0.0)

    @property
    def reached(self) -> float:
        """The time that the steps reach, s."""
        return float(self.t * self.model.units[1])


def _ball(low: Fraction, high: Fraction) -> arb:
    return exact((low + high) / 2) + exact((high - low) / 2) * arb(0, 1)


def beside(p: Polynomials, e: np.ndarray, s: arb) -> list[arb]:
    """Return balls of radius e about polynomials at a time, or on an interval."""
    values = [reduce(lambda value, c: value * s + c, reversed(row), arb(0)) for row in p]
    return [value + arb(0, float(wide)) for value, wide in zip(values, e, strict=True)]


def check(log: dict[str, Any]) -> Proof:
    """Return the proof that a log holds. Refused where it is not a proof of what it states."""
    try:
        proof = Proof(log)
        for numerator, denominator, rows, *window in log["steps"]:
            proof.step(Fraction(numerator, denominator), rows, Fraction(*window))
        claimed = float(log["radius"])
    except (LookupError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise Refused(str(error) or type(error).__name__) from error
    if len(proof.enclosures) < len(proof.times):
        raise Refused(f"the steps end at {proof.reached:g} s, before the last output time")
    if not proof.radius <= claimed:
        raise Refused(f"the radius is {proof.radius:.2g}, above the stated {claimed:.2g}")
    with precision(proof.bits + 64):
        energies = [proof.model.mechanics.energy(*proof.model.states(bodies)) for bodies in proof.enclosures]
    if proof.model.mechanics.conserves and not all(energy.overlaps(energies[0]) for energy in energies):
        raise Refused("the energy is not constant")
    return proof
