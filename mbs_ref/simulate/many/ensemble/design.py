"""The varied numbers, their laws, and the values of every run: a Latin hypercube at each point of the grids."""

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

NOTATION = "LOW..HIGH (uniform), MEAN+-SD or +-SD or +-P% (normal), LOW:HIGH:N (a grid of N even values)"
NUMBER = r"[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?"
UNIFORM = re.compile(rf"({NUMBER})\.\.({NUMBER})")
NORMAL = re.compile(rf"({NUMBER})?\+-({NUMBER})(%?)")
GRID = re.compile(rf"({NUMBER}):({NUMBER}):(\d+)")
MAX_RUNS = 10_000_000
DEFAULT_COUNT = 200  # samples


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
        return scipy.stats.norm.ppf(probability, self.mean, self.deviation)

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
        deviation = _finite(match[2])
        if not match[3]:
            return Normal(mean, deviation)
        if mean == 0.0:
            raise ValueError(f"{deviation:g} % of 0 is nothing; give the standard deviation itself")
        return Normal(mean, abs(mean) * deviation / 100.0)
    raise ValueError(f"{text!r} is no law; allowed: {NOTATION}")


def _finite(text: str) -> float:
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(f"{text} is beyond the largest number")
    return value


@dataclass(frozen=True)
class Design:
    """The values of every run, ordered by points of the grids."""

    laws: Mapping[str, Law]  # by the name of the varied number
    count: int  # of samples at each point of the grids; 1 where nothing is random
    seed: int

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.laws)

    @property
    def grids(self) -> dict[str, Grid]:
        """The numbers that vary over a grid."""
        return {name: law for name, law in self.laws.items() if isinstance(law, Grid)}

    @property
    def is_random(self) -> bool:
        return len(self.grids) < len(self.laws)

    @cached_property
    def points(self) -> np.ndarray:
        """The points of the product of the grids (n_points, n_grids); one empty point if there is no grid."""
        points = list(itertools.product(*(grid.values for grid in self.grids.values())))
        return np.array(points, dtype=float).reshape(len(points), len(self.grids))

    @property
    def n_runs(self) -> int:
        """The number of requested runs."""
        return self.count * math.prod(grid.count for grid in self.grids.values())

    @cached_property
    def values(self) -> np.ndarray:
        """The values of every run (n_points * count, n_names); the samples are equal at all points of the grids."""
        result = np.empty((len(self.points), self.count, len(self.laws)))
        samples, at_grid = self._samples(), iter(range(len(self.grids)))
        for k, (name, law) in enumerate(self.laws.items()):
            grid = isinstance(law, Grid)
            result[:, :, k] = self.points[:, next(at_grid), None] if grid else samples[name]
        return result.reshape(-1, len(self.laws))

    def runs_at(self, point: int) -> slice:
        """Return the runs of a point of the grids."""
        return slice(point * self.count, (point + 1) * self.count)

    def sentence(self) -> str:
        """Return a sentence on the choice of values."""
        grid = " x ".join(str(one.count) for one in self.grids.values())
        at_grid = f"a grid of {grid} values" if grid else ""
        if not self.is_random:
            return at_grid
        samples = f"{self.count} samples of a Latin hypercube, seed {self.seed}: the same command draws the same ones"
        return f"at each point of {at_grid} {samples}" if grid else samples

    def _samples(self) -> dict[str, np.ndarray]:
        """Return the samples (count,) of the random numbers.

        Latin hypercube: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239.
        """
        laws = {name: law for name, law in self.laws.items() if not isinstance(law, Grid)}
        if not laws:
            return {}
        shares = scipy.stats.qmc.LatinHypercube(len(laws), rng=np.random.default_rng(self.seed)).random(self.count)
        inside = np.clip(shares, np.finfo(float).tiny, np.nextafter(1.0, 0.0))
        return {name: law.at(column) for (name, law), column in zip(laws.items(), inside.T, strict=True)}


def design(laws: Mapping[str, Law], count: int | None = None, seed: int = 0) -> Design:
    """Return the design of the runs; ValueError for an impossible number of runs or samples."""
    result = Design(dict(laws), DEFAULT_COUNT if count is None else count, seed)
    if not laws:
        raise ValueError("nothing is varied")
    if not result.is_random:
        if count is not None:
            raise ValueError(f"n = {count}: grids have their own values, and no law is random")
        result = Design(dict(laws), 1, seed)
    elif result.count < 2:
        raise ValueError(f"n = {count} samples have no spread; allowed: 2 and more")
    if seed < 0:
        raise ValueError(f"seed = {seed} must not be negative")
    if result.n_runs > MAX_RUNS:
        raise ValueError(f"{result.n_runs} runs are requested; allowed: {MAX_RUNS}")
    return result
