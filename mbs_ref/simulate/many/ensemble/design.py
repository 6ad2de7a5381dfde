"""The varied numbers, their laws, and the values of every run: a Latin hypercube at each point of the grids."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mbs_ref.simulate.many.ensemble.laws import Grid, Law

MAX_RUNS = 10_000_000
DEFAULT_COUNT = 200  # samples


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
        from scipy.stats import qmc

        laws = {name: law for name, law in self.laws.items() if not isinstance(law, Grid)}
        if not laws:
            return {}
        shares = qmc.LatinHypercube(len(laws), rng=np.random.default_rng(self.seed)).random(self.count)
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
