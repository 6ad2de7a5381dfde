"""A file's motion as it is understood so far, and hypotheses: changes whose numbers are fitted to it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from cross_checks.judge.measure import error_of
from cross_checks.metrics.metric import Judged
from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.formats import Columns
from cross_checks.trajectory_files.judgement import truth_rows
from cross_checks.truths.truth import Truth
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.observables.distance import turn_between, units_of
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate import simulate

WINDOWS = (8, 4, 2, 1)  # parts of the samples that are fitted one after the other: short ones have one minimum
FEWEST = 4  # samples of a window
VISIBLE = 1e-3  # of the error: a window with less does not show the change
HOPEFUL = 3.0  # times less error in a window, or the change is given up
EVALUATIONS = 12  # of a change in a window, for each number that is fitted and one more
DIFFERENCE = 1e-5  # of a number, for derivatives
GAIN = 1e-3  # of the sum of squares: a fit ends where an iteration would gain less
RERUN = Settings(rtol=1e-11, estimate="off", reactions=False)  # of a changed scene


@dataclass(frozen=True)
class Case:
    """What a mistake is looked for in."""

    scene: Scene
    columns: Columns
    stated: ColumnMap
    path: Trajectory
    truth: Truth
    assumed: Scene | None = None  # what the file's tool simulated, as far as it is understood; None: the scene
    late: float = 0.0  # s, how far the file's samples lag behind
    rates_late: float = 0.0  # s, how far its rates lag behind its poses

    @cached_property
    def error(self) -> float:
        """Of the scene; infinite where it is not finite."""
        error, _ = error_of(Judged(self.scene, self.path, self.truth))
        return np.inf if error is None else error.value

    @cached_property
    def work(self) -> float:
        """The right-hand sides of a run of the scene, times its bodies."""
        return simulate(self.scene, RERUN).rhs_calls * len(self.scene.bodies)

    @property
    def comparable_turns(self) -> bool:
        """Whether both sides count orientations alike; a truth of particles has none."""
        return self.truth.orientation.ndim == self.path.orientation.ndim

    @property
    def gaps(self) -> np.ndarray:
        """The differences from the truth (n,), of the scene's scales; 0 where they are unknown."""
        path, truth = self.path, self.truth
        turns = turn_between(path.orientation, truth.orientation, not self.scene.planar)
        rates = ((path.velocity, truth.velocity), (path.angular_velocity, truth.angular_velocity))
        others = [np.zeros(0) if b is None or a.ndim != b.ndim else a - b for a, b in rates]
        every = (path.position - truth.position, np.zeros(0) if turns is None else turns, *others)
        scaled = [np.ravel(gap) / unit for gap, unit in zip(every, units_of(scales_of(self.scene)), strict=True)]
        return np.nan_to_num(np.concatenate(scaled), posinf=0.0, neginf=0.0)

    def at(self, rows: np.ndarray) -> "Case":
        """Return the case of some samples, given by their places."""
        return replace(self, path=self.path.at(rows), truth=truth_rows(self.truth, rows))

    def rerun(self, **changed: object) -> "Case | None":
        """Return the case with another `assumed` scene or lag, compared with a run of it; None where that fails.

        Samples from outside of the scene's duration are unknown.
        """
        case = replace(self, **changed)  # type: ignore[arg-type]
        late = (case.late, case.late + case.rates_late)
        wanted = [np.clip(case.path.times - lag, 0.0, case.scene.duration) for lag in late]
        times = np.unique(np.concatenate(([0.0], *wanted)))
        try:
            run = simulate(case.assumed or case.scene, RERUN, times)
        except ValueError:
            return None
        if not run.ok or len(run.times) < len(times):
            return None
        poses, rates = (run.at(np.searchsorted(times, when)) for when in wanted)
        parts = (poses.position, poses.orientation, rates.velocity, rates.angular_velocity)
        for part, when, lag in zip(parts, np.repeat(wanted, 2, axis=0), np.repeat(late, 2), strict=True):
            part[when != case.path.times - lag] = np.nan
        truth = Truth(poses.position, poses.orientation, 0.0, "agreed", "a run of what the file's tool may have done",
                      velocity=rates.velocity, angular_velocity=rates.angular_velocity,
                      rate_uncertainty=np.zeros(len(case.path.times)))  # fmt: skip
        return replace(case, truth=truth)


class Hypothesis(NamedTuple):
    """A change, given by numbers x (p,) that are fitted from each of some starts, or are as they are given."""

    change: Callable[[Case, np.ndarray], Case | None]  # None where it cannot be
    say: Callable[[np.ndarray], str]
    starts: tuple[tuple[float, ...], ...] = ((),)
    fitted: bool = False
    is_none: Callable[[np.ndarray], bool] = lambda x: False  # whether numbers change next to nothing


class Explanation(NamedTuple):
    """A hypothesis at the numbers that fit best, and what remains to be explained."""

    sentence: str
    case: Case
    numbers: int  # that are fitted


def explanations(case: Case, hypothesis: Hypothesis) -> Iterator[Explanation]:
    """Yield the hypothesis from each of its starts."""
    for start in hypothesis.starts:
        x = np.array(start)
        best = _fitted(case, hypothesis, x) if hypothesis.fitted else x
        if best is None or hypothesis.is_none(best):
            continue
        changed = hypothesis.change(case, best)
        if changed is not None:
            yield Explanation(hypothesis.say(best), changed, len(x) * hypothesis.fitted)


def _fitted(case: Case, hypothesis: Hypothesis, x: np.ndarray) -> np.ndarray | None:
    """Return the numbers that leave least of the gaps, by least squares in windows that grow; None where one fails."""
    for share in WINDOWS:
        part = case.at(np.arange(len(case.path.times))[: max(len(case.path.times) // share, FEWEST)])
        gaps = part.gaps
        if not part.error > VISIBLE * case.error or len(gaps) < len(x):
            continue

        def left(x: np.ndarray, part: Case = part, blocked: np.ndarray = gaps) -> np.ndarray:
            changed = hypothesis.change(part, x)
            return 10.0 * blocked if changed is None else changed.gaps

        most = EVALUATIONS * (len(x) + 1)
        x = least_squares(left, x, method="lm", ftol=GAIN, diff_step=DIFFERENCE, max_nfev=most).x
        now = hypothesis.change(part, x)
        if now is None or not now.error * HOPEFUL < part.error:
            return None
    return x


def vector(values: np.ndarray) -> str:
    """Return a vector for a sentence; what is roundoff beside the largest component is 0."""
    largest = np.max(np.abs(values))
    return f"({', '.join(f'{0.0 if abs(v) < 5e-4 * largest else v:.4g}' for v in values)})"
