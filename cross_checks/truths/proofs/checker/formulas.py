"""The formulas of a log, run on any kind of number, with their derivatives."""

from collections.abc import Sequence
from fractions import Fraction
from operator import add, mul, sub
from typing import Any

from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, exact

BINARY = {"*": mul, "+": add, "-": sub}
ONE = arb(1)


class Formulas:
    """The log's lines: y' = f(y, z), 0 = g(y, z) and the outputs. An operand is an earlier line."""

    def __init__(self, system: dict[str, Any]) -> None:
        self.lines = [tuple(line) for line in system["lines"]]
        self.f, self.g, self.outputs = system["f"], system["g"], system["outputs"]
        self.n, self.m = len(self.f), system["z"]
        limits = {"y": self.n, "z": self.m}
        if len(self.g) != self.m or not all(0 <= a < limits[how] for how, a, _ in self.lines if how in limits):
            raise Refused("the formulas do not state one equation for every z")
        self._plans: dict[tuple[int, ...], list[int]] = {}

    def run(self, roots: Sequence[int], x: Sequence[Number]) -> list[Number]:
        """Return the values of some lines; x has y and, where lines need it, z."""
        value = self._values(roots, x)
        return [value[place] for place in roots]

    def _values(self, roots: Sequence[int], x: Sequence[Number]) -> dict[int, Number]:
        value: dict[int, Number] = {}
        for place in self._plan(tuple(roots)):
            operation, a, b = self.lines[place]
            if operation in BINARY:
                value[place] = BINARY[operation](value[a], value[b])
            elif operation in ("sin", "cos"):
                value[place] = getattr(value[a], operation)()
            elif operation in ("y", "z"):
                value[place] = x[a + self.n * (operation == "z")]
            else:
                value[place] = {"c": arb, "root": arb.sqrt}[operation](exact(Fraction(a, b)))
        return value

    def slopes(self, roots: Sequence[int], x: Sequence[Number]) -> list[dict[int, Number]]:
        """Return the derivatives of some lines by x, by column."""
        value, slopes = self._values(roots, x), {}
        for place in value:
            operation, a, b = self.lines[place]
            parts: list[tuple[int, Number]] = []
            if operation in ("+", "-"):
                parts = [(a, ONE), (b, ONE if operation == "+" else -ONE)]
            elif operation == "*":
                parts = [(a, value[b]), (b, value[a])]
            elif operation in ("sin", "cos"):
                parts = [(a, value[a].cos() if operation == "sin" else -value[a].sin())]
            own = slopes[place] = {a + self.n * (operation == "z"): ONE} if operation in ("y", "z") else {}
            for operand, factor in parts:
                for k, d in slopes[operand].items():
                    term = factor if d is ONE else d if factor is ONE else factor * d
                    own[k] = own[k] + term if k in own else term
        return [slopes[place] for place in roots]

    def _plan(self, roots: tuple[int, ...]) -> list[int]:
        """Return the lines that some lines need, in order."""
        if roots not in self._plans:
            needed = set(roots)
            for place in range(max(roots, default=-1), -1, -1):
                operation, *operands = self.lines[place]
                if place in needed:
                    needed |= {*operands} if operation in BINARY else {*operands[: operation in ("sin", "cos")]}
            self._plans[roots] = sorted(needed)
        return self._plans[roots]
