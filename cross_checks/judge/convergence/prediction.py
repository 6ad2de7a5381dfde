"""The error to expect at a setting that was not run, from the posterior of the runs that were; and where runs lead."""

from dataclasses import replace

import numpy as np

from cross_checks.judge.convergence.model import AMPLITUDES, DISTANCES, FADE, LEVELS, REAL, TINY, Posterior, saturated
from mbs_ref import Trajectory

FAR = {"fixed": 0.25, "adaptive": 0.4}  # decades: scatter of an error far from all runs
NEAR = 0.06  # decades: scatter of an error at a setting that was run
MEMORY = 1.5  # decades of the error over which the nearest run's distance from the law fades by e
LIKELY = 1e-3  # of the largest probability: laws below are omitted


def odds_below(posterior: Posterior, settings: np.ndarray, error: float | np.ndarray) -> np.ndarray:
    """Return the probability (n_s,) that a run at each setting has an error of at most `error`, one or (n_s,).

    Of a column of errors (n_t, 1), it is (n_t, n_s).
    """
    weights, goal = posterior.weights, np.atleast_1d(np.log10(error))
    weight, predicted, scatter = _predicted(posterior, settings)
    by_law = weight @ probability_below(((goal[..., None, :] - predicted) / scatter).astype(REAL))
    near_limit = np.append(0.0, np.cumsum(posterior.distance))[np.searchsorted(DISTANCES, goal)]
    stalled = np.append(0.0, np.cumsum(posterior.level))[np.searchsorted(LEVELS, goal)]
    odds = by_law * (weights["right"] + weights["limit"] * near_limit) + weights["stalled"] * stalled
    return odds + weights["plateau"] * _odds_after_plateau(posterior, settings, goal)


def probability_below(z: np.ndarray) -> np.ndarray:
    """Return the cumulative probability of Student's t with 4 degrees of freedom."""
    u = z / np.sqrt(1.0 + 0.25 * z * z)
    return 0.5 + 0.375 * u * (1.0 - u * u / 12.0)


def error_range(posterior: Posterior, setting: float) -> tuple[float, float, float]:
    """Return the error at a setting that a run does not exceed with a probability of 0.16, 0.5 and 0.84."""
    errors = np.geomspace(1e-16, 1e2, 145)
    below = odds_below(posterior, np.full(len(errors), setting), errors)
    low, middle, high = (errors[min(int(np.searchsorted(below, odds)), len(errors) - 1)] for odds in (0.16, 0.5, 0.84))
    return float(low), float(middle), float(high)


def _predicted(posterior: Posterior, settings: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return likely laws (n,), their log10 errors (n, n_s), and their scatter (n, n_s)."""
    ladder = posterior.ladder
    p, b = np.nonzero(posterior.law > LIKELY * posterior.law.max())
    weight = posterior.law[p, b] / posterior.law[p, b].sum()
    runs, wanted = np.log10(ladder.settings), np.log10(settings)
    nearest = np.argmin(np.abs(wanted[:, None] - runs), axis=1)
    order = posterior.orders[p][:, None]
    at_runs = np.log10(saturated(AMPLITUDES[b][:, None] + order * (runs - runs[-1]), ladder.bound))
    law = np.log10(saturated(AMPLITUDES[b][:, None] + order * (wanted - runs[-1]), ladder.bound))
    known = np.where(np.isfinite(ladder.errors), np.log10(np.fmax(ladder.errors, TINY)), at_runs)
    share = np.exp(-np.abs(law - at_runs[:, nearest]) / MEMORY)
    scatter = NEAR + (FAR[ladder.kind] - NEAR) * np.sqrt(1.0 - share)
    return weight, law + share * (known - at_runs)[:, nearest], scatter


def _odds_after_plateau(posterior: Posterior, settings: np.ndarray, goal: float | np.ndarray) -> np.ndarray:
    """The plateau ends with every decade of a finer setting; then an error is typical."""
    ladder = posterior.ladder
    here = float(np.log10(max(ladder.errors[-1], 1e-18)))
    decades = np.maximum(np.log10(ladder.settings[-1] / settings), 0.0)
    remains = np.exp(-decades / FADE[ladder.kind])
    typical = ladder.typical + ladder.order * np.log10(settings / ladder.reference)
    after = probability_below((goal - np.minimum(typical, here)) / 1.5)
    return remains * (here <= goal) + (1.0 - remains) * after


def extrapolated(coarse: Trajectory, fine: Trajectory, ratio: float, order: float) -> Trajectory:
    """Return the limit of two runs whose steps are `ratio` > 1 apart and whose error is C h^order.

    Of places, turns and their rates. Whole turns in the plane do not count; Euler parameters have norm 1 again.
    """
    share = 1.0 / (ratio**order - 1.0)
    turns = fine.orientation + share * _turned(coarse.orientation, fine.orientation)
    if turns.ndim == 3:
        turns /= np.linalg.norm(turns, axis=2, keepdims=True)
    return replace(
        fine, orientation=turns,
        position=fine.position + share * (fine.position - coarse.position),
        velocity=fine.velocity + share * (fine.velocity - coarse.velocity),
        angular_velocity=fine.angular_velocity + share * (fine.angular_velocity - coarse.angular_velocity),
    )  # fmt: skip


def _turned(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the shorter way from one orientation to the other: angles in the plane, else Euler parameters."""
    if after.ndim == 2:
        return np.remainder(after - before + np.pi, 2.0 * np.pi) - np.pi
    opposite = np.sum(before * after, axis=2, keepdims=True) < 0.0
    return after - np.where(opposite, -before, before)
