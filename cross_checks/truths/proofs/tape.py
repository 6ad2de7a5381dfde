"""Formulas as a list of elementary operations, each operand an earlier line: what a log can hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.formulas import Formulas

Line = tuple[str, int, int]  # operation and operands: c, root numerator denominator; y, z, sin, cos i; + - * / i j


@dataclass(eq=False)
class Tape:
    """The lines of a formula; equal lines occur once. `rates` has derivatives by time, of coordinates at least."""

    lines: list[Line] = field(default_factory=list)
    places: dict[Line, int] = field(default_factory=dict)
    rates: dict[int, Formula] = field(default_factory=dict)

    def line(self, operation: str, first: int, second: int = 0) -> Formula:
        """Return the formula of a line, appended unless it exists."""
        key = (operation, first, second)
        if key not in self.places:
            self.places[key] = len(self.lines)
            self.lines.append(key)
        return Formula(self, self.places[key])

    def number(self, value: Fraction | int) -> Formula:
        """Return a rational constant."""
        return self.line("c", *Fraction(value).as_integer_ratio())

    def values(self, places: Sequence[int], y: Any) -> np.ndarray:
        """Return the values of lines in floats, where z is 0."""
        count = sum(operation == "z" for operation, *_ in self.lines)
        formulas = Formulas({"lines": self.lines, "f": y, "g": range(count), "outputs": [], "z": count})
        return np.array([float(x) for x in formulas.run(places, [*map(arb, y), *[arb(0)] * count])])


@dataclass(frozen=True)
class Formula:
    """One line of a tape, with the operators of a number."""

    tape: Tape
    place: int

    @property
    def constant(self) -> Fraction | None:
        """Return the value of a rational constant; None of another line."""
        operation, first, second = self.tape.lines[self.place]
        return Fraction(first, second) if operation == "c" else None

    @property
    def rate(self) -> Formula:
        """Return the derivative by time: a known one, or by the rules for sums, products, sines and cosines."""
        tape, (operation, first, second) = self.tape, self.tape.lines[self.place]
        if self.place not in tape.rates:
            a, b = Formula(tape, first), Formula(tape, second)
            rules: dict[str, Callable[[], Formula]] = {
                "+": lambda: a.rate + b.rate, "-": lambda: a.rate - b.rate, "*": lambda: a.rate * b + a * b.rate,
                "sin": lambda: a.sin_cos()[1] * a.rate, "cos": lambda: -(a.sin_cos()[0] * a.rate),
                "c": lambda: tape.number(0), "root": lambda: tape.number(0),
            }  # fmt: skip
            tape.rates[self.place] = rules[operation]()
        return tape.rates[self.place]

    def __add__(self, other: Formula) -> Formula:
        a, b = self.constant, other.constant
        if a is not None and b is not None:
            return self.tape.number(a + b)
        if a == 0 or b == 0:
            return other if a == 0 else self
        return self.tape.line("+", *sorted((self.place, other.place)))

    def __sub__(self, other: Formula) -> Formula:
        a, b = self.constant, other.constant
        if a is not None and b is not None:
            return self.tape.number(a - b)
        return self if b == 0 else self.tape.line("-", self.place, other.place)

    def __mul__(self, other: Formula | Fraction | int) -> Formula:
        other = other if isinstance(other, Formula) else self.tape.number(other)
        a, b = self.constant, other.constant
        if a is not None and b is not None:
            return self.tape.number(a * b)
        if a == 0 or b == 0:
            return self.tape.number(0)
        if a == 1 or b == 1:
            return other if a == 1 else self
        return self.tape.line("*", *((other.place, self.place) if b is not None else (self.place, other.place)))

    def __truediv__(self, other: Formula) -> Formula:
        return self.tape.line("/", self.place, other.place) if other.constant is None else self * (1 / other.constant)

    def __neg__(self) -> Formula:
        return self * -1

    def sin_cos(self) -> tuple[Formula, Formula]:
        """Return sine and cosine; their lines are neighbours."""
        return self.tape.line("sin", self.place), self.tape.line("cos", self.place)


Vector = Any  # an array (3,) of formulas
rate = np.frompyfunc(lambda formula: formula.rate, 1, 1)  # the derivative by time, element by element
