"""The formulas of a log, run on any kind of number, with their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import add, mul, sub
from typing import Any

from flint import arb, arb_mat  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, above, exact

BINARY = {"*": mul, "+": add, "-": sub}
ITERATIONS = 60  # of Newton's method for z, from 1
NEGLIGIBLE = 2.0**-800  # of a change of z, where it ends
WIDE = 2.0**40  # of z after an impact
ONE = arb(1)


@dataclass(slots=True)
class Dual:
    """A number with its derivatives by y and z, by column."""

    value: Number
    slopes: dict[int, Number]

    def __add__(self, other: Dual) -> Dual:
        slopes = dict(self.slopes)
        for k, d in other.slopes.items():
            slopes[k] = slopes[k] + d if k in slopes else d
        return Dual(self.value + other.value, slopes)

    def __sub__(self, other: Dual) -> Dual:
        return self + Dual(-other.value, {k: -d for k, d in other.slopes.items()})

    def __mul__(self, other: Dual) -> Dual:
        first, second = other._scaled(self.value), self._scaled(other.value)
        return Dual(self.value * other.value, (first + second).slopes)

    def _scaled(self, factor: Number) -> Dual:
        return Dual(0, {k: factor if d is ONE else factor * d for k, d in self.slopes.items()})

    def sin(self) -> Dual:
        return Dual(self.value.sin(), self._scaled(self.value.cos()).slopes)

    def cos(self) -> Dual:
        return Dual(self.value.cos(), self._scaled(-self.value.sin()).slopes)


class Formulas:
    """The log's lines: y' = f(y, z), 0 = g(y, z) and the outputs. An operand is an earlier line."""

    def __init__(self, system: dict[str, Any]) -> None:
        self.lines = [tuple(line) for line in system["lines"]]
        self.f, self.g, self.outputs = system["f"], system["g"], system["outputs"]
        self.n, self.m = len(self.f), system["z"]
        limits = {"c": None, "root": None, "y": self.n, "z": self.m}
        for k, (operation, a, b) in enumerate(self.lines):
            limit = limits.get(operation, k)
            used = (a, b) if operation in BINARY else (a,)
            if operation not in (*limits, *BINARY, "sin", "cos") or not all(
                limit is None or 0 <= p < limit for p in used
            ):
                raise Refused(f"line {k} of the formulas is none")
        places = [*self.f, *self.g, *(place for own in self.outputs for place in own)]
        if len(self.g) != self.m or not all(0 <= place < len(self.lines) for place in places):
            raise Refused("the formulas do not state one equation for every z")

        self._plans: dict[tuple[int, ...], list[int]] = {}

    def run(self, roots: Sequence[int], y: Sequence[Number], z: Sequence[Number], slopes: bool = False) -> list[Any]:
        """Return the values of some lines, with their derivatives if requested."""
        value: dict[int, Any] = {}
        for place in self._plan(tuple(roots)):
            operation, a, b = self.lines[place]
            if operation in BINARY:
                value[place] = BINARY[operation](value[a], value[b])
                continue
            if operation in ("sin", "cos"):
                value[place] = getattr(value[a], operation)()
                continue
            if operation in ("y", "z"):
                own, column = (y if operation == "y" else z)[a], {a + self.n * (operation == "z"): ONE}
            else:
                own, column = exact(Fraction(a, b)), {}
                own = own.sqrt() if operation == "root" else own
            value[place] = Dual(own, column) if slopes else own
        return [value[place] for place in roots]

    def _plan(self, roots: tuple[int, ...]) -> list[int]:
        """Return the lines that some lines need, in order."""
        if roots not in self._plans:
            needed, stack = set(), list(roots)
            while stack:
                place = stack.pop()
                if place not in needed:
                    needed.add(place)
                    operation, *operands = self.lines[place]
                    stack += operands if operation in BINARY else operands[:1] if operation in ("sin", "cos") else []
            self._plans[roots] = sorted(needed)
        return self._plans[roots]

    def newton(self, y: Sequence[Number], z: Sequence[Number], wide: Sequence[Number]) -> list[arb]:
        """Return the change of z by Newton's method, with the slopes of g on balls that may be wider than z."""
        right, rows = self.run(self.g, y, z), self.run(self.g, y, wide, True)
        slopes = arb_mat([[row.slopes.get(self.n + k, arb(0)) for k in range(self.m)] for row in rows])
        return solve(slopes, arb_mat(self.m, 1, [-x for x in right])).entries()

    def enclose(self, y: list[arb]) -> list[arb]:
        """Return balls of the one z below WIDE with g(y, z) = 0, for every y in balls (interval Newton)."""
        z = self.newton(y, [arb(0)] * self.m, [arb(0, WIDE)] * self.m) if self.m else []
        if not all(above(x) < WIDE for x in z):
            raise Refused("after an impact, the accelerations are not enclosed")
        return z

    def root(self, y: list[arb]) -> list[arb]:
        """Return z with g(y, z) = 0 by Newton's method from 1."""
        z = [arb(1)] * self.m
        for _ in range(ITERATIONS if self.m else 0):
            change = self.newton(y, z, z)
            z = [(x + d).mid() for x, d in zip(z, change, strict=True)]
            if max(map(above, change)) < NEGLIGIBLE:
                break
        return z


def solve(matrix: arb_mat, right: arb_mat) -> arb_mat:
    """Return the solution of a linear system; Refused where it may be singular."""
    try:
        return matrix.solve(right)
    except ZeroDivisionError as error:
        raise Refused("a matrix is singular") from error
