"""Laws of a varied number: uniform between bounds, normal about a mean, or a grid of even values."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

NOTATION = "LOW..HIGH (uniform), MEAN+-SD or +-SD or +-P% (normal), LOW:HIGH:N (a grid of N even values)"
NUMBER = r"[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?"
UNIFORM = re.compile(rf"({NUMBER})\.\.({NUMBER})")
NORMAL = re.compile(rf"({NUMBER})?\+-({NUMBER})(%?)")
GRID = re.compile(rf"({NUMBER}):({NUMBER}):(\d+)")


@dataclass(frozen=True)
class Uniform:
    """A uniform distribution between two bounds."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _require_order(self.low, self.high)

    def at(self, probability: np.ndarray) -> np.ndarray:
        """Return the quantiles of some probabilities."""
        return self.low + probability * (self.high - self.low)

    def __str__(self) -> str:
        return f"uniform from {self.low:g} to {self.high:g}"


@dataclass(frozen=True)
class Normal:
    """A normal distribution."""

    mean: float
    deviation: float  # standard

    def __post_init__(self) -> None:
        if not self.deviation > 0.0:
            raise ValueError(f"the standard deviation {self.deviation:g} must be greater than 0")

    def at(self, probability: np.ndarray) -> np.ndarray:
        """Return the quantiles of some probabilities."""
        from scipy.stats import norm

        return norm.ppf(probability, self.mean, self.deviation)

    def __str__(self) -> str:
        return f"normal, mean {self.mean:g}, standard deviation {self.deviation:g}"


@dataclass(frozen=True)
class Grid:
    """Evenly spaced values, bounds included."""

    low: float
    high: float
    count: int

    def __post_init__(self) -> None:
        _require_order(self.low, self.high)
        if self.count < 2:
            raise ValueError(f"a grid of {self.count} values is too small; allowed: 2 and more")

    @property
    def values(self) -> np.ndarray:
        return np.linspace(self.low, self.high, self.count)

    def __str__(self) -> str:
        return f"{self.count} values from {self.low:g} to {self.high:g}"


Law = Uniform | Normal | Grid


def _require_order(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"from {low:g} to {high:g} is no range: the first must be less than the second")


def read_law(text: str, own: float | None) -> Law:
    """Return the law of a text in NOTATION; `own` is the number's own value, the mean of +-SD and +-P%.

    ValueError states what is wrong with the text.
    """
    bare = "".join(text.split())
    if match := UNIFORM.fullmatch(bare):
        return Uniform(_finite(match[1]), _finite(match[2]))
    if match := GRID.fullmatch(bare):
        return Grid(_finite(match[1]), _finite(match[2]), int(match[3]))
    if match := NORMAL.fullmatch(bare):
        mean = _finite(match[1]) if match[1] else own
        if mean is None:
            raise ValueError(f"{text!r} needs a value of the scene as its mean, and there is none; give MEAN+-SD")
        return _normal(mean, _finite(match[2]), match[3] == "%")
    raise ValueError(f"{text!r} is no law; allowed: {NOTATION}")


def _normal(mean: float, deviation: float, is_share: bool) -> Normal:
    if is_share and mean == 0.0:
        raise ValueError(f"{deviation:g} % of 0 is nothing; give the standard deviation itself")
    return Normal(mean, abs(mean) * deviation / 100.0 if is_share else deviation)


def _finite(text: str) -> float:
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(f"{text} is beyond the largest number")
    return value
