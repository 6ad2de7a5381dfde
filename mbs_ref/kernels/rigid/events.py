"""The events of a scene: contacts, then tension-only springs, then declared events, four functions each.

A declared event is where a coordinate, a rate or a distance crosses its value; its mode is the side it is on.
All functions are positive while the frozen modes hold. Each holds a little beyond its root, by `noise`, or contacts at
rest exactly at d = 0 would chatter.
"""

import numpy as np

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.contact.laws import LEFT_OUT, RATE, ROOTS_EACH, SPEED, TURN, TURNED, UNKNOWN, VALUE
from mbs_ref.kernels.contact.modes import ENDLESS, SETTLED, STOP, is_broken, is_endless
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.contact_events import contact_roots, contact_transition, start_contacts
from mbs_ref.kernels.rigid.loads import distance, distance_speed, spring_roots, spring_transition, start_springs
from mbs_ref.kernels.rigid.marks import magnitude
from mbs_ref.kernels.rigid.model import WATCH_DISTANCE, WATCH_RATE


@bare
def _watched(watches, work, k):
    """Return the quantity above its value, its rate where known, else 0, and a bound on its rate."""
    a = watches.a[k]
    if watches.quantity[k] == WATCH_DISTANCE:
        b, point_a, point_b = watches.b[k], watches.point_a[k], watches.point_b[k]
        place, rate = distance(work, a, b, point_a, point_b)
        bound = distance_speed(work, a, b, point_a, point_b)
    else:
        place, rate = core.coordinate(work, a, watches.component[k])
        bound = max(magnitude(work, core.speed(work, a)), abs(rate))
        if watches.quantity[k] == WATCH_RATE:
            place, rate, bound = rate, 0.0, UNKNOWN
    return place - watches.value[k], rate, bound


@bare
def watch_roots(model, work, table):
    """Fill the functions at the state in `work`."""
    watches, modes = model.watches, model.contact_modes
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        i = ROOTS_EACH * (first + k)
        if table[SPEED, i] == LEFT_OUT:
            continue
        side = modes.mode[first + k]
        above, speed, bound = _watched(watches, work, k)
        table[VALUE, i] = side * above / watches.noise[k] + 1.0
        table[RATE, i] = side * speed / watches.noise[k]
        table[SPEED, i] = bound / watches.noise[k] if bound != UNKNOWN else UNKNOWN
        table[TURN, i] = core.spin(work, watches.a[k])
        if watches.quantity[k] == WATCH_DISTANCE:
            table[TURN, i] += core.spin(work, watches.b[k])


@jit
def watch_transition(model, g):
    """Change sides; forget crossings in the other direction; return whether the run is to stop."""
    watches, modes = model.watches, model.contact_modes
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
    watches, modes = model.watches, model.contact_modes
    first = modes.mode.shape[0] - watches.a.shape[0]
    for k in range(watches.a.shape[0]):
        above, speed, _ = _watched(watches, work, k)
        modes.mode[first + k] = 1 if above > 0.0 or (above == 0.0 and speed < 0.0) else -1


rigid_root_count = jit(lambda model: model.contact_modes.roots[0])


@bare
def rigid_roots(model, work, t, y, duration, table):
    for i in range(table.shape[1]):
        table[VALUE, i], table[RATE, i], table[TURN, i] = 1.0, 0.0, 0.0
        if table[SPEED, i] != LEFT_OUT:
            table[SPEED, i] = 0.0
    is_new = contact_roots(model, work, t, y, duration, table)
    ask.switch_roots(model, work, table)
    return is_new


@bare
def rigid_switch_roots(model, work, table):
    spring_roots(model, work, table)
    watch_roots(model, work, table)


@jit
def rigid_transition(model, work, t, span, y, g, dy):
    """Change the modes whose functions are negative, with impulses where rigid; return code and source.

    dy is scratch of y's shape. y changes as in `contact_transition`.
    """
    modes = model.contact_modes
    source = 0
    for k in range(modes.mode.shape[0]):
        if is_broken(g, k):
            source = k
            if is_endless(modes, k, t, span):
                return ENDLESS, k
    contact_transition(model, work, t, y, g, dy)
    stops = ask.switch_transition(model, g)
    _log(modes, t, g)
    return STOP if stops else SETTLED, source


@jit
def rigid_switch_transition(model, g):
    spring_transition(model, g)
    return watch_transition(model, g)


@jit
def _log(modes, t, g):
    for k in range(modes.mode.shape[0]):
        if is_broken(g, k):
            place = modes.logged[0]
            modes.logged[0] += 1
            if place < modes.log.shape[0]:
                row = modes.log[place]
                row[0] = t
                row[1] = k
                row[2] = modes.mode[k]
                row[3] = modes.grip[k]
                for c in range(modes.anchor.shape[1]):
                    row[4 + c] = modes.anchor[k, c]
                row[4 + modes.anchor.shape[1]] = modes.dashpot[k]
                is_event = g[ROOTS_EACH * k + 2] != TURNED
                row[5 + modes.anchor.shape[1]] = max(t, modes.stamp[k]) if is_event else np.nan


@jit
def rigid_start_modes(model, work, t, y, located):
    """Set every mode by the state; event functions are watched only where `located`."""
    modes = model.contact_modes
    modes.logged[0] = 0
    modes.roots[0] = ROOTS_EACH * modes.mode.shape[0] if located else 0
    for k in range(modes.mode.shape[0]):
        modes.stamp[k] = -1e300
        modes.burst[k] = 0
    core.load_state(model, work, y)
    ask.start_switches(model, work, located)
    start_contacts(model, work, t, y, located)


@jit
def rigid_start_switches(model, work, located):
    start_springs(model, work, located)
    if model.watches.a.shape[0] > 0:
        start_watches(model, work)
