"""How a run ended: what the engine's loop left, what its numbers say of it, and the trajectory made of them."""

from dataclasses import dataclass

import numpy as np

from mbs_ref.scene import Scene
from mbs_ref.trajectory import Status, Trajectory


def stopped(scene: Scene, status: Status, message: str) -> Trajectory:
    """Return a trajectory without samples."""
    return Trajectory.empty(len(scene.bodies), scene.dimension, status, message)


@dataclass(frozen=True)
class End:
    """How the engine's loop ended: how many samples it vouches for, and why it stopped there."""

    samples: int
    status: Status = Status.SUCCESS
    message: str = ""
    unreported: bool = False  # the engine itself did not complain


@dataclass(frozen=True)
class Loop:
    """What the engine's loop left: its states at the output times, its end and what it counted."""

    states: np.ndarray  # (n_t, n) one row an output time, in the engine's own terms
    end: End
    steps: int = 0
    rhs_calls: int = 0
    rejected_steps: int = 0


def end_of(states: np.ndarray, times: np.ndarray, end: End) -> End:
    """Return the end, moved ahead to the first sample (row of `states`) that is not finite."""
    finite = np.isfinite(states[: end.samples]).all(axis=1)
    good = end.samples if finite.all() else int(np.argmin(finite))
    if good == end.samples:
        return end
    last = f"the last finite sample is at t = {times[good - 1]:g} s" if good else "no sample is finite"
    cause = f" ({end.message})" if end.message else ""
    silent = end.status in (Status.SUCCESS, Status.RESET)
    return End(good, Status.NON_FINITE, f"NaN or infinity arose before t = {times[good]:g} s; {last}{cause}", silent)
