"""Where the prover expects an impact: hints only, which the checker proves."""

from fractions import Fraction

import numpy as np
from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import exact, precision
from cross_checks.truths.proofs.checker.proof import Proof, beside

SAMPLES = 32  # of a step, at which gaps are evaluated
ITERATIONS = 12  # of Newton's method for the time
MARGIN = 8.0  # of the time that the box takes to pass, which the window lasts


def first_touch(proof: Proof, h: Fraction, rows: list[list[int]]) -> tuple[Fraction, Fraction] | None:
    """Return a step's length up to the end of its first impact, and the share of its window; None without one."""
    n, (length, time, _) = proof.model.formulas.n, map(float, proof.model.units)
    with precision(proof.bits + 64):
        p = [[arb((int(c), -proof.bits)) for c in row] for row in rows[:n]]

        def gaps(s: arb) -> list[tuple[arb, arb]]:
            bodies = proof.model.bodies(beside(p, np.zeros(n), s))
            return [proof.contacts.gap(part, bodies)[:2] for part in proof.contacts.parts]

        for k in range(1, SAMPLES + 1):
            closed = [j for j, (gap, _) in enumerate(gaps(exact(Fraction(k, SAMPLES)))) if gap < 0]
            if closed:
                break
        else:
            return None
        roots = []
        for j in closed:
            s = exact(Fraction(2 * k - 1, 2 * SAMPLES))
            for _ in range(ITERATIONS):
                gap, rate = gaps(s)[j]
                s = (s - gap / (rate * exact(h) * time)).mid()
            roots.append((float(s), s, abs(float(rate.mid())) * float(h) * time))
        _, s, rate = min(roots, key=lambda one: one[0])
        spread = length * float(np.max(np.abs(proof.moved) @ proof.box)) + 2.0 ** -(proof.bits - 16)
        mantissa, exponent = s.man_exp()
        end = Fraction(int(mantissa)) * Fraction(2) ** int(exponent) + Fraction(MARGIN * spread / rate)
        return h * end, Fraction(2 * MARGIN * spread / rate) / end
