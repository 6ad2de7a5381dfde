"""The proof of a log, step by step."""

from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker import bounds
from cross_checks.truths.proofs.checker.bounds import ORDER, inverse_bound, size_of
from cross_checks.truths.proofs.checker.formulas import GAMMA, Refused, beside, differences, exact, precision, up
from cross_checks.truths.proofs.checker.impacts import Impacts
from cross_checks.truths.proofs.checker.model import Model

CONDITION = 1e6  # of the basis, above which it becomes orthogonal
ITERATIONS = 12  # for a box that maps into itself


class Proof:
    """What the checker knows of one log: the model, and the enclosure at the end of the last step."""

    def __init__(self, header: dict[str, Any], compares: bool = True) -> None:
        self.model, self.bits, self.t = Model(header, compares), int(header["bits"]), Fraction(0)
        self.formulas, self.n = self.model.formulas, self.model.formulas.n
        self.times = [self.model.mechanics.exact(t) / self.model.units[1] for t in header["times"]]
        if sorted(set(self.times)) != self.times or self.times[:1] < [Fraction(0)]:
            raise Refused("the times do not increase from 0")
        self.enclosures: list[list[list[arb]]] = []  # at the times reached: place, turn, velocity and spin of bodies
        self.impacts = Impacts(self.model)
        self.moved, self.moved_error, self.box = self.model.moved, np.zeros((self.n, self.n)), self.model.box
        self._begin(self.model.start, self.model.z_start)

    def _begin(self, y: list[arb], z: list[arb]) -> None:
        """Begin with balls of y and z."""
        with precision(self.bits + 32):
            self.middle, self.z = ([x.mid() * 1 for x in values] for values in (y, z))
            self.loose, self.z_box = differences(y, self.middle), differences(z, self.z)

    def step(self, h: Fraction, rows: list[list[int]], window: Fraction = Fraction(0)) -> None:
        """Prove that the motion stays beside a polynomial for a time h; Refused where the bounds do not close.

        In the last part of the step, the window, an impact happens unless it is 0.
        """
        lengths = {len(row) for row in rows if len(rows) == self.n + self.formulas.m}
        fits = h > 0 and len(lengths) == 1 and min(lengths) > ORDER
        if not (fits and 0 <= window < 1 and (self.model.contacts or not window)):
            raise Refused("a step has no length, or no polynomial for every coordinate")
        try:
            with np.errstate(all="ignore"), precision(self.bits + 32):  # what is not finite is refused
                self._step(h, [[arb((int(c), -self.bits)) for c in row] for row in rows], window)
        except (ZeroDivisionError, np.linalg.LinAlgError, FloatingPointError) as error:
            raise Refused(f"a bound is infinite: {error}") from error

    def _step(self, h: Fraction, p: list[list[arb]], window: Fraction) -> None:
        n, own = self.n, bounds.Step(self.formulas, h, p)
        basis, x0 = self._new_basis([row[0] for row in p[:n]])
        w = up(self.z_box + differences([row[0] for row in p[n:]], self.z))
        defect, disc = own.defects()
        self.jacobian, error = own.jacobian(disc)
        flow = bounds.variations(self.jacobian, np.eye(n), np.zeros((ORDER, len(p), n)))
        flow_size, r = size_of(flow), bounds.defects_of(self.jacobian, error, flow, n)
        inverse = inverse_bound(self.jacobian[:, n:, n:], error[n:, n:])
        back = up(inverse_bound(basis[None]) @ inverse_bound(flow[:, :n]))
        f_z = up(size_of(self.jacobian[:, :n, n:]) + error[:n, n:])
        box = up(x0 * 1.01)
        for _ in range(ITERATIONS):
            turned = up(np.abs(basis) @ box)
            e = up(flow_size @ turned)
            e[n:] = up(e[n:] + w)
            source = up(up(r @ turned) + defect + own.second_order(e))
            new_w = up(inverse @ source[n:])
            new_box = up(x0 + up(back @ up(source[:n] + up(f_z @ new_w))))
            if (new_box <= box).all() and (new_w <= w).all() and np.isfinite(new_box).all():
                break
            box, w = np.maximum(box, new_box * 1.1), np.maximum(w, new_w * 1.1)
        else:
            raise Refused("the box does not map into itself")
        self.impacts.watch(p[:n], e[:n], window)
        for s in ((t - self.t) / h for t in self.times[len(self.enclosures) :] if t <= self.t + h):
            if s > 1 - window:
                raise Refused("an output time is that of an impact")
            here, error = _moved(s, flow[:, :n], basis)
            self.enclosures.append(self.model.bodies(beside(p[:n], up(up(np.abs(here) + error) @ new_box), exact(s))))
        self.moved, self.moved_error = _moved(1 - window, flow[:, :n], basis)
        self.middle, self.z = ([sum(row, arb(0)) for row in rows] for rows in (p[:n], p[n:]))
        self.box, self.z_box, self.loose = new_box, new_w, np.zeros(n)
        if window:
            image, z, matrix, rest = self.impacts.after(p[:n], e[:n], self.t, h, window)
            self._begin(image, z)
            self.moved, self.moved_error = bounds.times(matrix, rest, self.moved, self.moved_error)
        self.t += h

    def _new_basis(self, start: list[arb]) -> tuple[np.ndarray, np.ndarray]:
        """Return a basis of floats near the moved one, and the box of the state in it about the polynomial's start."""
        shift = up(differences(start, self.middle) + self.loose)
        basis = self.moved / np.linalg.norm(self.moved, axis=0)
        if not np.linalg.cond(basis) < CONDITION:
            order = np.argsort(-np.linalg.norm(self.moved, axis=0) * self.box)
            basis = np.linalg.qr(self.moved[:, order])[0]
        (inverse,), rest = bounds.inverse_of(basis[None])
        turned, error = bounds.times(inverse, 0.0 * inverse, self.moved, self.moved_error)
        box = up(up(up(np.abs(turned) + error) @ self.box) + up(np.abs(inverse) @ shift))
        return basis, up(box + rest * box.max())

    @property
    def radius(self) -> float:
        """The largest radius of a place (m), turn (rad), velocity or spin at the output times so far."""
        return max((float(up(float(x.rad()))) for one in self.enclosures for own in one for x in own), default=0.0)

    @property
    def reached(self) -> float:
        """The time that the steps reach, s."""
        return float(self.t * self.model.units[1])


def _moved(s: Fraction, flow: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the basis at a time of the step, and a bound of its rounding."""
    here = np.tensordot(float(s) ** np.arange(ORDER), flow, 1) @ basis
    return here, up(GAMMA * up(size_of(flow) @ np.abs(basis)))


def check(log: dict[str, Any]) -> Proof:
    """Return the proof that a log holds. Refused where it is not a proof of what it states."""
    try:
        proof = Proof(log)
        for numerator, denominator, rows, *window in log["steps"]:
            proof.step(Fraction(numerator, denominator), rows, Fraction(*window))
        if not proof.radius <= float(log["radius"]):
            raise Refused(f"the radius is {proof.radius:.2g}, above the stated {log['radius']:.2g}")
    except (LookupError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise Refused(str(error) or type(error).__name__) from error
    if len(proof.enclosures) < len(proof.times):
        raise Refused(f"the steps end at {proof.reached:g} s, before the last output time")
    proof.model.compare_energies(proof.enclosures, proof.bits + 32)
    return proof
