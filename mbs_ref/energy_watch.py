"""Did energy stay where nothing takes it? What a finished run lost of it tells how far its phase may be off.

A relative error of the energy changes a frequency by as much (an orbit's by 3/2 of it, by Kepler's third law), and the
phase by that times the angle gone through. A step of an adaptive method goes through a radian at most.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.observables.energy import energy_balance, kinetic_energy
from mbs_ref.system import System
from mbs_ref.trajectory import Trajectory


def phase_error(system: System, times: np.ndarray, states: np.ndarray, steps: int) -> float:
    """Return the estimate, rad, from the samples of a run; 0 where work is done, and energy need not stay.

    Energy is measured by the median of the kinetic energy: the largest would belong to the closest pass alone.
    """
    path = Trajectory(times=times, **system.poses(states)._asdict())
    balance = energy_balance(system.scene, path)
    if balance.drift is None or balance.work is None or np.any(balance.work):
        return 0.0
    usual = float(np.median(kinetic_energy(system.scene, path)))
    lost = float(np.max(np.abs(balance.drift)))
    return steps * lost / usual if usual > 0.0 else 0.0
