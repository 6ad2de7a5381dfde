"""Springs that only pull: where they go slack is an event, and where their damper would push.

Open is slack; closed pulls; lifted is stretched, but its damper outweighs the spring and it gives nothing.
"""

from __future__ import annotations

from mbs_ref.kernels.contact.laws import MODE_CLOSED, MODE_LIFTED, MODE_OPEN, MODE_PLAIN, ROOTS_EACH
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.geometry import distance
from mbs_ref.kernels.rigid.model import contact_modes_of, springs_of


@jit
def is_slack(modes, place, stretch, tension):
    """Return whether the spring of this place among the modes gives no force; -1 is that of one that may push.

    It is slack by its frozen mode, or by the state where events are not located.
    """
    if place < 0:
        return False
    if modes.mode[place] == MODE_PLAIN:
        return stretch <= 0.0 or tension < 0.0
    return modes.mode[place] != MODE_CLOSED


@jit
def _pull(spring, work, k):
    """Return stretch, its rate, and the tension without any clipping."""
    length, rate = distance(work, spring.a[k], spring.b[k], spring.point_a[k], spring.point_b[k])
    stretch = length - spring.rest_length[k]
    return stretch, rate, spring.stiffness[k] * stretch + spring.damping[k] * rate


@jit
def spring_roots(model, work, g, rate):
    """Fill the functions of the tension-only springs at the state in `work`."""
    spring, modes = springs_of(model), contact_modes_of(model)
    noise = modes.noise[0]
    for k in range(spring.place.shape[0]):
        if spring.place[k] < 0:
            continue
        i = ROOTS_EACH * spring.place[k]
        mode = modes.mode[spring.place[k]]
        stretch, speed, tension = _pull(spring, work, k)
        slack = noise * (spring.stiffness[k] + spring.damping[k])
        g[i + 1] = 1.0
        g[i + 2] = 1.0
        rate[i + 1] = 0.0
        rate[i + 2] = 0.0
        if mode == MODE_OPEN:
            g[i] = 1.0 - stretch / noise
            rate[i] = -speed / noise
        else:
            g[i] = stretch / noise + 1.0
            rate[i] = speed / noise
            if spring.damping[k] > 0.0:
                g[i + 1] = (tension if mode == MODE_CLOSED else -tension) / slack + 1.0


@jit
def spring_transition(model, g):
    """Change the modes whose functions are negative."""
    spring, modes = springs_of(model), contact_modes_of(model)
    for k in range(spring.place.shape[0]):
        place = spring.place[k]
        if place < 0:
            continue
        i = ROOTS_EACH * place
        if g[i] < 0.0:
            modes.mode[place] = MODE_CLOSED if modes.mode[place] == MODE_OPEN else MODE_OPEN
        elif g[i + 1] < 0.0:
            modes.mode[place] = MODE_LIFTED if modes.mode[place] == MODE_CLOSED else MODE_CLOSED


@jit
def start_springs(model, work, located):
    """Set the modes by the state in `work`; a stretch within its roundoff is none."""
    spring, modes = springs_of(model), contact_modes_of(model)
    for k in range(spring.place.shape[0]):
        place = spring.place[k]
        if place < 0:
            continue
        stretch, _, tension = _pull(spring, work, k)
        if not located:
            modes.mode[place] = MODE_PLAIN
        elif stretch <= modes.noise[0]:
            modes.mode[place] = MODE_OPEN
        else:
            modes.mode[place] = MODE_LIFTED if tension < 0.0 else MODE_CLOSED
