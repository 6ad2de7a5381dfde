"""Carry a method past a singular pose: DOP853 with projected stages leaps, then it restarts.

On the constraints the accelerations stay smooth there, but roundoff in them grows as eps / sigma^3, and
a method whose stages are not projected, or whose steps cannot choose their places, grinds to a halt.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.explicit import explicit
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
    failed: leg.Leg | None = None


def is_near_singular(system: "System", t: float, y: np.ndarray) -> bool:
    """Return whether the pose at (t, y) is close to a singular one."""
    system.derivative(t, y)
    return system.regularity() < NEAR


def leap(
    system: "System", options: leg.Options, run: leg.Progress, t: float, y: np.ndarray,
    times: np.ndarray, reached: int, states: np.ndarray,
) -> Landing:  # fmt: skip
    """Integrate from (t, y) until the pose is regular again, filling the outputs on the way."""
    now, own = y.copy(), leg.progress(t)
    system.project(t, now, options.projection_tolerance)
    for _ in range(MOST_STEPS):
        one_more = options._replace(max_steps=int(own.steps) + 1)
        went = _dop853(system, one_more, own, now, np.array([float(own.t), *times[reached:]]))
        for state in went.states[1 : went.reached]:
            states[reached] = state
            reached += 1
        failed = went.status not in (Status.SUCCESS, Status.TOO_MANY_STEPS)
        if failed or reached == len(times) or not is_near_singular(system, float(own.t), now):
            break
    run.carried += own.t - t
    run.near_singular += own.near_singular
    run.steps += own.steps
    run.rejected += own.rejected
    run.rhs_calls += own.rhs_calls
    return Landing(float(own.t), now, reached, went if failed else None)


def carried_past(
    chunk: Callable[[leg.Outputs], int], system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray,
    times: np.ndarray,
) -> leg.Leg:  # fmt: skip
    """Call a compiled loop as `leg.run_chunks` does; where it ends with NEAR_SINGULAR, leap and go on.

    Where DOP853 fails in that, the leg has its status and message.
    """
    failed: leg.Leg | None = None

    def carried(outputs: leg.Outputs) -> int:
        nonlocal failed
        code, reached = chunk(outputs), int(run.next_output)
        if code != leg.NEAR_SINGULAR:
            return code
        landing = leap(system, options, run, float(run.t), y, outputs.times, reached, outputs.states)
        y[:] = landing.y
        run.t, run.next_output, run.h, failed = landing.t, landing.reached, 0.0, landing.failed
        if failed is not None:
            return leg.STEP_TOO_SMALL
        return leg.DONE if landing.reached == len(outputs.times) else leg.RUNNING

    ended = leg.run_chunks(carried, options, run, y, times)
    return replace(ended, status=failed.status, message=failed.message) if failed else ended
