"""Declared events: a coordinate, a rate or a distance crosses its value. The mode is the side it is on."""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.contact.laws import ROOTS_EACH
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.marks import separation
from mbs_ref.kernels.planar.model import (
    WATCH_DISTANCE,
    WATCH_RATE,
    contact_modes_of,
    kinematics_of,
    watches_of,
)
from mbs_ref.kernels.planar.vectors import dot


@jit
def _watched(watches, kin, k):
    """Return the quantity above its value, and its rate where known, else 0."""
    a = watches.a[k]
    if watches.quantity[k] == WATCH_DISTANCE:
        apart = separation(kin, a, watches.b[k], watches.point_a[k], watches.point_b[k])
        length = np.sqrt(dot(apart.gap, apart.gap))
        rate = dot(apart.gap, apart.rate) / length if length > 0.0 else 0.0
        return length - watches.value[k], rate
    component = watches.component[k]
    if watches.quantity[k] == WATCH_RATE:
        return kin.motion[a, component] - watches.value[k], 0.0
    place = kin.motion[a, 3] if component == 2 else kin.pose[a, component]
    return place - watches.value[k], kin.motion[a, component]


@jit
def watch_roots(model, work, g, rate):
    """Fill the functions at the state in `work`."""
    watches, kin, modes = watches_of(model), kinematics_of(work), contact_modes_of(model)
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        i = ROOTS_EACH * (first + k)
        side = modes.mode[first + k]
        above, speed = _watched(watches, kin, k)
        g[i] = side * above / modes.noise[0] + 1.0
        rate[i] = side * speed / modes.noise[0]
        for extra in (i + 1, i + 2):
            g[extra] = 1.0
            rate[extra] = 0.0


@jit
def watch_transition(model, g):
    """Change sides; forget crossings in the other direction; return whether the run is to stop."""
    watches, modes = watches_of(model), contact_modes_of(model)
    first = modes.mode.shape[0] - watches.a.shape[0]
    stops = False
    for k in range(watches.a.shape[0]):
        i = ROOTS_EACH * (first + k)
        if g[i] < 0.0:
            modes.mode[first + k] *= -1
            if watches.direction[k] * modes.mode[first + k] < 0:
                g[i] = 0.0  # not asked for, so not logged
            elif watches.stops[k] == 1:
                stops = True
    return stops


@jit
def start_watches(model, work):
    """Choose the sides by the state in `work`; exactly at the value, the side that it comes from."""
    watches, kin, modes = watches_of(model), kinematics_of(work), contact_modes_of(model)
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        above, speed = _watched(watches, kin, k)
        modes.mode[first + k] = 1 if above > 0.0 or (above == 0.0 and speed < 0.0) else -1
