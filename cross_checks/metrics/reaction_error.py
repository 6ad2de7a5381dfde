"""Difference of joint reactions from a reference's."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.metric import Absent, Judged, Metric


def reaction_error(reactions: dict[str, np.ndarray], reference: dict[str, np.ndarray]) -> float | None:
    """Return the largest difference (N, N m) over the joints and samples both report; None without any.

    Each entry is (n_t, 3): the force on body_b at the joint point along the world axes, and the torque.
    """
    common = sorted(reactions.keys() & reference.keys())
    gaps = [_largest_gap(reactions[name], reference[name]) for name in common]
    finite = [gap for gap in gaps if np.isfinite(gap)]
    return max(finite) if finite and len(finite) == len(gaps) else None


def _largest_gap(given: np.ndarray, expected: np.ndarray) -> float:
    n = min(len(given), len(expected))
    return float(np.max(np.abs(given[:n] - expected[:n]), initial=0.0))


def _curve(judged: Judged) -> np.ndarray | Absent:
    error = None if judged.reference is None else reaction_error(judged.path.reactions, judged.reference.reactions)
    return Absent() if error is None else np.array([error])


METRICS = (Metric("reaction_error", "joint force error", "N, N m", _curve),)
