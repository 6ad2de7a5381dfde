"""Taylor polynomials of y' = f(y, z), 0 = g(y, z) in fixed-point integers: what the prover proposes, unproven."""

from collections.abc import Sequence
from fractions import Fraction
from operator import mul
from typing import Any

from flint import arb, arb_mat, fmpq  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import precision
from cross_checks.truths.proofs.checker.bounds import ORDER

LAST = 6  # coefficients that state the radius of convergence: series may have gaps
NEWTON = 8  # iterations for z at the start of a step; from the last polynomial it takes one or two


class NoConvergence(ArithmeticError):
    """Newton's method does not find z."""


class Series:
    """The lines of a tape as power series, coefficient by coefficient, integers over 2^bits."""

    def __init__(self, system: dict[str, Any], bits: int, degree: int) -> None:
        self.bits, self.degree, lines = bits, degree, system["lines"]
        self.y, self.z = [[] for _ in system["f"]], [[] for _ in system["g"]]
        self.terms: list[list[int]] = [[] for _ in lines]  # the line of a coordinate is that coordinate's own series
        partner = {(operation, a): k for k, (operation, a, _) in enumerate(lines) if operation in ("sin", "cos")}
        self.fixed, self.moving = [], []  # lines without and with z: operation, place, operands
        with_z: set[int] = set()
        for place, (operation, a, b) in enumerate(lines):
            if operation in ("y", "z"):
                self.terms[place] = (self.y if operation == "y" else self.z)[a]
            elif operation in ("c", "root"):
                with precision(bits + 64):
                    value = arb(fmpq(a, b)) if operation == "c" else arb(fmpq(a, b)).sqrt()
                    self.terms[place] = [self._integer(value), *[0] * degree]
                continue
            elif operation in ("sin", "cos"):
                b = partner["cos" if operation == "sin" else "sin", a]
            elif operation == "*" and {lines[a][0], lines[b][0]} & {"c", "root"}:
                operation, a, b = "scale", *((a, b) if lines[a][0] in ("c", "root") else (b, a))
            if operation == "z" or (operation != "y" and with_z & {a, b}):
                with_z.add(place)
            if operation not in ("y", "z"):
                (self.moving if place in with_z else self.fixed).append((operation, place, a, b))
        self.z_places = [(lines[k][1], k) for k in with_z if lines[k][0] == "z"]
        self.f, self.g = ([self.terms[place] for place in system[name]] for name in "fg")
        self.g_places = system["g"]

    def propose(self, y: Sequence[int], z: Sequence[int], exponent: int) -> list[list[int]]:
        """Return the coefficients of y and z in units of time 2^exponent, from y at the start and z near it."""
        for _, place, *_ in (*self.fixed, *self.moving):
            self.terms[place].clear()
        for own, value in zip((*self.y, *self.z), (*y, *z), strict=True):
            own[:] = [value]
        with precision(self.bits + 64):
            self._run(self.fixed, 0)
            inverse = self._solve_start()
        for k in range(self.degree + 1):
            if k:
                self._run(self.fixed, k)
                for own in self.z:
                    own.append(0)
                self._run(self.moving, k)
                self._move([-x for x in self._times(inverse, [g[k] for g in self.g])], True)
            if k < self.degree:
                for own, rates in zip(self.y, self.f, strict=True):
                    rate = rates[k]
                    own.append((rate << exponent if exponent >= 0 else rate >> -exponent) // (k + 1))
        return [list(own) for own in (*self.y, *self.z)]

    def radius(self) -> float:
        """Return the radius of convergence in units of the polynomials' time.

        It is the least by the last coefficients of y and z, and by those of all lines at ORDER, where the checker ends
        the derivatives of the lines.
        """
        rates = [2.0**-4]
        for series, end in ((self.terms, ORDER), ((*self.y, *self.z), self.degree + 1)):
            for own in series:
                unit = max(self.bits, own[0].bit_length())
                sizes = ((k, own[k].bit_length()) for k in range(end - LAST, end))
                rates += [2.0 ** ((size - unit) / k) for k, size in sizes if size > 1]
        return 1.0 / max(rates)

    def _integer(self, value: Any) -> int:
        return int((value * arb((1, self.bits))).mid().floor().unique_fmpz())

    def _solve_start(self) -> list[list[int]]:
        """Find z at the start by Newton's method; return the inverse of g_z."""
        inverse: list[list[int]] = []
        for attempt in range(NEWTON):
            for _, place, *_ in self.moving:
                self.terms[place].clear()
            self._run(self.moving, 0)
            missing = [g[0] for g in self.g]
            if not missing or (attempt and max(map(abs, missing)) < 1 << (self.bits // 8 + 24)):
                return inverse
            columns = [self._move([int(j == k) << self.bits for j in range(len(self.z))]) for k in range(len(self.z))]
            matrix = arb_mat([[arb((column[i], -self.bits)) for column in columns] for i in range(len(columns))])
            inverse = [[self._integer(x) for x in row] for row in matrix.inv().tolist()]
            for own, change in zip(self.z, self._times(inverse, missing), strict=True):
                own[0] -= change
        raise NoConvergence("z has no solution near the last polynomial")

    def _times(self, matrix: list[list[int]], vector: list[int]) -> list[int]:
        return [sum(map(mul, row, vector)) >> self.bits for row in matrix]

    def _move(self, change: list[int], applied: bool = False) -> list[int]:
        """Return how g's last coefficients change with those of z, to first order; apply the change if requested."""
        terms, bits, moved = self.terms, self.bits, dict.fromkeys(range(len(self.terms)), 0)
        for column, place in self.z_places:
            moved[place] = change[column]
        for operation, place, a, b in self.moving:
            if operation == "*":
                moved[place] = terms[a][0] * moved[b] + moved[a] * terms[b][0] >> bits
            elif operation == "+":
                moved[place] = moved[a] + moved[b]
            elif operation == "-":
                moved[place] = moved[a] - moved[b]
            else:
                factor = terms[a if operation == "scale" else b][0] * (-1 if operation == "cos" else 1)
                moved[place] = factor * moved[b if operation == "scale" else a] >> bits
            if applied:
                terms[place][-1] += moved[place]
        for column, place in self.z_places if applied else ():
            terms[place][-1] += change[column]
        return [moved[place] for place in self.g_places]

    def _run(self, lines: list[tuple[str, int, int, int]], k: int) -> None:
        """Append coefficient k of lines, from all lower coefficients and those of the lines before."""
        terms, bits = self.terms, self.bits
        for operation, place, a, b in lines:
            first, second = terms[a], terms[b]
            if operation == "*":
                value = sum(map(mul, first, reversed(second))) >> bits
            elif operation == "+":
                value = first[k] + second[k]
            elif operation == "-":
                value = first[k] - second[k]
            elif operation == "scale":
                value = first[0] * second[k] >> bits
            elif k:  # s' = c u', c' = -s u'
                value = sum(map(mul, map(mul, range(1, k + 1), first[1:]), reversed(second[:k]))) // k >> bits
                value = value if operation == "sin" else -value
            else:
                angle = arb((first[0], -bits))
                value = self._integer(angle.sin() if operation == "sin" else angle.cos())
            terms[place].append(value)


def rescaled(rows: list[list[int]], ratio: Fraction) -> list[list[int]]:
    """Return the coefficients in another unit of time, `ratio` of the first."""
    factors = [ratio**k for k in range(len(rows[0]))]
    return [[c * f.numerator // f.denominator for c, f in zip(row, factors, strict=True)] for row in rows]
