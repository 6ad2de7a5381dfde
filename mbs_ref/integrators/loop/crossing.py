"""Carry a method past a singular pose: DOP853 with projected stages leaps, then it restarts.

On the constraints the accelerations stay smooth there, but roundoff in them grows as eps / sigma^3, and
a method whose stages are not projected, or whose steps cannot choose their places, grinds to a halt.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import (
    DONE,
    NEAR_SINGULAR,
    RUNNING,
    STEP_TOO_SMALL,
    Leg,
    Options,
    Outputs,
    Progress,
    progress,
)
from mbs_ref.integrators.stages.tableau import DOP853
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

NEAR = 1e-2  # relative closure pivot below which a leap begins
MOST_STEPS = 500  # in a row
_dop853 = explicit(DOP853)


@dataclass
class Landing:
    """Where a leap ended, and what it passed."""

    t: float  # s
    y: np.ndarray
    reached: int  # outputs filled
    failed: Leg | None = None


def is_near_singular(system: "System", t: float, y: np.ndarray) -> bool:
    """Return whether the pose at (t, y) is close to a singular one."""
    system.derivative(t, y)
    return system.regularity() < NEAR


def leap(
    system: "System", options: Options, run: Progress, t: float, y: np.ndarray,
    times: np.ndarray, reached: int, states: np.ndarray,
) -> Landing:  # fmt: skip
    """Integrate from (t, y) until the pose is regular again, filling the outputs on the way."""
    now, own = y.copy(), progress(t)
    system.project(t, now, options.projection_tolerance)
    for _ in range(MOST_STEPS):
        one_more = options._replace(max_steps=int(own.steps) + 1)
        leg = _dop853(system, one_more, own, now, np.array([float(own.t), *times[reached:]]))
        for state in leg.states[1 : leg.reached]:
            states[reached] = state
            reached += 1
        failed = leg.status not in (Status.SUCCESS, Status.TOO_MANY_STEPS)
        if failed or reached == len(times) or not is_near_singular(system, float(own.t), now):
            break
    run.carried += own.t - t
    run.near_singular += own.near_singular
    run.steps += own.steps
    run.rejected += own.rejected
    run.rhs_calls += own.rhs_calls
    return Landing(float(own.t), now, reached, leg if failed else None)


class Crossing:
    """Carries a compiled adaptive method on where it has come near a singular pose."""

    def __init__(self, system: "System", options: Options, run: Progress, y: np.ndarray) -> None:
        self.system, self.options, self.run, self.y = system, options, run, y
        self.failed: Leg | None = None  # of DOP853

    def past(self, code: int, outputs: Outputs) -> int:
        """Return how a leg goes on after a chunk that ended with `code`; y, clock and outputs move on with it."""
        if code != NEAR_SINGULAR:
            return code
        run, y = self.run, self.y
        reached = int(run.next_output)
        landing = leap(self.system, self.options, run, float(run.t), y, outputs.times, reached, outputs.states)
        y[:] = landing.y
        run.t, run.next_output, run.h = landing.t, landing.reached, 0.0
        self.failed = landing.failed
        if landing.failed is not None:
            return STEP_TOO_SMALL
        return DONE if landing.reached == len(outputs.times) else RUNNING

    def finish(self, leg: Leg) -> Leg:
        """Return the leg; where DOP853 failed in it, with its status and message."""
        return replace(leg, status=self.failed.status, message=self.failed.message) if self.failed else leg
