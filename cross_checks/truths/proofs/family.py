"""Families of scenes: one parameter anywhere in an interval, every number a quadratic polynomial of it.

A family has three scenes, at the ends and in the middle. Its parameter s is -1, 0 and 1 there, and each number of the
scene is the polynomial through its three values, exactly. A proof for all s in [-1, 1] encloses all of its motions.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from pydantic import BaseModel


class Varied(float):
    """A number of the middle scene with those of the ends."""

    ends: tuple[float, float]

    def coefficients(self, exact: Callable[[float], Fraction]) -> tuple[Fraction, Fraction, Fraction]:
        """Return the coefficients of 1, s and s^2."""
        low, middle, high = (exact(x) for x in (self.ends[0], float(self), self.ends[1]))
        return middle, (high - low) / 2, (high + low) / 2 - middle


def family(middle: Any, low: Any, high: Any) -> Any:
    """Return a scene whose numbers are `Varied` where the three differ. ValueError where they differ otherwise."""
    if isinstance(middle, BaseModel) and type(low) is type(middle) is type(high):
        names = [name for name in type(middle).model_fields if name not in ("parameters", "description")]
        parts = {name: family(*(getattr(one, name) for one in (middle, low, high))) for name in names}
        return middle.model_copy(update=parts)
    if isinstance(middle, tuple) and len(low) == len(middle) == len(high):
        return tuple(map(family, middle, low, high))
    if low == middle == high:
        return middle
    if not isinstance(middle, float):
        raise ValueError(f"the parameter changes {middle!r} to {low!r} or {high!r}, which is no number")
    varied = Varied(middle)
    varied.ends = (low, high)
    return varied
