"""Detect a passage close to a singular pose from the output samples, after the run.

A passage between two samples is detected only as far as they show it: finer output detects more.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.simulate.diagnosis import independent_rows, smallest_singular_value, weakest_joints

NEAR = 0.05  # of the smallest singular value at the start: roundoff in reactions is 20 times what it was there
SUSPECT = 0.05  # relative closure pivot below which singular values are computed; pivots scale as their squares
MAX_SAMPLES = 200  # evenly spaced samples that are examined, one right-hand side each
MAX_CLOSE = 5  # samples with the smallest pivots, whose singular values are computed


def singular_passage(system: System, times: np.ndarray, states: np.ndarray) -> tuple[str, ...]:
    """Return a note on the sample (n_t of them) where C_q is nearest to rank loss, or nothing."""
    if system.n_closure_rows == 0 or not len(times):
        return ()
    examined = np.unique(np.linspace(0, len(times) - 1, MAX_SAMPLES).round().astype(int))
    pivots = np.array([_pivot(system, float(times[k]), states[k]) for k in examined])
    close = [examined[k] for k in np.argsort(pivots)[:MAX_CLOSE] if pivots[k] < SUSPECT]
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
    """Return the smallest accepted closure pivot (relative) of the contact modes at t."""
    system.set_mode_time(t)
    system.recall_modes(t)
    with np.errstate(all="ignore"):
        system.derivative(t, y)
    return system.regularity()
