"""Cosine and sine of an angle, of a float or of lanes.

In lanes the angle is brought within pi/4 by multiples of pi/2 that are subtracted in three parts (W. J. Cody,
W. Waite, Software Manual for the Elementary Functions, 1980, ch. 8), then both are polynomials: those of FreeBSD's
k_sin.c and k_cos.c (Sun Microsystems, 1993), whose error is below 2^-58. Up to 1e5 rad both are within 2^-52 of the
truth; beyond, what is lost grows with the angle.
"""

from typing import Any

import numpy as np
from numba.extending import overload

from mbs_ref.kernels.algebra.lanes import Lanes, nearest_in_lanes, turned_by_quarters
from mbs_ref.kernels.jit import bare

QUARTERS = 2.0 / np.pi
# pi/2 in three parts: the first two have 33 bits, so that up to 2^20 multiples of them are exact
QUARTER = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
SINE = (-1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
        2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10)  # fmt: skip
COSINE = (4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
          -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11)  # fmt: skip


def cos_sin(angle: Any) -> Any:
    """Return cosine and sine of an angle (rad)."""
    raise NotImplementedError("of compiled code alone")


@overload(cos_sin, inline="always")
def _cos_sin(angle):
    if isinstance(angle, Lanes):
        return _in_lanes
    return lambda angle: (np.cos(angle), np.sin(angle))


def _in_lanes(angle):
    return lanes_cos_sin(angle)


@bare
def lanes_cos_sin(angle):
    quarters = nearest_in_lanes(angle * QUARTERS)
    r = ((angle - quarters * QUARTER[0]) - quarters * QUARTER[1]) - quarters * QUARTER[2]
    z = r * r
    s = SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5]))
    c = COSINE[2] + z * (COSINE[3] + z * (COSINE[4] + z * COSINE[5]))
    sine = r + r * z * (SINE[0] + z * (SINE[1] + z * s))
    cosine = (1.0 - 0.5 * z) + z * z * (COSINE[0] + z * (COSINE[1] + z * c))
    return turned_by_quarters(quarters, sine, cosine)
