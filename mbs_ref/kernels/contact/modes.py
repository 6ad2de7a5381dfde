"""When a contact's mode ends and which one follows: the part that does not depend on shapes.

Four functions a contact, all positive while its mode holds: the gap's, the force's, friction's and that of open ends. A
function that is the smaller of two would hide a short dip of the larger one. Each mode holds a little beyond its root,
by its roundoff, or contacts at rest exactly at d = 0 would chatter: that of a gap or a speed is `noise`, that of a
force what the noise makes of it. Functions are in units of their roundoff.
"""

from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.jit import bare, jit

SETTLED, ENDLESS, STOP = range(3)
AT_ONCE = 1e-9  # of the leg: events of one contact closer than this form a burst ...
LONGEST_BURST = 60  # ... and a burst longer than this is endless
NOTHING, IMPACT, TOUCH, FRICTION = range(4)  # what a change of mode leaves for the core to do


@bare
def normal_roots(laws, modes, k, gap, closing, beyond, leaving, speed, table):
    """Fill the functions of contact k's gap and force, and while it is open, of its ends; the others stay 1.

    `closing` and `leaving` are the rates (m/s) of the gap and of the excess `beyond` open ends, `speed` bounds both.
    """
    g, rate = table[law.VALUE], table[law.RATE]
    i = law.ROOTS_EACH * k
    noise = modes.noise[0]
    mode = modes.mode[k]
    table[law.SPEED, i] = speed / noise
    if mode == law.MODE_OPEN:
        g[i] = max(gap, beyond) / noise + 1.0 + modes.lag[k]
        rate[i] = (closing if gap >= beyond else leaving) / noise
        return
    g[i] = (1.0 if mode in (law.MODE_CLOSED, law.MODE_LIFTED) else 0.0) - gap / noise
    rate[i] = -closing / noise
    if mode == law.MODE_CLOSED and laws.release[k] == law.RELEASE_FORCE:
        g[i + 1] = _push(laws, modes, k, gap, closing) + 1.0
    elif mode == law.MODE_LIFTED:
        g[i + 1] = 1.0 - _push(laws, modes, k, gap, closing)
    elif mode == law.MODE_LEAVING:
        g[i + 1] = closing / modes.noise[1] + 1.0
    else:
        return
    table[law.SPEED, i + 1] = law.UNKNOWN


@bare
def _push(laws, modes, k, gap, closing):
    """Return the normal force in units of its roundoff."""
    slack = modes.noise[0] * laws.stiffness[k] + modes.noise[1] * modes.dashpot[k]
    return law.normal_force(laws, modes, k, -gap, -closing) / slack


@bare
def is_broken(g, k):
    """Return whether a function of contact k is negative."""
    i = law.ROOTS_EACH * k
    return g[i] < 0.0 or g[i + 1] < 0.0 or g[i + 2] < 0.0 or g[i + law.ENDS] < 0.0


@jit
def is_endless(modes, k, t, span):
    """Count the event at t (s) into the contact's burst; return whether it is longer than any real one."""
    modes.burst[k] = modes.burst[k] + 1 if t - modes.stamp[k] < AT_ONCE * span else 0
    modes.stamp[k] = t
    return modes.burst[k] > LONGEST_BURST


@jit
def close(laws, modes, k, speed):
    """Touch down at a closing speed (m/s): it sets the dashpot of the laws that know it."""
    modes.mode[k] = law.MODE_CLOSED
    modes.dashpot[k] = laws.damping[k]
    if laws.impact_damping[k] != 0.0:
        modes.dashpot[k] += laws.impact_damping[k] * laws.stiffness[k] / max(speed, laws.slowest[k])


@jit
def next_mode(laws, modes, k, g, closing, behind):
    """Change the mode of a contact that has a negative function; return what is left to do."""
    i = law.ROOTS_EACH * k
    mode = modes.mode[k]
    has_left = g[i] < 0.0 or g[i + law.ENDS] < 0.0
    if mode == law.MODE_OPEN or (mode == law.MODE_LEAVING and not has_left):
        if behind:
            modes.mode[k] = law.MODE_BEHIND
            return NOTHING
        if laws.release[k] == law.RELEASE_RIGID:
            modes.mode[k] = law.MODE_LEAVING
            return IMPACT
        if laws.release[k] == law.RELEASE_CONSTRAINT:
            modes.mode[k] = law.MODE_CLOSED
            return NOTHING
        close(laws, modes, k, max(-closing, 0.0))
        return TOUCH
    if has_left or laws.release[k] == law.RELEASE_CONSTRAINT:
        modes.mode[k] = law.MODE_OPEN
    elif g[i + 1] < 0.0:
        modes.mode[k] = law.MODE_CLOSED if mode == law.MODE_LIFTED else law.MODE_LIFTED
    else:
        return FRICTION
    return NOTHING
