"""The error to expect at a setting that was not run, from the posterior of the runs that were."""

from __future__ import annotations

import numpy as np

from cross_checks.judge.convergence.model import AMPLITUDES, DISTANCES, FADE, LEVELS, Posterior, saturated

FAR = {"fixed": 0.25, "adaptive": 0.4}  # decades: scatter of an error far from all runs
NEAR = 0.06  # decades: scatter of an error at a setting that was run
MEMORY = 1.5  # decades of the error over which the nearest run's distance from the law fades by e
LIKELY = 1e-3  # of the largest probability: laws below are left out


def odds_below(posterior: Posterior, settings: np.ndarray, error: float) -> np.ndarray:
    """Return the probability (n_s,) that a run at each setting has an error of at most `error`."""
    weights, goal = posterior.weights, np.log10(error)
    by_law = _odds_by_law(posterior, settings, goal)
    near_limit = float(posterior.distance[goal > DISTANCES].sum())
    stalled = float(posterior.level[goal > LEVELS].sum())
    odds = by_law * (weights["right"] + weights["limit"] * near_limit) + weights["stalled"] * stalled
    return odds + weights["plateau"] * _odds_after_plateau(posterior, settings, goal)


def probability_below(z: np.ndarray) -> np.ndarray:
    """Return the cumulative probability of Student's t with 4 degrees of freedom."""
    u = z / np.sqrt(1.0 + 0.25 * z * z)
    return 0.5 + 0.375 * u * (1.0 - u * u / 12.0)


def expected_log_error(posterior: Posterior, settings: np.ndarray) -> np.ndarray:
    """Return the mean log10 error (n_s,) by the law alone."""
    weight, predicted, _ = _predicted(posterior, settings)
    return weight @ predicted


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
    known = np.log10(np.maximum(ladder.errors, 1e-18))
    share = np.exp(-np.abs(law - at_runs[:, nearest]) / MEMORY)
    scatter = NEAR + (FAR[ladder.kind] - NEAR) * np.sqrt(1.0 - share)
    return weight, law + share * (known - at_runs)[:, nearest], scatter


def _odds_by_law(posterior: Posterior, settings: np.ndarray, goal: float) -> np.ndarray:
    weight, predicted, scatter = _predicted(posterior, settings)
    return weight @ probability_below((goal - predicted) / scatter)


def _odds_after_plateau(posterior: Posterior, settings: np.ndarray, goal: float) -> np.ndarray:
    """The plateau ends with every decade of a finer setting; then an error is typical."""
    ladder = posterior.ladder
    here = float(np.log10(max(ladder.errors[-1], 1e-18)))
    decades = np.maximum(np.log10(ladder.settings[-1] / settings), 0.0)
    remains = np.exp(-decades / FADE[ladder.kind])
    typical = ladder.typical + ladder.order * np.log10(settings / ladder.reference)
    after = probability_below((goal - np.minimum(typical, here)) / 1.5)
    return remains * (here <= goal) + (1.0 - remains) * after
