"""Balls, floats that bound them, and what is refused."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import reduce
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx, fmpq  # pyright: ignore[reportMissingImports]  # an optional extra

GAMMA = 1e-12  # of |A| |B|: 9000 roundings of 2^-53

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
    values = [reduce(lambda value, c: value * s + c, reversed(row), arb(0)) for row in p]
    return [value + arb(0, float(wide)) for value, wide in zip(values, e, strict=True)]
