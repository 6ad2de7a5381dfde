"""Did a run pass close to a singular pose? Its output samples are looked at after the run; the loop is not slowed.

A pass between two samples is seen as far as they see it: finer output sees more.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.run.diagnosis import independent_rows, smallest_singular_value, weakest_joints

NEAR = 0.05  # of the smallest singular value at the start: roundoff in reactions is 20 times what it was there
SUSPECT = 0.05  # relative closure pivot below which singular values are looked at: pivots go as their squares
MOST_LOOKS = 200  # samples looked at, evenly, at the cost of a right-hand side each
MOST_CLOSE = 5  # of them whose singular values are taken: the smallest pivots


def singular_passage(system: System, times: np.ndarray, states: np.ndarray) -> tuple[str, ...]:
    """Return a note on the sample (n_t of them) where C_q comes closest to losing rank, or nothing."""
    if system.n_closure_rows == 0 or not len(times):
        return ()
    looks = np.unique(np.linspace(0, len(times) - 1, MOST_LOOKS).round().astype(int))
    pivots = np.array([_pivot(system, float(times[k]), states[k]) for k in looks])
    close = [looks[k] for k in np.argsort(pivots)[:MOST_CLOSE] if pivots[k] < SUSPECT]
    independent = independent_rows(system) if close else 0
    if not independent:
        return ()
    values = [smallest_singular_value(system, float(times[k]), states[k], independent) for k in close]
    smallest, place = min(zip(values, close, strict=True))
    start = smallest_singular_value(system, 0.0, states[0], independent)
    if smallest > NEAR * start:
        return ()
    t = float(times[place])
    _, joints = weakest_joints(system, t, states[place])
    names = ", ".join(repr(name) for name in joints)
    return (
        f"the run passes close to a singular pose at t = {t:.6g} s: the smallest singular value of C_q is "
        f"{smallest:.2g} there and {start:.2g} at the start, from joint {names}; branches may meet there",
    )


def _pivot(system: System, t: float, y: np.ndarray) -> float:
    """Return the smallest accepted closure pivot (relative) of the modes that held at t."""
    system.set_mode_time(t)
    system.recall_modes(t)
    with np.errstate(all="ignore"):
        system.derivative(t, y)
    return system.regularity()
