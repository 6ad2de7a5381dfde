"""Balls, floats that bound them, and the formulas of a log, run on any kind of number, with their derivatives."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from operator import add, mul, sub, truediv
from typing import Any

import numpy as np
from flint import arb, arb_poly, arb_series, ctx, fmpq  # pyright: ignore[reportMissingImports]  # an optional extra

GAMMA = 1e-12  # of |A| |B|: 9000 roundings of 2^-53

ONE = arb(1)
Number = Any  # arb, acb or arb_series
Polynomials = list[list[arb]]


class Refused(ValueError):
    """The log does not prove what it states; the message says why."""


@contextmanager
def precision(bits: int, terms: int = 10) -> Iterator[None]:
    """Set the precision of balls and the length of series, and restore both."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = bits, terms
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def up(x: Any) -> Any:
    """Return a float above a sum of non-negative floats that was rounded."""
    return np.asarray(x) * (1.0 + 1e-9) + 1e-290


def above(x: Any) -> float:
    """Return a float above |x| of a ball."""
    return float(x.abs_upper()) * (1.0 + 1e-9) + 1e-290 if x.is_finite() else np.inf


def differences(x: Sequence[arb], y: Sequence[arb]) -> np.ndarray:
    """Return bounds of |x - y|."""
    return up([above(a - b) for a, b in zip(x, y, strict=True)])


def exact(x: Fraction) -> arb:
    """Return the ball of a rational number at the precision of now."""
    return arb(fmpq(x.numerator, x.denominator))


def terms(value: Number, count: int) -> list[arb]:
    """Return the first coefficients of a series or a constant."""
    own = value.coeffs() if isinstance(value, arb_series) else [value]
    return [*own, *[arb(0)] * (count - len(own))][:count]


def beside(p: Polynomials, e: np.ndarray, s: arb) -> list[arb]:
    """Return balls of radius e about polynomials at a time, or on an interval."""
    return [arb_poly(row)(s) + arb(0, float(wide)) for row, wide in zip(p, e, strict=True)]


RULES: dict[str, tuple[int, Any, Any]] = {  # number of operands, value by them, derivatives by them and the value
    "+": (2, add, lambda a, b, c: (ONE, ONE)),
    "-": (2, sub, lambda a, b, c: (ONE, -ONE)),
    "*": (2, mul, lambda a, b, c: (b, a)),
    "/": (2, truediv, lambda a, b, c: (1 / b, -c / b)),
    "sin": (1, lambda a: a.sin(), lambda a, c: (a.cos(),)),
    "cos": (1, lambda a: a.cos(), lambda a, c: (-a.sin(),)),
}


class Formulas:
    """The log's lines: y' = f(y, z), 0 = g(y, z) and the outputs. An operand is an earlier line."""

    def __init__(self, system: dict[str, Any]) -> None:
        self.lines = [tuple(line) for line in system["lines"]]
        self.operands = [line[1 : 1 + RULES.get(line[0], (0,))[0]] for line in self.lines]
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
            if operation in RULES:
                value[place] = RULES[operation][1](*(value[k] for k in self.operands[place]))
            elif operation in ("y", "z"):
                value[place] = x[a + self.n * (operation == "z")]
            else:
                value[place] = {"c": arb, "root": arb.sqrt}[operation](arb(fmpq(a, b)))
        return value

    def slopes(self, roots: Sequence[int], x: Sequence[Number]) -> list[dict[int, Number]]:
        """Return the derivatives of some lines by x, by column."""
        value, slopes = self._values(roots, x), {}
        for place, own_value in value.items():
            (operation, a, _), operands = self.lines[place], self.operands[place]
            own = slopes[place] = {a + self.n * (operation == "z"): ONE} if operation in ("y", "z") else {}
            factors = RULES[operation][2](*(value[k] for k in operands), own_value) if operands else ()
            for operand, factor in zip(operands, factors, strict=True):
                for k, d in slopes[operand].items():
                    term = factor if d is ONE else d if factor is ONE else factor * d
                    own[k] = own[k] + term if k in own else term
        return [slopes[place] for place in roots]

    def _plan(self, roots: tuple[int, ...]) -> list[int]:
        """Return the lines that some lines need, in order."""
        if roots not in self._plans:
            needed = set(roots)
            for place in range(max(roots, default=-1), -1, -1):
                needed.update(self.operands[place] if place in needed else ())
            self._plans[roots] = sorted(needed)
        return self._plans[roots]
