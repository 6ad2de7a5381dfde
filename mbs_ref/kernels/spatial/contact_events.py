"""Contact modes in space: the functions whose roots end a mode, and what happens there.

Sliding keeps a frozen direction. Its function is positive while the slip velocity is within 60 degrees of it:
at the root the direction follows the slip, or, where the slip has come to a stop, the contact sticks or slides
on in the direction that its own acceleration takes.
"""

from __future__ import annotations

import math

import numpy as np

from mbs_ref.kernels.border.questions import contact_mobility, factor, fill_rows, settle_grips, solve
from mbs_ref.kernels.contact.laws import (
    FRICTION_STICK_SLIP,
    GRIP_FORWARD,
    GRIP_PROBE,
    GRIP_STICK,
    MODE_BEHIND,
    MODE_CLOSED,
    MODE_OPEN,
    MODE_PLAIN,
    RELEASE_RIGID,
    ROOTS_EACH,
    normal_force,
)
from mbs_ref.kernels.contact.modes import (
    ENDLESS,
    FRICTION,
    IMPACT,
    SETTLED,
    TOUCH,
    close,
    is_broken,
    is_endless,
    next_mode,
    normal_roots,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.stopped_contacts import holding_forces
from mbs_ref.kernels.spatial.contacts import (
    contact_force,
    contact_geometry,
    find_near,
    grip_force,
    is_behind,
    is_touching,
    leaving_ends,
    slip_along,
)
from mbs_ref.kernels.spatial.model import (
    bodies_of,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    grips_of,
    kinematics_of,
    near_pairs_of,
    rows_of,
    tree_of,
)
from mbs_ref.kernels.spatial.orientation import load_state
from mbs_ref.kernels.spatial.vectors import add, cross, dot, negative, times, triple, turn_back

COSINE = 0.5  # of the angle between slip and frozen direction at which the direction is frozen anew
TOGETHER = 10.0  # of the slip velocity that counts as a stop: so slow, a contact stops along with another one


@jit
def spatial_root_count(model):
    """Return the number of event functions; 0 in the plain mode."""
    return contact_modes_of(model).roots[0]


@jit
def spatial_roots(model, work, t, y, g, rate):
    """Fill g and, where known, its rate, else 0; g > 0 while the frozen modes hold."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    near = near_pairs_of(model)
    load_state(model, work, y)
    find_near(model, work)
    for i in range(g.shape[0]):
        g[i] = 1.0
        rate[i] = 0.0
    for place in range(near.count[0]):
        k = near.pair[place]
        touch = contact_geometry(model, work, k)
        leaving = leaving_ends(model, work, k) if touch.beyond > touch.gap else 0.0
        normal_roots(laws, modes, k, touch.gap, touch.closing, touch.beyond, leaving, g, rate)
        if modes.mode[k] == MODE_CLOSED and laws.friction[k] == FRICTION_STICK_SLIP:
            g[ROOTS_EACH * k + 2] = _grip_margin(model, work, k, touch) + 1.0


@jit
def _grip_margin(model, work, k, touch):
    """Return how much more force sticking bears, or the speed along what is frozen, in units of their roundoff."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    along, across = slip_along(touch)
    if modes.grip[k] == GRIP_STICK:
        normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
        p, q = grip_force(laws, modes, grips_of(work), contact_pairs_of(model), k, normal, along, across)
        margin = laws.static[k] * normal - math.sqrt(p * p + q * q)
        return margin / (modes.noise[0] * (laws.grip_stiffness[k] + laws.grip_damping[k]))
    ahead = modes.anchor[k, 0] * along + modes.anchor[k, 1] * across
    return (ahead - COSINE * math.sqrt(along * along + across * across)) / modes.noise[0]


@jit
def _let_go(model, y, k, p, q):
    """Set the deflection of a contact that sticks from now on, so that its spring gives the force p, q (N)."""
    pairs, laws = contact_pairs_of(model), contact_laws_of(model)
    place = y.shape[0] - 2 * pairs.sticking[0] + 2 * pairs.deflection[k]
    y[place] = -p / laws.grip_stiffness[k]
    y[place + 1] = -q / laws.grip_stiffness[k]


@jit
def _take_grip(model, y, k, touch):
    """Slide where there is a slip velocity; stick, unloaded, where there is none."""
    modes = contact_modes_of(model)
    if contact_laws_of(model).friction[k] != FRICTION_STICK_SLIP:
        return
    along, across = slip_along(touch)
    if along == 0.0 and across == 0.0:
        modes.grip[k] = GRIP_STICK
        _let_go(model, y, k, 0.0, 0.0)
    else:
        _aim(modes, k, along, across)


@jit
def _aim(modes, k, along, across):
    """Slide in a direction."""
    speed = math.sqrt(along * along + across * across)
    modes.grip[k] = GRIP_FORWARD
    modes.anchor[k, 0] = along / speed
    modes.anchor[k, 1] = across / speed


@jit
def _change_grip(model, work, k, touch):
    """End a mode of friction; return whether the contact has stopped and is to be probed."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    along, across = slip_along(touch)
    if modes.grip[k] == GRIP_STICK:
        normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
        p, q = grip_force(laws, modes, grips_of(work), contact_pairs_of(model), k, normal, along, across)
        _aim(modes, k, -p, -q)
        return False
    if math.sqrt(along * along + across * across) > modes.slow[0]:  # it turns
        _aim(modes, k, along, across)
        return False
    modes.grip[k] = GRIP_PROBE
    modes.anchor[k, 0] = 0.0
    modes.anchor[k, 1] = 0.0
    return True


@jit
def _stop_together(model, work, y, g):
    """Probe every other sliding contact that is as good as at rest: the corners of one block stop at once.

    Their functions in g turn negative, as of all that change.
    """
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    load_state(model, work, y)
    for k in range(modes.grip.shape[0]):
        closed = modes.mode[k] == MODE_CLOSED and laws.friction[k] == FRICTION_STICK_SLIP
        if not closed or modes.grip[k] != GRIP_FORWARD:
            continue
        along, across = slip_along(contact_geometry(model, work, k))
        if math.sqrt(along * along + across * across) <= TOGETHER * modes.slow[0]:
            modes.grip[k] = GRIP_PROBE
            g[ROOTS_EACH * k + 2] = -1.0


@jit
def spatial_transition(model, work, t, span, y, g, dy):
    """Change the modes whose functions are negative, with impulses where rigid; return code and contact.

    dy is scratch of y's shape. Velocities in y change at rigid impacts, deflections where a contact sticks.
    """
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    stopped = False
    for k in range(pairs.kind.shape[0]):
        if not is_broken(g, k):
            continue
        if is_endless(modes, k, t, span):
            return ENDLESS, k
        load_state(model, work, y)
        touch = contact_geometry(model, work, k)
        left = next_mode(laws, modes, k, g, touch.closing, is_behind(pairs, k, touch.gap))
        if left == IMPACT:
            _impact(model, work, t, y, k)
        elif left == TOUCH:
            _take_grip(model, y, k, touch)
        elif left == FRICTION and _change_grip(model, work, k, touch):
            stopped = True
    if stopped:
        _stop_together(model, work, y, g)
        settle_grips(model, work, t, y, dy)
    _log(modes, t, g)
    return SETTLED, 0


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
                row[4] = modes.anchor[k, 0]
                row[5] = modes.anchor[k, 1]
                row[6] = modes.dashpot[k]


@jit
def spatial_slip_velocities(model, work, y, out):
    """Fill out (n_contacts, 2) with the slip velocities (m/s) at y of the contacts under probe, along their edges."""
    pairs, modes = contact_pairs_of(model), contact_modes_of(model)
    load_state(model, work, y)
    for k in range(pairs.kind.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            out[k, 0], out[k, 1] = slip_along(contact_geometry(model, work, k))


@jit
def _normal_loads(model, work, y, loads):
    """Fill the normal forces of the contacts under probe, no less than 0; return their sum."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    load_state(model, work, y)
    total = 0.0
    for k in range(loads.shape[0]):
        loads[k] = 0.0
        if modes.grip[k] == GRIP_PROBE:
            touch = contact_geometry(model, work, k)
            loads[k] = max(normal_force(laws, modes, k, -touch.gap, -touch.closing), 0.0)
            total += loads[k]
    return total


@jit
def spatial_settle_grips(model, work, t, y, dy):
    """Let the stopped contacts stick where mu_s allows what holds them, else slide on against it."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    loads = np.zeros(modes.grip.shape[0])
    force = np.zeros((modes.grip.shape[0], 2))
    if _normal_loads(model, work, y, loads) > 0.0:
        pairs, mass = contact_pairs_of(model), bodies_of(model).mass
        holding_forces(model, work, t, y, dy, modes, laws.grip_stiffness, pairs.a, pairs.b, mass, loads, force)
    for k in range(modes.grip.shape[0]):
        if modes.grip[k] != GRIP_PROBE:
            continue
        p = force[k, 0]
        q = force[k, 1]
        if math.sqrt(p * p + q * q) <= laws.static[k] * loads[k]:
            modes.grip[k] = GRIP_STICK
            _let_go(model, y, k, p, q)
        else:
            _aim(modes, k, -p, -q)


@jit
def spatial_start_modes(model, work, t, y, located):
    """Set every mode by the state; event functions are watched only where `located`."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    count = pairs.kind.shape[0]
    if count == 0:
        return
    resting = False
    modes.logged[0] = 0
    modes.roots[0] = ROOTS_EACH * count if located else 0
    near_pairs_of(model).stale[0] = 1
    load_state(model, work, y)
    for k in range(count):
        modes.stamp[k] = -1e300
        modes.burst[k] = 0
        touch = contact_geometry(model, work, k)
        modes.dashpot[k] = laws.damping[k] + laws.impact_damping[k] * laws.stiffness[k] / laws.slowest[k]
        modes.grip[k] = GRIP_STICK
        modes.anchor[k, 0] = 1.0
        modes.anchor[k, 1] = 0.0
        if not located:
            modes.mode[k] = MODE_PLAIN
        elif touch.beyond > 0.0 or touch.gap > 0.0 or laws.release[k] == RELEASE_RIGID:
            modes.mode[k] = MODE_OPEN
        elif is_behind(pairs, k, touch.gap):
            modes.mode[k] = MODE_BEHIND
        else:
            close(laws, modes, k, max(-touch.closing, 0.0))
            _take_grip(model, y, k, touch)
            along, across = slip_along(touch)
            if laws.friction[k] == FRICTION_STICK_SLIP and along == 0.0 and across == 0.0:
                modes.grip[k] = GRIP_PROBE
                modes.anchor[k, 0] = 0.0
                resting = True
    if resting:
        settle_grips(model, work, t, y, np.empty_like(y))


@jit
def spatial_contact_mobility(model, work, t, y, k):
    """Return n^T W n (1/kg), the normal mobility of a contact within the joints; leave W n as tree acceleration."""
    pairs = contact_pairs_of(model)
    tree, rows = tree_of(work), rows_of(work)
    load_state(model, work, y)
    fill_rows(model, work, t)
    factor(model, work)
    touch = contact_geometry(model, work, k)
    n, on_a, on_b = touch.normal, touch.arm_a, touch.arm_b
    a, b = pairs.a[k], pairs.b[k]
    tree.load[:, :] = 0.0
    p, q = cross(on_a, n), cross(on_b, n)
    add(tree.load[a], 0, n)
    add(tree.load[a], 3, p)
    add(tree.load[b], 0, negative(n))
    add(tree.load[b], 3, negative(q))
    rows.gamma[:, :] = 0.0
    solve(model, work, rows.gamma)
    x, z = tree.acceleration[a], tree.acceleration[b]
    return dot(n, x) + dot(p, triple(x, 3)) - dot(n, z) - dot(q, triple(z, 3))


@jit
def _impact(model, work, t, y, k):
    """Reverse the normal speed by an impulse, v+ = -e v-, within the joints: dv = W n p."""
    laws, bodies = contact_laws_of(model), bodies_of(model)
    mobility = contact_mobility(model, work, t, y, k)
    kin = kinematics_of(work)
    closing = contact_geometry(model, work, k).closing
    response = tree_of(work).acceleration
    impulse = -(1.0 + laws.restitution[k]) * closing / mobility
    for i in range(bodies.mass.shape[0]):
        v = bodies.v[i]
        add(y, v, times(impulse, response[i]))
        if bodies.rigid[i] == 1:
            add(y, v + 3, times(impulse, turn_back(kin.turned[i], triple(response[i], 3))))


@jit
def spatial_contact_forces(model, work, t, y, out):
    """Fill out (n_contacts, 7): depth d (m), force on body a (N), its point (m), world axes, in the present modes."""
    pairs, modes, kin = contact_pairs_of(model), contact_modes_of(model), kinematics_of(work)
    load_state(model, work, y)
    for k in range(pairs.kind.shape[0]):
        touch = contact_geometry(model, work, k)
        out[k, 0] = -touch.gap
        force = (0.0, 0.0, 0.0)
        if is_touching(pairs, modes, k, touch):
            force = contact_force(model, work, k, touch)
        for c in range(3):
            out[k, 1 + c] = force[c]
            out[k, 4 + c] = kin.position[pairs.a[k], c] + touch.arm_a[c]
