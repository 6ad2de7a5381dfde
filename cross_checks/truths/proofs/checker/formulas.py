"""The formulas of a log with their derivatives, run on any kind of number."""

from collections.abc import Sequence
from fractions import Fraction
from operator import add, mul, sub
from typing import Any

from flint import arb, arb_mat  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, above, exact

BINARY = {"*": mul, "+": add, "-": sub}
OPERATIONS = ("c", "root", "y", "z", "+", "-", "*", "sin", "cos")
ITERATIONS = 60  # of Newton's method for z, from 1
NEGLIGIBLE = 2.0**-800  # of a change of z, where it ends


class Formulas:
    """The log's lines with their derivatives by y and z."""

    def __init__(self, system: dict[str, Any]) -> None:
        self.lines = [tuple(line) for line in system["lines"]]
        self.places = {line: k for k, line in enumerate(self.lines)}
        self.f, self.g, self.outputs = system["f"], system["g"], system["outputs"]
        self.n, self.m = len(self.f), system["z"]
        ends = {"y": self.n, "z": self.m}
        for k, (operation, a, b) in enumerate(self.lines):
            if operation not in OPERATIONS or not all(0 <= p < k for p in _operands((operation, a, b))):
                raise Refused(f"line {k} of the formulas is none")
            if operation in ends and not 0 <= a < ends[operation]:
                raise Refused(f"line {k} of the formulas has an unknown coordinate")
        places = [*self.f, *self.g, *(place for own in self.outputs for place in own)]
        if len(self.g) != self.m or not all(0 <= place < len(self.lines) for place in places):
            raise Refused("the formulas do not state one equation for every z")
        self.slopes: dict[int, dict[int, int]] = {}
        self.jacobian = [self._slopes(place) for place in (*self.f, *self.g)]

    def _line(self, operation: str, a: int, b: int = 0) -> int:
        key = (operation, a, b)
        if key not in self.places:
            self.places[key] = len(self.lines)
            self.lines.append(key)
        return self.places[key]

    def _times(self, a: int, b: int) -> int:
        one = ("c", 1, 1)
        return b if self.lines[a] == one else a if self.lines[b] == one else self._line("*", a, b)

    def _slopes(self, root: int) -> dict[int, int]:
        """Return the lines of a line's derivatives, by column: y first, then z."""
        for place in range(max(self.slopes, default=-1) + 1, root + 1):
            self.slopes[place] = self._slope(place)
        return self.slopes[root]

    def _slope(self, place: int) -> dict[int, int]:
        operation, a, b = self.lines[place]
        if operation in ("c", "root"):
            return {}
        if operation in "yz":
            return {a + (self.n if operation == "z" else 0): self._line("c", 1, 1)}
        if operation in ("sin", "cos"):
            wave = self._line("cos" if operation == "sin" else "sin", a)
            factor = wave if operation == "sin" else self._times(self._line("c", -1, 1), wave)
            return {k: self._times(factor, d) for k, d in self.slopes[a].items()}
        first, second = dict(self.slopes[a]), self.slopes[b]
        if operation == "*":
            first = {k: self._times(b, d) for k, d in first.items()}
            second = {k: self._times(a, d) for k, d in second.items()}
        sign = self._line("c", -1, 1)
        for k, d in second.items():
            d = self._times(sign, d) if operation == "-" else d
            first[k] = self._line("+", first[k], d) if k in first else d
        return first

    def plan(self, roots: Sequence[int]) -> list[int]:
        """Return the lines that some lines need, in order."""
        needed, stack = set(), list(roots)
        while stack:
            place = stack.pop()
            if place not in needed:
                needed.add(place)
                stack += _operands(self.lines[place])
        return sorted(needed)

    def slopes_of(self, value: dict[int, Number]) -> arb_mat:
        """Return g_z from the values of its lines."""
        columns = range(self.n, self.n + self.m)
        return arb_mat([[value[row[k]] if k in row else arb(0) for k in columns] for row in self.jacobian[self.n :]])

    def run(self, plan: Sequence[int], y: Sequence[Number], z: Sequence[Number]) -> dict[int, Number]:
        """Return the values of the lines of a plan."""
        value: dict[int, Number] = {}
        for place in plan:
            operation, a, b = self.lines[place]
            if operation in BINARY:
                value[place] = BINARY[operation](value[a], value[b])
            elif operation in "yz":
                value[place] = (y if operation == "y" else z)[a]
            elif operation in ("c", "root"):
                number = exact(Fraction(a, b))
                value[place] = number if operation == "c" else number.sqrt()
            else:
                value[place] = value[a].sin() if operation == "sin" else value[a].cos()
        return value


def _operands(line: tuple[str, int, int]) -> tuple[int, ...]:
    operation, a, b = line
    return (a, b) if operation in "+-*" else (a,) if operation in ("sin", "cos") else ()


def solve(matrix: arb_mat, right: arb_mat) -> arb_mat:
    """Return the solution of a linear system; Refused where it may be singular."""
    try:
        return matrix.solve(right)
    except ZeroDivisionError as error:
        raise Refused("a matrix is singular") from error


def enclose(formulas: Formulas, y: list[arb]) -> list[arb]:
    """Return balls of z with g(y, z) = 0 for every y in balls. Refused unless g is linear in z."""
    n, m, zero = formulas.n, formulas.m, [arb(0)] * formulas.m
    plan = formulas.plan([p for row in formulas.jacobian[n:] for k, p in row.items() if k >= n])
    if any(formulas.lines[place][0] == "z" for place in plan):
        raise Refused("after an impact, the formulas are not linear in z")
    value = formulas.run([*plan, *formulas.plan(formulas.g)], y, zero)
    return solve(formulas.slopes_of(value), arb_mat(m, 1, [-value[place] for place in formulas.g])).entries()


def roots(formulas: Formulas, y: list[arb]) -> list[arb]:
    """Return z with g(y, z) = 0 by Newton's method from 1."""
    n, m = formulas.n, formulas.m
    z = [arb(1)] * m
    plan = formulas.plan([*formulas.g, *(p for row in formulas.jacobian[n:] for k, p in row.items() if k >= n)])
    for _ in range(ITERATIONS if m else 0):
        value = formulas.run(plan, y, z)
        change = solve(formulas.slopes_of(value), arb_mat(m, 1, [value[place] for place in formulas.g])).entries()
        z = [(x - d).mid() for x, d in zip(z, change, strict=True)]
        if max(above(d) for d in change) < NEGLIGIBLE:
            break
    return z
