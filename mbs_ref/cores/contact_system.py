"""What compiled scenes with contact answer, in the plane and in space."""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.event_arrays import event_sources
from mbs_ref.cores.system import System
from mbs_ref.kernels import answers as core


class ContactSystem(System):
    """A system whose `groups` hold contact laws, modes and the list of near pairs."""

    def start_contacts(self, t: float, y: np.ndarray, located: bool) -> None:
        super().start_contacts(t, y, located)
        self._first_modes = [values.copy() for values in self._frozen]
        self._recalled = -1  # events of the log that the modes reflect once they are recalled

    @property
    def _frozen(self) -> tuple[np.ndarray, ...]:
        """What an event changes, in the order of the log's columns."""
        modes = self.groups.contact_modes
        return modes.mode, modes.grip, modes.anchor, modes.dashpot

    @property
    def event_sources(self) -> tuple[str, ...]:
        return tuple(event_sources(self.scene))

    def contact_events(self) -> np.ndarray:
        """Return time (s) and place in `event_sources` (n_events, 2) of the events located so far."""
        modes = self.groups.contact_modes
        return modes.log[: modes.logged[0], :2].copy()

    def contact_oscillators(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return k W (1/s^2) and c W (1/s) of each contact (n, 2), W its normal mobility; c = 0 where F ~ d d'."""
        laws = self.groups.contact_laws
        count = len(laws.stiffness)
        mobility = [core.call_contact_mobility(self.model, self.work, float(t), y, k) for k in range(count)]
        steady = np.where(laws.damping_exponent == 0.0, laws.damping, 0.0)
        linear = np.where(laws.exponent == 1.0, laws.stiffness, 0.0)
        return np.array(mobility)[:, None] * np.column_stack((linear, steady))

    def recall_modes(self, t: float) -> None:
        """Set every contact's mode to the one that held at t (s) in the last run; quickest in the order of time."""
        modes = self.groups.contact_modes
        if not modes.roots[0]:
            return
        log = modes.log[: modes.logged[0]]
        if self._recalled < 0 or (self._recalled and log[self._recalled - 1, 0] > t):
            self._recalled = 0
            for values, first in zip(self._frozen, self._first_modes, strict=True):
                values[:] = first
        end = int(np.searchsorted(log[:, 0], t, side="right"))
        for row in log[self._recalled : end]:
            column = 2
            for values in self._frozen:
                width = values[0].size
                values[int(row[1])] = row[column : column + width].reshape(values.shape[1:])
                column += width
        self._recalled = end
        self.groups.near_pairs.stale[0] = 1

    def contact_forces(self, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return for each contact depth (m), force on body_a (N) and its point (m), world axes: (n_t, 5 or 7).

        The modes of each time are replayed from the log of events, so the states must be the last run's.
        """
        self.prepare(core.REPORT)
        forces = np.zeros((len(times), len(self.scene.contacts), 1 + 2 * self.scene.dimension))
        for place, (t, y) in enumerate(zip(times, states, strict=True)):
            self.recall_modes(t)
            core.call_contact_forces(self.model, self.work, float(t), y, forces[place])
        return {part.name: forces[:, k] for k, part in enumerate(self.scene.contacts)}
