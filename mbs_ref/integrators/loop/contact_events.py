"""Event location on an interpolant, for methods that step in someone else's code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mbs_ref.integrators.loop.leg import (
    ENDLESS_EVENTS,
    RUNNING,
    STOP_EVENT,
    Options,
    Progress,
)
from mbs_ref.kernels import answers as core
from mbs_ref.kernels.contact.modes import STOP

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

MOST_ROUNDS = 200  # mode changes at one instant before they count as endless
ROUNDOFF = 4.0 * np.finfo(float).eps  # of time


class ContactEvents:
    """Watches the event functions of a system along the steps of a multistep code."""

    def __init__(self, system: System, options: Options, run: Progress) -> None:
        self.system, self.most, self.run = system, options.max_events, run
        count = core.call_root_count(system.model)
        self.g, self.rate, self.low = np.zeros((3, count))
        self.found = False

    def _roots(self, t: float, y: np.ndarray) -> np.ndarray:
        core.call_roots(self.system.model, self.system.work, t, np.ascontiguousarray(y), self.g, self.rate)
        return self.g

    def settle(self, t: float, y: np.ndarray) -> int:
        """Change modes, and y at impacts, until all hold; return RUNNING, STOP_EVENT or ENDLESS_EVENTS."""
        for _ in range(MOST_ROUNDS if len(self.g) else 0):
            broken = int(np.sum(self._roots(t, y) < 0.0))
            if broken == 0:
                self.low[:] = self.g
                return RUNNING
            self.run.events += broken
            code, contact = core.call_transition(self.system.model, self.system.work, t, y, self.g, np.empty_like(y))
            self.run.event_source = contact
            if code == STOP:
                return STOP_EVENT
            if code or self.run.events > self.most:
                break
        return ENDLESS_EVENTS if len(self.g) else RUNNING

    def gaps(self, t: float, y: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` with the event functions, for a code with a root finder of its own."""
        out[:] = self._roots(t, y)

    def locate(self, before: float, solver: Any) -> tuple[float, np.ndarray]:
        """Return where the last step ends: at its end, or just past its first event (then `found`)."""
        self.found = False
        if not len(self.g) or not np.any(self._roots(solver.t, solver.y) < 0.0):
            self.low[:] = self.g
            return solver.t, solver.y
        self.found = True
        interpolant = solver.dense_output()
        return self._bracket(before, solver.t, solver.y.copy(), self.g.copy(), interpolant)

    def _bracket(self, t0: float, t1: float, y1: np.ndarray, high: np.ndarray, interpolant: Any):
        """Narrow (t0, t1] by regula falsi, bisecting every second time, until it is roundoff of time."""
        low, turn = self.low.copy(), 0
        while t1 - t0 > ROUNDOFF * max(abs(t1), 1e-3):
            broken = high < 0.0
            share = float(np.min(low[broken] / (low[broken] - high[broken])))
            turn += 1
            if turn % 2 == 0 or not 0.0 < share < 1.0:
                share = 0.5
            t = t0 + share * (t1 - t0)
            if not t0 < t < t1:  # a root found to roundoff at t0: the far end has yet to come near
                t = 0.5 * (t0 + t1)
            y = interpolant(t)
            g = self._roots(t, y)
            if np.any(g < 0.0):
                t1, y1, high = t, y, g.copy()
            else:
                t0, low = t, g.copy()
        return t1, np.ascontiguousarray(y1)
