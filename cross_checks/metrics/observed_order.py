"""The order of convergence a method shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cross_checks.truth import MARGIN

ROUNDOFF = 1e-10  # m; thousands of steps of double rounding, magnified by the motion
ASYMPTOTIC = 1e-1  # m; larger errors are not yet in the regime where the order shows
POINTS = 3  # the finest valid ones are fitted


def observed_order(steps: Sequence[float], errors: Sequence[float], uncertainty: float = 0.0) -> float | None:
    """Return the slope of log(error) against log(step) over the finest valid runs; None without two of them.

    Valid errors lie above roundoff and above thirty times the truth's uncertainty, and below a
    decimetre. A method that has stalled at another limit shows an order near 0.
    """
    floor = max(ROUNDOFF, MARGIN * uncertainty)
    runs = sorted(zip(steps, errors, strict=True))
    best = min(range(len(runs)), key=lambda k: runs[k][1], default=0)  # finer runs that are worse show no order
    valid = [(h, e) for h, e in runs[best:] if floor < e < ASYMPTOTIC][:POINTS]
    if len({h for h, _ in valid}) < 2:
        return None
    h, e = np.log(np.array(valid)).T
    return float(np.polyfit(h, e, 1)[0])
