"""Does a fixed step resolve the motion? One step against two of half its size, from states along the run.

A fixed step promises nothing, and a run whose step is far too long looks like any other: implicit methods damp
fast motions away, explicit ones alias them. The differences of one step and two halves estimate the local error
(Hairer, Norsett, Wanner I, sec. II.4); summed over the steps they say what is left of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.integrators.loop.leg import Integrator, Options, progress

PROBES = 12  # states looked at
LOST = 0.1  # of the motion's size: an estimated error beyond leaves another motion
STILL = 1e-9  # m, rad, m/s, rad/s: a motion smaller than this is none


@dataclass(frozen=True)
class Resolution:
    """What the step leaves of the motion."""

    share: float  # estimated error of the run over the motion's size
    time: float  # s, where a single step errs most
    body: str  # which moves worst there

    @property
    def lost(self) -> bool:
        return not self.share <= LOST


def resolution(
    system: System,
    integrator: Integrator,
    options: Options,
    times: np.ndarray,
    states: np.ndarray,
    seen: np.ndarray,
) -> Resolution:
    """Estimate the error of a fixed-step run from its own samples; states `seen` besides tell how far it goes."""
    half, every = system.n_positions, np.concatenate((states, seen))
    sizes = _largest(every[:, :half] - states[0, :half]), _largest(every[:, half:])
    picks = np.unique(np.linspace(0, len(times) - 2, PROBES).round().astype(int))
    ends = np.append(times[picks[1:]], times[-1])
    total, worst, where, body = np.zeros(2), 0.0, 0.0, 0
    for k, end in zip(picks, ends, strict=True):
        t = float(times[k])
        gap = _doubled(system, integrator, options, t, states[k])
        if gap is None:
            return Resolution(np.inf, t, system.scene.bodies[0].name)
        shares = np.array([np.max(gap[:half]) / sizes[0], np.max(gap[half:]) / sizes[1]])
        total += shares * (end - t) / options.step
        if float(np.max(shares)) > worst:
            worst, where, body = float(np.max(shares)), t, _owner(system, gap, half)
    grown = 2.0**integrator.order / (2.0**integrator.order - 1.0)
    return Resolution(grown * float(np.max(total)), where, system.scene.bodies[body].name)


def _largest(values: np.ndarray) -> float:
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=STILL))


def _doubled(
    system: System, integrator: Integrator, options: Options, t: float, y: np.ndarray
) -> np.ndarray | None:
    """Return |one step - two half steps| (n_state,); None where one of them fails.

    A declared breakpoint ends a step, as it does in the run.
    """
    found = []
    end = min([t + options.step, *(b for b in system.scene.breakpoints() if b > t)])
    system.set_mode_time(0.5 * (t + end))
    with np.errstate(all="ignore"):
        for step in (end - t, 0.5 * (end - t)):
            leg = np.array([t, end])
            run = progress(t)
            done = integrator.advance(system, options._replace(step=step), run, y.copy(), leg)
            if done.reached < 2:
                return None
            found.append(done.states[1])
    gap = np.abs(found[0] - found[1])
    return gap if np.all(np.isfinite(gap)) else None


def _owner(system: System, gap: np.ndarray, half: int) -> int:
    """Return the body that the largest entry belongs to: states list the bodies one after the other."""
    n = len(system.scene.bodies)
    k = int(np.argmax(gap))
    width, place = (half // n, k) if k < half else ((len(gap) - half) // n, k - half)
    return min(place // max(width, 1), n - 1)
