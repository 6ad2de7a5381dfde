"""What a synthetic method is: a law of its state at every setting, assembled from terms and failures.

A run at a setting s (a step in s, or a relative tolerance) ends at the state `limit + offset + terms(s)`, a vector of
40 to 120 components. Its largest component is the error, that of a difference the gap of two runs. `offset` is the
error of the truth, of size `uncertainty`. `limit` is the distance of the method's own limit from the exact truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal

import numpy as np

from cross_checks.engine.method import DOUBLE

OUTPUTS = 40  # intervals between the output times of a run
MOST_STEPS = 100_000  # of the finest fixed step
ALONG = 2  # the stream of noise that is the direction of the power law
WHITE = 1e-4  # decades of the setting: noise of this width is independent from run to run

Label = Literal["correct", "wrong-limit", "never"]
type Term = Callable[[float, int], np.ndarray]  # (log10 of the setting, steps) -> part of the state
type Failure = Callable[[float], str]  # log10 of the setting -> status; empty where the run succeeds


@dataclass(frozen=True)
class Outcome:
    """What one run returns."""

    status: str  # success, non-finite, not-converged, step-too-small, cannot, timeout
    state: np.ndarray | None  # None unless the run succeeds
    steps: int


@dataclass(frozen=True)
class SyntheticMethod:
    """A method of known behaviour."""

    category: str
    label: Label
    kind: Literal["fixed", "adaptive"]
    order: int  # documented
    embedded: int  # order of the solution that an error estimate compares with
    is_smooth: bool  # False: contacts begin and end between steps
    roundoff: float  # of a step, over the size of the state
    amplification: float  # growth of errors by the motion, to a factor of 2
    uncertainty: float  # of the truth
    duration: float  # s
    limit: np.ndarray  # the method's own limit relative to the exact truth; for `never` zero without meaning
    law: Callable[[float], Outcome]

    def run(self, setting: float) -> Outcome:
        """Return the run at a step (s) or a relative tolerance; the same setting gives the same state bit by bit."""
        return self.law(setting)

    @property
    def limit_distance(self) -> float:
        """The distance of the limit from the exact truth: 0, the height of a floor below BAR, or a wrong limit."""
        return size(self.limit)

    @property
    def coarsest(self) -> float:
        return self.duration / OUTPUTS if self.kind == "fixed" else 1e-2

    @property
    def finest(self) -> float:
        return self.duration / MOST_STEPS if self.kind == "fixed" else 1e-14


def size(state: np.ndarray) -> float:
    """Return the norm of errors and gaps: the largest component."""
    return float(np.max(np.abs(state)))


@dataclass
class Draft:
    """What a category may change before a method is complete. Logarithms are decimal."""

    seed: tuple[int, int]
    rng: np.random.Generator
    kind: Literal["fixed", "adaptive"]
    order: int
    duration: float  # s
    amplification: float
    uncertainty: float
    components: int
    power: float  # of the error in the setting
    reach: float  # log of the setting at which the error reaches 10^height
    height: float
    scatter: float  # decades
    turning: float  # share of the direction that changes with the setting
    width: float  # decades of the setting over which scatter and direction change
    first_steps: float  # of a tolerance of 1
    embedded: int
    roundoff: float = DOUBLE
    tails: int = 0  # degrees of freedom of the scatter, Student's t; 0: Gaussian
    plateau: float = math.inf  # log of the tolerance above which outputs or events determine the steps
    creep: float = 0.0  # share of a change of the tolerance that has an effect on a plateau
    bound: float = 2.0  # of the error, over the scene
    is_smooth: bool = True
    limit: float = 0.0
    frozen: float = math.nan  # log of the setting that is used in place of every other
    terms: list[Term] = field(default_factory=list)  # beside the power law and rounding
    failures: list[Failure] = field(default_factory=list)

    def uniform(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def power_of_ten(self, low: float, high: float) -> float:
        return float(10.0 ** self.rng.uniform(low, high))

    def chance(self, odds: float) -> bool:
        return bool(self.rng.random() < odds)

    def within(self, low: float, high: float) -> float:
        """Return the log of a setting of the range: at 10^low to 10^high steps, or so many decades of tolerance."""
        if self.kind == "adaptive":
            return -2.0 - 12.0 * (self.uniform(low, high) - math.log10(OUTPUTS)) / math.log10(MOST_STEPS / OUTPUTS)
        return math.log10(self.duration) - self.uniform(low, high)

    @property
    def coarse(self) -> float:
        """The log of the coarsest setting."""
        return -2.0 if self.kind == "adaptive" else math.log10(self.duration / OUTPUTS)

    def noise(self, stream: int, x: float, width: float) -> np.ndarray:
        """Return Gaussian numbers (components,) that change over `width` decades of the setting 10^x."""
        return _wandering((*self.seed, stream), x, width, self.components)

    def normal(self, stream: int, x: float) -> float:
        """Return a Gaussian number, another one for every setting."""
        return float(self.noise(stream, x, WHITE)[0])

    def direction(self, stream: int, x: float, width: float = WHITE) -> np.ndarray:
        """Return noise of largest component 1."""
        numbers = self.noise(stream, x, width)
        return numbers / size(numbers)

    def add(self, height: Callable[[float, int], float], width: float = WHITE) -> None:
        """Add a term of this size whose direction changes over `width` decades."""
        stream = 10 + len(self.terms)
        self.terms.append(lambda x, steps: height(x, steps) * self.direction(stream, x, width))

    def add_aligned(self, share: Callable[[float], float]) -> None:
        """Add a term in the constant direction of the power law, this times as large."""
        self.terms.append(lambda x, steps: share(x) * self.amplitude(x) * self.direction(ALONG, x, math.inf))

    def amplitude(self, x: float) -> float:
        """Return the error at the setting 10^x by the power law, without scatter."""
        return 10.0 ** min(self.height + self.power * (x - self.reach), 60.0)


@lru_cache(maxsize=4096)
def _node(seed: tuple[int, ...], place: int, components: int) -> np.ndarray:
    return np.random.default_rng((*seed, place + 2**31)).normal(size=components)


def _wandering(seed: tuple[int, ...], x: float, width: float, components: int) -> np.ndarray:
    """Return Gaussian noise of variance 1 at x, interpolated between nodes `width` apart."""
    place, share = divmod(x / width, 1.0)
    turn = 0.5 * math.pi * share
    nodes = [_node(seed, int(place) + k, components) for k in (0, 1)]
    return math.cos(turn) * nodes[0] + math.sin(turn) * nodes[1]


def _power_law(draft: Draft) -> Term:
    """Return C s^p z(s): its size scatters, its direction turns, the more where the error is that of another motion."""

    def term(x: float, steps: int) -> np.ndarray:
        first, *rest = draft.noise(1, x, draft.width)[:11]
        heavy = math.sqrt(draft.tails / sum(r**2 for r in rest[: draft.tails])) if draft.tails else 1.0
        amplitude = draft.amplitude(x) * 10.0 ** (draft.scatter * float(np.clip(first * heavy, -30.0, 30.0)))
        turning = max(draft.turning, amplitude / (1.0 + amplitude))
        straight = math.sqrt(max(0.0, 1.0 - turning**2)) * draft.direction(ALONG, x, math.inf)
        mixed = straight + turning * draft.direction(3, x, draft.width)
        return amplitude * mixed / size(mixed)

    return term


def _rounding(draft: Draft) -> Term:
    growth = 1.0 if draft.chance(0.5) else 0.5
    height = draft.roundoff * draft.amplification * draft.power_of_ten(-1.5, 0.7)
    return lambda x, steps: height * float(steps) ** growth * draft.direction(4, x)


def complete(draft: Draft, category: str, label: Label) -> SyntheticMethod:
    """Return the method of a draft that does not change any more."""
    terms = [_power_law(draft), _rounding(draft), *draft.terms]
    limit = draft.limit * draft.direction(5, 0.0, math.inf)
    offset = draft.uncertainty * draft.uniform(0.1, 1.0) * draft.direction(6, 0.0, math.inf)
    share = 1.0 / (draft.embedded + 1.0)
    full = math.log10(OUTPUTS / draft.first_steps) / -share  # above this tolerance outputs alone determine the steps
    plateau, creep = (draft.plateau, draft.creep) if draft.plateau < full else (full, 0.0)

    def law(setting: float) -> Outcome:
        x = math.log10(setting)
        if draft.kind == "fixed":
            steps = math.ceil(draft.duration / setting * (1.0 - 1e-9))
        else:
            x = x if x <= plateau else plateau + creep * (x - plateau)
            steps = math.ceil(draft.first_steps * 10.0 ** (-share * x) - 1e-6)
        reported = steps
        if not math.isnan(draft.frozen):
            x, steps = draft.frozen, OUTPUTS
        status = next((named for failure in draft.failures if (named := failure(math.log10(setting)))), "")
        if status:
            return Outcome(status, None, reported)
        moved = np.sum([term(x, steps) for term in terms], axis=0)
        if not size(moved) < 1e12 and math.isinf(draft.bound):
            return Outcome("non-finite", None, reported)
        return Outcome("success", limit + offset + moved / (1.0 + size(moved) / draft.bound), reported)

    return SyntheticMethod(
        category, label, draft.kind, draft.order, draft.embedded, draft.is_smooth, draft.roundoff,
        max(1.0, draft.amplification * draft.power_of_ten(-0.3, 0.3)), draft.uncertainty, draft.duration, limit, law,
    )  # fmt: skip
