"""How far may a run be off? A companion run that errs less tells, as Richardson (1911) and Roache (1994) have it.

The companion takes half of a fixed step, or a tenth of the tolerances. If its errors are k times smaller, the two runs
differ by d = e (1 - 1/k), and the run errs by e = d k / (k - 1) (Hairer, Norsett, Wanner I, eq. II.4.4): k = 2^p at
order p, 2 where impacts and kinks leave order 1, and 10 if errors are in proportion to the tolerance (ibid., sec.
II.4). Two runs cannot show that they converge as they should, so SAFETY times that is said. Errors vanish by chance
alone, so the estimate never falls in time.

Where the finer companion does not end, a coarser one is made: its errors are the larger ones, and d is their size.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import System
from mbs_ref.integrators.loop.leg import COUNT_STEPS, FEWEST, Options
from mbs_ref.run.legs import EPS, Run, run_legs
from mbs_ref.run.plan import Plan
from mbs_ref.self_checks.pose_gap import coordinate_size, motion_size, pose_gap
from mbs_ref.trajectory import Estimate, Status

SAFETY = 3.0  # for two runs (P. J. Roache, J. Fluids Eng. 116 (1994) 405: the grid convergence index)
DECADE = 10.0  # between the tolerances of the two
TIGHTEST = 1e-13  # relative tolerance of a companion: some hundred EPS, beyond which roundoff decides
MORE_STEPS = 4  # times those allowed for a finer companion: the square root of ten at order 2, rounded up
ENDED = frozenset({Status.SUCCESS, Status.STOP_EVENT})


class _Companion(NamedTuple):
    """A run to compare with."""

    share: str  # of the run's step or tolerance
    options: Options
    refine: int  # parts of each step
    factor: float  # the estimate over the difference of the two


class _Compared(NamedTuple):
    """What a companion says."""

    bounds: np.ndarray  # (n,) m, the estimate at the outputs that both reached
    size: float  # m, how far it goes
    status: Status
    message: str


def estimated(system: System, plan: Plan, run: Run) -> Estimate | None:
    """Estimate the error of a run's poses at its output times; None where Ctrl-C ended a companion."""
    began = time.perf_counter()
    bounds, reached, how = np.zeros(len(run.times)), 1, []
    first = system.poses(run.states)
    scale, size = coordinate_size(system.scene, first), motion_size(system.scene, first, run.times)
    for companion in _companions(system, plan):
        found = _compared(system, plan, run, companion)
        if found.status is Status.INTERRUPTED:
            return None
        count = len(found.bounds)
        bounds[:count] = np.fmax(bounds[:count], found.bounds)
        size, reached = max(size, found.size), max(reached, count)
        how.append(_told(plan, companion, found))
        if found.status in ENDED:
            break
    bounds[reached:] = np.inf
    bounds[1:] += EPS * scale * math.sqrt(run.counts[COUNT_STEPS])  # roundoff as a random walk (Brouwer 1937)
    return Estimate(
        over_time=np.maximum.accumulate(bounds), how="; ".join(how), times=run.times, size=size,
        tolerance=plan.options.rtol * scale, cost_s=time.perf_counter() - began,
    )  # fmt: skip


def _companions(system: System, plan: Plan) -> list[_Companion]:
    """Return the finer and the coarser companion; the coarser alone where the finer would ask for less than roundoff."""
    options, most = plan.options, MORE_STEPS * plan.options.max_steps
    if options.step:
        order = 1 if system.scene.contacts or system.scene.events else plan.integrator.order
        finer = _Companion("half of the step", options._replace(max_steps=most), 2, _richardson(2.0**order))
        return [finer, _Companion("twice the step", options._replace(step=2.0 * options.step), 1, SAFETY)]
    coarser = _Companion("ten times the tolerance", _times(options, DECADE), 1, SAFETY)
    if options.rtol / DECADE < TIGHTEST:
        return [coarser]
    tighter = _times(options, 1.0 / DECADE)._replace(max_steps=most)
    return [_Companion("a tenth of the tolerance", tighter, 1, _richardson(DECADE)), coarser]


def _richardson(smaller: float) -> float:
    return SAFETY * smaller / (smaller - 1.0)


def _times(options: Options, factor: float) -> Options:
    return options._replace(rtol=factor * options.rtol, atol=factor * options.atol)


def _compared(system: System, plan: Plan, run: Run, companion: _Companion) -> _Compared:
    """Make the companion and hold the run against it."""
    other = _made(system, plan, companion, run.states[0], run.times)
    count = min(len(other.times), len(run.times))
    first, second = system.poses(run.states[:count]), system.poses(other.states[:count])
    size = motion_size(system.scene, second, other.times[:count])
    gaps = pose_gap(system.scene, first, second)
    gaps[1:] = np.fmax(gaps[1:], _opening(system, plan, run, companion))
    gaps = np.maximum.accumulate(gaps)
    # what is as large as the motion needs no safety
    bounds = np.fmax(gaps, np.minimum(companion.factor * gaps, max(size, float(np.min(gaps)))))
    return _Compared(bounds, size, other.status, other.message)


def _opening(system: System, plan: Plan, run: Run, companion: _Companion) -> float:
    """Return by how much (m) the two part in the FEWEST first steps, where fixed ones damp what they cannot follow.

    What is gone before the first output leaves no trace in the others.
    """
    step = plan.options.step
    if not step or run.times[1] <= step:
        return 0.0
    times = step * np.arange(min(FEWEST, int(run.times[1] / step)) + 1)
    same = _Companion("", plan.options, 1, 0.0)
    runs = [_made(system, plan, one, run.states[0], times) for one in (same, companion)]
    count = min(len(one.times) for one in runs)
    first, second = (system.poses(one.states[:count]) for one in runs)
    return float(np.max(pose_gap(system.scene, first, second)))


def _made(system: System, plan: Plan, companion: _Companion, start: np.ndarray, times: np.ndarray) -> Run:
    """Run the companion up to the same times, on a system of its own."""
    other, y = compile_scene(system.scene), start.copy()
    other.set_mode_time(0.0)
    other.set_baumgarte(plan.baumgarte_gain)
    other.start_contacts(0.0, y, plan.settings.events != "none")
    again = replace(plan, times=times, options=companion.options._replace(stop_on_compliance=False))
    return run_legs(other, again, y, refine=companion.refine)


def _told(plan: Plan, companion: _Companion, found: _Compared) -> str:
    said = f"{companion.factor:.3g} times the difference from a run with {companion.share}"
    return said if found.status in ENDED else f"{said}, which did not end: {found.message}"
