"""How far a Taylor series is from the equations of motion that another formulation states."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from mbs_ref.cores.series import expansion_of
from mbs_ref.cores.system import System


def defect(kernel: ModuleType, system: System, y: np.ndarray, order: int, h: float) -> float:
    """Return the largest difference of the slope at h (s) from the system's, by series from y that `kernel` expands."""
    series = expansion_of(system).series
    there, slope = np.empty((2, len(y)))
    kernel.start_at(series, y, 1e-9)
    kernel.expand(series, order)
    kernel.evaluate(series, order, h, there, slope)
    return float(np.abs(slope - system.derivative(0.0, there)).max())
