"""The events of a scene: contacts, then tension-only springs, then declared events, three functions each.

All are positive while the frozen modes hold. Each holds a little beyond its root, by `noise`, or contacts at
rest exactly at d = 0 would chatter.
"""

from __future__ import annotations

from mbs_ref.kernels.contact.laws import ROOTS_EACH
from mbs_ref.kernels.contact.modes import ENDLESS, SETTLED, STOP, is_broken, is_endless
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.contact_events import contact_roots, contact_transition, start_contacts
from mbs_ref.kernels.rigid.geometry import load_state
from mbs_ref.kernels.rigid.model import contact_modes_of, watches_of
from mbs_ref.kernels.rigid.springs import spring_roots, spring_transition, start_springs
from mbs_ref.kernels.rigid.watch_events import start_watches, watch_roots, watch_transition


@jit
def rigid_root_count(model):
    """Return the number of event functions; 0 in the plain mode."""
    return contact_modes_of(model).roots[0]


@jit
def rigid_roots(model, work, t, y, g, rate):
    """Fill g and, where known, its rate, else 0; g > 0 while the frozen modes hold."""
    contact_roots(model, work, t, y, g, rate)
    spring_roots(model, work, g, rate)
    watch_roots(model, work, g, rate)


@jit
def rigid_transition(model, work, t, span, y, g, dy):
    """Change the modes whose functions are negative, with impulses where rigid; return code and source.

    dy is scratch of y's shape. y changes as in `contact_transition`.
    """
    modes = contact_modes_of(model)
    source = 0
    for k in range(modes.mode.shape[0]):
        if is_broken(g, k):
            source = k
            if is_endless(modes, k, t, span):
                return ENDLESS, k
    contact_transition(model, work, t, y, g, dy)
    spring_transition(model, g)
    stops = watch_transition(model, g)
    _log(modes, t, g)
    return STOP if stops else SETTLED, source


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


@jit
def rigid_start_modes(model, work, t, y, located):
    """Set every mode by the state; event functions are watched only where `located`."""
    modes = contact_modes_of(model)
    modes.logged[0] = 0
    modes.roots[0] = ROOTS_EACH * modes.mode.shape[0] if located else 0
    for k in range(modes.mode.shape[0]):
        modes.stamp[k] = -1e300
        modes.burst[k] = 0
    load_state(model, work, y)
    start_springs(model, work, located)
    if watches_of(model).a.shape[0] > 0:
        start_watches(model, work)
    start_contacts(model, work, t, y, located)
