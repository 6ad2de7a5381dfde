"""Taylor polynomials of y' = f(y, z), 0 = g(y, z) in fixed-point integers: what the prover proposes, unproven."""

from collections.abc import Sequence
from fractions import Fraction
from operator import mul
from typing import Any

from flint import arb, arb_mat, fmpq  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import precision

LAST = 6  # coefficients that state the radius of convergence: series may have gaps
NEWTON = 8  # iterations for z at the start of a step; from the last polynomial it takes one or two


class NoConvergence(ArithmeticError):
    """Newton's method does not find z."""


class Series:
    """The lines of a tape as power series, coefficient by coefficient, integers over 2^bits."""

    def __init__(self, system: dict[str, Any], bits: int, degree: int) -> None:
        self.lines, self.f, self.g = system["lines"], system["f"], system["g"]
        self.n, self.m, self.bits, self.degree = len(self.f), system["z"], bits, degree
        needs_z: set[int] = set()
        for place, (operation, a, b) in enumerate(self.lines):
            if operation == "z" or (_operands(operation, a, b) & needs_z):
                needs_z.add(place)
        self.fixed = [k for k in range(len(self.lines)) if k not in needs_z]
        self.moving = sorted(needs_z)
        self.partner = {(op, a): k for k, (op, a, _) in enumerate(self.lines) if op in ("sin", "cos")}
        self.terms: list[list[int]] = []

    def propose(self, y: Sequence[int], z: Sequence[int], exponent: int) -> list[list[int]]:
        """Return the coefficients of y and z in units of time 2^exponent, from y at the start and z near it."""
        with precision(self.bits + 64):
            return self._propose(y, z, exponent)

    def _propose(self, y: Sequence[int], z: Sequence[int], exponent: int) -> list[list[int]]:
        self.terms = [[] for _ in self.lines]
        self.y, self.z = [[value] for value in y], [[value] for value in z]
        self._constants()
        self._run(self.fixed, 0)
        inverse = self._solve_start()
        for k in range(self.degree):
            if k:
                self._run(self.fixed, k)
                self._append_z(k, inverse)
            for own, place in zip(self.y, self.f, strict=True):
                rate = self._term(place, k)
                own.append((rate << exponent if exponent >= 0 else rate >> -exponent) // (k + 1))
        self._run(self.fixed, self.degree)
        self._append_z(self.degree, inverse)
        return self.y + self.z

    def _constants(self) -> None:
        for place, (operation, a, b) in enumerate(self.lines):
            if operation in ("c", "root"):
                value = arb(fmpq(a, b))
                self.terms[place] = [self._integer(value.sqrt() if operation == "root" else value)]

    def _integer(self, value: Any) -> int:
        return int((value * arb((1, self.bits))).mid().floor().unique_fmpz())

    def _solve_start(self) -> list[list[int]]:
        """Find z at the start by Newton's method; return the inverse of g_z."""
        inverse: list[list[int]] = []
        for attempt in range(NEWTON if self.m else 1):
            self._run(self.moving, 0)
            missing = [self.terms[place][0] for place in self.g]
            if attempt and max(map(abs, missing)) < 1 << (self.bits // 8 + 24):
                break
            inverse = self._inverse()
            for own, change in zip(self.z, self._times(inverse, missing), strict=True):
                own[0] -= change
        else:
            if self.m:
                raise NoConvergence("z has no solution near the last polynomial")
        self._run(self.moving, 0)
        return inverse

    def _inverse(self) -> list[list[int]]:
        """Return the inverse of g_z: coefficient 1 of g is g_z times coefficient 1 of z where y is constant."""
        for place in self.fixed:
            self.terms[place].append(0)
        for one in self.y:
            one.append(0)
        columns = []
        for j in range(self.m):
            for k, one in enumerate(self.z):
                one[1:] = [int(k == j) << self.bits]
            self._run(self.moving, 1)
            columns.append([self.terms[place][1] for place in self.g])
        for series in (*self.terms, *self.y, *self.z):
            del series[1:]
        matrix = arb_mat([[arb((columns[j][i], -self.bits)) for j in range(self.m)] for i in range(self.m)])
        return [[self._integer(x) for x in row] for row in matrix.inv().tolist()]

    def _times(self, matrix: list[list[int]], vector: list[int]) -> list[int]:
        return [sum(map(mul, row, vector)) >> self.bits for row in matrix]

    def _append_z(self, k: int, inverse: list[list[int]]) -> None:
        """Append coefficient k of z, which g has linearly."""
        for own in self.z:
            own.append(0)
        self._run(self.moving, k)
        if self.m:
            missing = [self.terms[place][k] for place in self.g]
            for own, change in zip(self.z, self._times(inverse, missing), strict=True):
                own[k] = -change
            self._run(self.moving, k)

    def _run(self, places: list[int], k: int) -> None:
        """Compute coefficient k of lines whose lower coefficients are known."""
        terms, bits = self.terms, self.bits
        for place in places:
            operation, a, b = self.lines[place]
            if operation == "*":
                if self.lines[a][0] in ("c", "root"):
                    value = terms[a][0] * terms[b][k] >> bits
                else:
                    value = sum(map(mul, terms[a][: k + 1], reversed(terms[b][: k + 1]))) >> bits
            elif operation in "+-":
                first, second = (self._term(x, k) for x in (a, b))
                value = first + second if operation == "+" else first - second
            elif operation in "yz":
                value = (self.y if operation == "y" else self.z)[a][k]
            elif operation in ("c", "root"):
                continue
            else:
                value = self._wave(operation, a, k)
            terms[place][k:] = [value]

    def _term(self, place: int, k: int) -> int:
        series = self.terms[place]
        return series[k] if k < len(series) else 0

    def _wave(self, operation: str, a: int, k: int) -> int:
        """Return a coefficient of a sine or cosine: s' = c u', c' = -s u'."""
        if k == 0:
            angle = arb((self.terms[a][0], -self.bits))
            return self._integer(angle.sin() if operation == "sin" else angle.cos())
        other = self.terms[self.partner["cos" if operation == "sin" else "sin", a]]
        slope = [j * self.terms[a][j] for j in range(1, k + 1)]
        total = sum(map(mul, slope, reversed(other[:k]))) // k >> self.bits
        return total if operation == "sin" else -total


def _operands(operation: str, a: int, b: int) -> set[int]:
    return {a, b} if operation in "+-*" else {a} if operation in ("sin", "cos") else set()


def radius(rows: list[list[int]], bits: int) -> float:
    """Return the radius of convergence in units of the polynomial's time, from the last coefficients."""
    degree = len(rows[0]) - 1
    rates = []
    for k in range(degree - LAST + 1, degree + 1):
        most = max(abs(row[k]) for row in rows)
        if most > 1:
            rates.append(2.0 ** ((most.bit_length() - bits) / k))
    return 1.0 / max(rates, default=2.0**-4)


def rescaled(rows: list[list[int]], ratio: Fraction) -> list[list[int]]:
    """Return the coefficients in another unit of time, `ratio` of the first."""
    factors = [ratio**k for k in range(len(rows[0]))]
    return [[c * f.numerator // f.denominator for c, f in zip(row, factors, strict=True)] for row in rows]
