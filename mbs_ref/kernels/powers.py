"""Power iteration with the derivative of dy/dt, by differences (Sommeijer, Shampine, Verwer 1998, sec. 3.2)."""

import math

import numpy as np

from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import entry

NUDGE = 1e-6  # of the state's units: difference step


@entry
def growth_of_powers(model, work, y, units, direction, growth):
    """Fill `growth` (n,) with |J x| / |x| of successive powers of J at (t = 0, y), from x = `direction` on.

    J is over the `units` (n_state,) of the state. The `growth` is 0 from where a power is 0 or not finite.
    """
    slope, image, nudged = np.empty_like(y), np.empty_like(y), np.empty_like(y)
    derivative(model, work, 0.0, y, slope)
    length = math.sqrt(np.sum(direction**2))
    growth[:] = 0.0
    for k in range(len(growth)):
        if not 0.0 < length < np.inf:
            return
        before = length
        for i in range(len(y)):
            nudged[i] = y[i] + NUDGE / before * direction[i] * units[i]
        derivative(model, work, 0.0, nudged, image)
        length = 0.0
        for i in range(len(y)):
            direction[i] = (image[i] - slope[i]) / units[i] * (before / NUDGE)
            length += direction[i] ** 2
        length = math.sqrt(length)
        growth[k] = length / before
