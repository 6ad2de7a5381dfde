"""The runs of one method on one scene as the data of the convergence model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from cross_checks.judge.bounds import SCATTER

SAME_STEPS = 1.05  # ratio of step counts below which a finer setting refines nothing: outputs or events set the steps
SATURATED = 0.5  # of the scene: motions farther apart are unrelated, and only bound the law from below
DOUBLE = 2.0**-53  # no run is closer to another than the rounding of its state
FARTHEST = (2.0, 20.0)  # of the scene: bounds of the largest distance between motions; beyond, a run has blown up
UNRELATED = 4  # such runs that count where there are no others


@dataclass(frozen=True)
class Ladder:
    """Successful runs from coarse to fine. Errors and gaps are distances over the scene's scales."""

    settings: np.ndarray  # (n,) steps (s) or relative tolerances
    errors: np.ndarray  # (n,) distance from the truth; NaN where no truth is known
    gaps: np.ndarray  # (n, n) distances between runs; NaN where unknown
    steps: np.ndarray  # (n,) int, 0 where the engine reports none
    rounding: np.ndarray  # (n,) what rounding may add to the error
    kind: str  # of the setting: "fixed" or "adaptive"
    order: float  # expected power of the setting that the error follows
    reference: float = 1.0  # setting at which an error is typical before any run ...
    typical: float = 0.0  # ... and its log10 ...
    spread: float = 2.0  # ... within so many decades
    uncertainty: float = 0.0  # of the truth

    @classmethod
    def of(cls, runs: Iterable[tuple[float, float | None, int, float]], gaps: np.ndarray, **facts) -> Ladder:
        """Return the data of runs, each with its setting, error, number of steps and rounding."""
        settings, errors, steps, rounding = np.array([*runs], dtype=float).T  # None becomes NaN
        return cls(settings, errors, gaps, steps.astype(int), rounding, **facts)

    def __len__(self) -> int:
        return len(self.settings)

    @property
    def bound(self) -> float:
        """The largest distance between two motions of this scene, as far as the runs show."""
        largest = np.nanmax(np.append(self.errors, self.gaps), initial=FARTHEST[0])
        return float(np.clip(largest, *FARTHEST))

    @property
    def is_falling(self) -> bool:
        """Whether the finest error is below those of the two levels before by more than scatter; true of one level."""
        return bool(self.errors[-1] < np.min(self.errors[-3:-1], initial=np.inf) / SCATTER)

    def levels(self) -> Ladder:
        """Return one run per level: its largest error stands, at its finest setting.

        Runs belong to the level of the coarser run where they take hardly more steps than it did. Of coarse runs that
        are unrelated to the truth only the finest counts.
        """
        chosen: list[int] = []
        finest: list[int] = []
        most = 0
        for k, steps in enumerate(self.steps):
            if not chosen or steps == 0 or steps > SAME_STEPS * most:
                chosen.append(k)
                finest.append(k)
            else:
                finest[-1] = k
                if not self.errors[chosen[-1]] > self.errors[k]:
                    chosen[-1] = k
            most = max(most, int(steps))
        related = next((k for k, place in enumerate(chosen) if not self.errors[place] > SATURATED), len(chosen))
        first = max(0, related - 1) if related < len(chosen) else max(0, len(chosen) - UNRELATED)
        finest, take = finest[first:], np.array(chosen[first:], dtype=int)
        return replace(
            self, settings=self.settings[finest], errors=self.errors[take], gaps=self.gaps[np.ix_(take, take)],
            steps=self.steps[take], rounding=np.maximum(self.rounding[finest], DOUBLE),
        )  # fmt: skip

    def take(self, which: np.ndarray | slice) -> Ladder:
        """Return the chosen runs, by places or as a mask (n,)."""
        parts = {name: getattr(self, name)[which] for name in ("settings", "errors", "steps", "rounding")}
        return replace(self, **parts, gaps=self.gaps[which][:, which])
