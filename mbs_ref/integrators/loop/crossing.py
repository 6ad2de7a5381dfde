"""Carry a multistep method past a singular pose: DOP853 with projected stages leaps, then it restarts.

On the constraints the accelerations stay smooth there, but roundoff in them grows as eps / sigma^3, and
a multistep method, whose steps cannot choose their places, grinds to a halt.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import Leg, Options, Progress, progress
from mbs_ref.integrators.stages.dop853_tableau import TABLEAU

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

NEAR = 1e-2  # relative closure pivot below which a leap begins
LEAP = 0.02  # s at most between looks at the pivot
MOST_LEAPS = 500  # in a row
_dop853 = explicit(TABLEAU)


@dataclass
class Landing:
    """Where a leap ended, and what it passed."""

    t: float  # s
    y: np.ndarray
    reached: int  # outputs filled
    failed: Leg | None = None


def is_near_singular(system: System, t: float, y: np.ndarray) -> bool:
    """Return whether the pose at (t, y) is close to a singular one."""
    system.derivative(t, y)
    return system.regularity() < NEAR


def leap(
    system: System, options: Options, run: Progress, t: float, y: np.ndarray,
    times: np.ndarray, reached: int, states: np.ndarray,
) -> Landing:  # fmt: skip
    """Integrate from (t, y) until the pose is regular again, filling the outputs on the way."""
    now = y.copy()
    system.project(t, now, options.projection_tolerance)
    for _ in range(MOST_LEAPS):
        end = min(t + LEAP, float(times[-1]))
        inside = times[(times > t) & (times < end)]
        own = progress(t)
        leg = _dop853(system, options, own, now, np.array([t, *inside, end]))
        run.steps += own.steps
        run.rejected += own.rejected
        run.rhs_calls += own.rhs_calls
        if leg.reached < len(inside) + 2:
            return Landing(float(own.t), now, reached, leg)
        for state in leg.states[1 : 1 + len(inside)]:
            states[reached] = state
            reached += 1
        t, now = end, leg.states[-1].copy()
        if reached < len(times) and t >= times[reached]:
            states[reached] = now
            reached += 1
        if reached == len(times) or not is_near_singular(system, t, now):
            break
    return Landing(t, now, reached)
