"""Declared events: a coordinate, a rate or a distance crosses its value. The mode is the side it is on."""

from __future__ import annotations

from mbs_ref.kernels.contact.laws import ROOTS_EACH
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.geometry import coordinate
from mbs_ref.kernels.rigid.model import WATCH_DISTANCE, WATCH_RATE, contact_modes_of, watches_of
from mbs_ref.kernels.rigid.springs import distance


@jit
def _watched(watches, work, k):
    """Return the quantity above its value, and its rate where known, else 0."""
    a = watches.a[k]
    if watches.quantity[k] == WATCH_DISTANCE:
        place, rate = distance(work, a, watches.b[k], watches.point_a[k], watches.point_b[k])
    else:
        place, rate = coordinate(work, a, watches.component[k])
        if watches.quantity[k] == WATCH_RATE:
            place, rate = rate, 0.0
    return place - watches.value[k], rate


@jit
def watch_roots(model, work, g, rate):
    """Fill the functions at the state in `work`."""
    watches, modes = watches_of(model), contact_modes_of(model)
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        i = ROOTS_EACH * (first + k)
        side = modes.mode[first + k]
        above, speed = _watched(watches, work, k)
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
                g[i] = 0.0  # of the other direction, so not logged
            elif watches.stops[k] == 1:
                stops = True
    return stops


@jit
def start_watches(model, work):
    """Choose the sides by the state in `work`; exactly at the value, the side that it comes from."""
    watches, modes = watches_of(model), contact_modes_of(model)
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        above, speed = _watched(watches, work, k)
        modes.mode[first + k] = 1 if above > 0.0 or (above == 0.0 and speed < 0.0) else -1
