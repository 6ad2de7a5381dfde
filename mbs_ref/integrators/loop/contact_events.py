"""Event location on an interpolant, for methods that step in someone else's code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mbs_ref.integrators.loop.events import AT_NEW, EVENT, H_NEXT, RATE_NEW, RETRY, event_tables, settle, watch
from mbs_ref.integrators.loop.leg import RUNNING, Options, Progress
from mbs_ref.kernels import answers as core

if TYPE_CHECKING:
    from mbs_ref.cores.system import System


class ContactEvents:
    """Watches the event functions of a system along the steps of a multistep code."""

    def __init__(self, system: System, options: Options, run: Progress) -> None:
        self.system, self.most, self.run = system, options.max_events, run
        self.search, self.table = event_tables(system.model)
        self.count, self.found = self.table.shape[1], False

    def settle(self, t: float, y: np.ndarray) -> int:
        """Change modes, and y at impacts, until all hold; return RUNNING, STOP_EVENT or ENDLESS_EVENTS."""
        if not self.count:
            return RUNNING
        return settle(self.system.model, self.system.work, t, y, self.table, self.run, self.most)

    def values(self, t: float, y: np.ndarray, out: np.ndarray) -> None:
        """Fill `out` with the event functions, for a code with a root finder of its own."""
        state = np.ascontiguousarray(y)
        core.call_roots(self.system.model, self.system.work, t, state, self.table[AT_NEW], self.table[RATE_NEW])
        out[:] = self.table[AT_NEW]

    def locate(self, before: float, solver: Any) -> tuple[float, np.ndarray]:
        """Return where the last step ends: at its end, or just past its first event (then `found`)."""
        self.found = False
        if not self.count:
            return solver.t, solver.y
        interpolant, start, t, y = None, before, solver.t, solver.y
        while True:
            verdict = watch(
                self.system.model, self.system.work, start, t - start, np.ascontiguousarray(y), self.search, self.table
            )
            self.found = verdict == EVENT
            if self.found or (verdict != RETRY and t >= solver.t):
                return t, np.ascontiguousarray(y)
            if verdict == RETRY:
                t = start + self.search[H_NEXT]
            else:  # a look inside the step has shown nothing: go on to its end
                start, t = t, solver.t
            interpolant = interpolant or solver.dense_output()
            y = solver.y if t >= solver.t else interpolant(t)
