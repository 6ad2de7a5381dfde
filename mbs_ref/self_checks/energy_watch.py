"""Did energy stay where nothing takes it? What a finished run lost of it tells how far its phase may be off.

A relative error of the energy changes a frequency by as much (an orbit's by 3/2 of it, by Kepler's third law), and the
phase by that times the angle gone through.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.observables.energy import energy_balance, kinetic_energy
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory


class PhaseError(NamedTuple):
    """What the energy tells of the phase, rad; 0 where work is done, and energy need not stay."""

    at_most: float  # a step of an adaptive method goes through a radian at most; near a collision through far less
    about: float  # by the speeds at the samples, which know nothing of what lies between


def phase_error(system: System, times: np.ndarray, states: np.ndarray, steps: int) -> PhaseError:
    """Estimate it from the samples of a run."""
    path = Trajectory(times=times, **system.poses(states)._asdict())
    lost = _share_lost(system.scene, path)
    return PhaseError(lost * steps, lost * _angle(path) if lost > 0.0 else 0.0)


def _share_lost(scene: Scene, path: Trajectory) -> float:
    """Return the largest drift over the median kinetic energy: the largest would be that of the closest pass alone."""
    balance = energy_balance(scene, path)
    if balance.drift is None or balance.work is None or np.any(balance.work):
        return 0.0
    usual = float(np.median(kinetic_energy(scene, path)))
    return float(np.max(np.abs(balance.drift))) / usual if usual > 0.0 else 0.0


def _angle(path: Trajectory) -> float:
    """Return the angle gone through, rad: how often the motion goes through its own size, or a body turns."""
    size = float(np.max(np.abs(path.position - path.position[0])))
    speed = _usual(path.velocity) / size if size > 0.0 else 0.0
    return float(path.times[-1]) * max(speed, _usual(path.angular_velocity))


def _usual(rates: np.ndarray) -> float:
    """Return the median over time of the fastest body's rate."""
    return float(np.median(np.max(np.abs(rates.reshape(len(rates), -1)), axis=1)))
