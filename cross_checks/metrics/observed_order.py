"""The order of convergence a method shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cross_checks.truth import MARGIN

ROUNDOFF = 1e-10  # m; thousands of steps of double rounding, magnified by the motion
ASYMPTOTIC = 1e-1  # m; larger errors are not yet in the regime where the order shows
POINTS = 3  # the finest valid ones are fitted


def observed_order(
    steps: Sequence[float], errors: Sequence[float], uncertainty: float = 0.0, rounding: Sequence[float] = ()
) -> float | None:
    """Return the slope of log(error) against log(step) over the finest valid runs; None without two of them.

    Valid errors lie above roundoff and above thirty times the truth's uncertainty, and below a
    decimetre. A method that has stalled at another limit shows an order near 0. `rounding` is what the rounding of its
    steps may have left of each error; where it hides finer runs, three are asked for: two coarse ones show little.
    """
    floor = max(ROUNDOFF, MARGIN * uncertainty)
    runs = sorted(zip(steps, errors, rounding or [0.0] * len(steps), strict=True))
    best = min(range(len(runs)), key=lambda k: runs[k][1], default=0)  # finer runs that are worse show no order
    valid = [(h, e) for h, e, rounded in runs[best:] if max(floor, rounded) < e < ASYMPTOTIC][:POINTS]
    hidden = any(floor < e <= rounded for _, e, rounded in runs)
    if len({h for h, _ in valid}) < (POINTS if hidden else 2):
        return None
    h, e = np.log(np.array(valid)).T
    return float(np.polyfit(h, e, 1)[0])
