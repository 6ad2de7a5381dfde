"""Contact modes: the functions whose roots end a mode, and what happens there.

Three functions a contact: the gap's, the force's (of a constraint, the multiplier's) and friction's.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import (
    accelerate,
    contact_mobility,
    factor,
    fill_rows,
    settle_grips,
    solve,
)
from mbs_ref.kernels.contact.laws import (
    FRICTION_STICK_SLIP,
    GRIP_PROBE,
    GRIP_STICK,
    MODE_BEHIND,
    MODE_CLOSED,
    MODE_OPEN,
    MODE_PLAIN,
    RELEASE_CONSTRAINT,
    RELEASE_FORCE,
    RELEASE_RIGID,
    ROOTS_EACH,
    normal_force,
)
from mbs_ref.kernels.contact.modes import (
    FRICTION,
    IMPACT,
    TOUCH,
    close,
    is_broken,
    next_mode,
    normal_roots,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.contacts import contact_geometry, find_near, friction_force, is_behind, leaving_ends
from mbs_ref.kernels.planar.dynamics import load_state
from mbs_ref.kernels.planar.landing import AT_REST, contact_mass, contact_push, settle_held
from mbs_ref.kernels.planar.model import (
    bodies_of,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    kinematics_of,
    near_pairs_of,
    rows_of,
    tree_of,
)
from mbs_ref.kernels.planar.vectors import cross, plus
from mbs_ref.kernels.rigid.stopped_contacts import holding_forces


@jit
def contact_roots(model, work, t, y, g, rate):
    """Fill three functions a contact, and the rate of the first where known, else 0; load the state at y."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    near = near_pairs_of(model)
    if _some_constrained(laws, modes):
        accelerate(model, work, t, y)  # their functions are multipliers
        tree_of(work).holds[0] = t  # the step that goes on from here need not ask again
    else:
        load_state(model, work, y)
    find_near(model, work)
    for i in range(ROOTS_EACH * pairs.kind.shape[0]):
        g[i] = 1.0
        rate[i] = 0.0
    for place in range(near.count[0]):
        k = near.pair[place]
        touch = contact_geometry(model, work, k)
        i = ROOTS_EACH * k
        leaving = leaving_ends(model, work, k) if touch.beyond > touch.gap else 0.0
        closed = modes.mode[k] == MODE_CLOSED
        if closed and laws.release[k] == RELEASE_CONSTRAINT:
            g[i] = 1.0 - touch.beyond / modes.noise[0]
            g[i + 1] = contact_push(work, laws, k) / (modes.noise[0] * contact_mass(model, k)) + 1.0
            continue
        normal_roots(laws, modes, k, touch.gap, touch.closing, touch.beyond, leaving, g, rate)
        if closed and laws.friction[k] == FRICTION_STICK_SLIP:
            g[i + 2] = _grip_margin(laws, modes, k, touch) + 1.0


@jit
def _some_constrained(laws, modes):
    closed = 0
    for k in range(laws.slot.shape[0]):
        closed += laws.slot[k] >= 0 and modes.mode[k] == MODE_CLOSED
    return closed > 0


@jit
def _grip_margin(laws, modes, k, touch):
    """Return how much more force sticking bears, or the speed of sliding, in units of their roundoff."""
    if modes.grip[k] == GRIP_STICK:
        normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
        margin = laws.static[k] * normal - abs(friction_force(laws, modes, k, normal, touch))
        return margin / (modes.noise[0] * (laws.grip_stiffness[k] + laws.grip_damping[k]))
    return modes.grip[k] * touch.slip / modes.noise[0]


@jit
def _take_grip(modes, k, touch):
    """Slide where there is a sliding speed; stick, unloaded, where there is none."""
    modes.anchor[k, 0] = touch.along
    if touch.slip > 0.0:
        modes.grip[k] = 1
    elif touch.slip < 0.0:
        modes.grip[k] = -1
    else:
        modes.grip[k] = GRIP_STICK


@jit
def contact_transition(model, work, t, y, g, dy):
    """Change the modes whose functions are negative, with impulses where rigid.

    dy is scratch of y's shape. y changes at rigid impacts and where a constraint contact closes.
    """
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    regrip = False
    held = False
    for k in range(pairs.kind.shape[0]):
        if not is_broken(g, k):
            continue
        held = held or laws.slot[k] >= 0
        load_state(model, work, y)
        touch = contact_geometry(model, work, k)
        left = next_mode(laws, modes, k, g, touch.closing, is_behind(pairs, k, touch.gap))
        if left == IMPACT:
            _impact(model, work, t, y, k)
        elif left == TOUCH:
            _take_grip(modes, k, touch)
        elif left == FRICTION and modes.grip[k] == GRIP_STICK:
            normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
            modes.grip[k] = -1 if friction_force(laws, modes, k, normal, touch) > 0.0 else 1
        elif left == FRICTION:
            modes.grip[k] = GRIP_PROBE
            modes.anchor[k, 0] = 0.0
            regrip = True
    if held:
        settle_held(model, work, t, y, g)
    if regrip:
        settle_grips(model, work, t, y, dy)


@jit
def planar_slip_velocities(model, work, y, out):
    """Fill out (n_contacts, 1) with the sliding speeds (m/s) at y of the contacts under probe."""
    pairs, modes = contact_pairs_of(model), contact_modes_of(model)
    load_state(model, work, y)
    for k in range(pairs.kind.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            out[k, 0] = contact_geometry(model, work, k).slip


@jit
def planar_settle_grips(model, work, t, y, dy):
    """Let the stopped contacts stick where mu_s allows what holds them, else slide on against it."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    count = pairs.kind.shape[0]
    loads, place, force = np.zeros(count), np.zeros(count), np.zeros((count, 1))
    load_state(model, work, y)
    for k in range(count):
        if modes.grip[k] == GRIP_PROBE:
            touch = contact_geometry(model, work, k)
            loads[k] = max(normal_force(laws, modes, k, -touch.gap, -touch.closing), 0.0)
            place[k] = touch.along
    if np.sum(loads) > 0.0:
        mass = bodies_of(model).mass
        holding_forces(model, work, t, y, dy, modes, laws.grip_stiffness, pairs.a, pairs.b, mass, loads, force)
    for k in range(count):
        if modes.grip[k] != GRIP_PROBE:
            continue
        if abs(force[k, 0]) <= laws.static[k] * loads[k]:
            modes.grip[k] = GRIP_STICK
            modes.anchor[k, 0] = place[k] + force[k, 0] / laws.grip_stiffness[k]
        else:
            modes.grip[k] = -1 if force[k, 0] > 0.0 else 1


@jit
def start_contacts(model, work, t, y, located):
    """Set every contact's mode by the state; events are watched only where `located`."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    resting = False
    near_pairs_of(model).stale[0] = 1
    for k in range(pairs.kind.shape[0]):
        load_state(model, work, y)
        touch = contact_geometry(model, work, k)
        modes.dashpot[k] = laws.damping[k] + laws.impact_damping[k] * laws.stiffness[k] / laws.slowest[k]
        modes.grip[k] = GRIP_STICK
        modes.anchor[k, 0] = touch.along
        near = AT_REST * modes.noise[0]
        if not located:
            modes.mode[k] = MODE_PLAIN
        elif laws.release[k] == RELEASE_CONSTRAINT:
            still = touch.beyond <= 0.0 and abs(touch.gap) <= near and abs(touch.closing) <= near
            modes.mode[k] = MODE_CLOSED if still else MODE_OPEN
        elif touch.beyond > 0.0 or touch.gap > 0.0 or laws.release[k] == RELEASE_RIGID:
            modes.mode[k] = MODE_OPEN
        elif is_behind(pairs, k, touch.gap):
            modes.mode[k] = MODE_BEHIND
        else:
            close(laws, modes, k, max(-touch.closing, 0.0))
            _take_grip(modes, k, touch)
            if laws.friction[k] == FRICTION_STICK_SLIP and touch.slip == 0.0:
                modes.grip[k] = GRIP_PROBE
                modes.anchor[k, 0] = 0.0
                resting = True
    if resting:
        settle_grips(model, work, t, y, np.empty_like(y))


@jit
def planar_contact_mobility(model, work, t, y, k):
    """Return n^T W n (1/kg), the normal mobility of a contact within the joints; leave W n as tree acceleration."""
    pairs = contact_pairs_of(model)
    tree, rows = tree_of(work), rows_of(work)
    load_state(model, work, y)
    fill_rows(model, work, t)
    factor(model, work)
    touch = contact_geometry(model, work, k)
    n, a, b = touch.normal, pairs.a[k], pairs.b[k]
    for i in range(tree.load.shape[0]):
        for c in range(3):
            tree.load[i, c] = 0.0
    for c in range(2):
        tree.load[a, c] += n[c]
        tree.load[b, c] -= n[c]
    tree.load[a, 2] += cross(touch.arm_a, n)
    tree.load[b, 2] -= cross(touch.arm_b, n)
    for slot in range(rows.gamma.shape[0]):
        for row in range(3):
            rows.gamma[slot, row] = 0.0
    solve(model, work, rows.gamma)
    (ax, ay), (bx, by), response = touch.arm_a, touch.arm_b, tree.acceleration
    x = response[a, 0] - ay * response[a, 2] - response[b, 0] + by * response[b, 2]
    return n[0] * x + n[1] * (response[a, 1] + ax * response[a, 2] - response[b, 1] - bx * response[b, 2])


@jit
def _impact(model, work, t, y, k):
    """Reverse the normal speed by an impulse, v+ = -e v-, within the joints: dv = W n p."""
    laws, bodies = contact_laws_of(model), bodies_of(model)
    mobility = contact_mobility(model, work, t, y, k)
    closing = contact_geometry(model, work, k).closing
    response = tree_of(work).acceleration
    impulse = -(1.0 + laws.restitution[k]) * closing / mobility
    n = bodies.mass.shape[0]
    for i in range(n):
        place = 3 * (n + bodies.scene_index[i])
        for c in range(3):
            y[place + c] += impulse * response[i, c]


@jit
def planar_contact_forces(model, work, t, y, out):
    """Fill out (n_contacts, 5): depth d (m), force on body a (N, N), its point (m, m), in the present modes."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    kin = kinematics_of(work)
    if _some_constrained(laws, modes):
        accelerate(model, work, t, y)
    else:
        load_state(model, work, y)
    for k in range(pairs.kind.shape[0]):
        touch = contact_geometry(model, work, k)
        touching = touch.gap < 0.0 and touch.beyond <= 0.0 and not is_behind(pairs, k, touch.gap)
        if modes.mode[k] != MODE_PLAIN:
            touching = modes.mode[k] == MODE_CLOSED
        normal = normal_force(laws, modes, k, -touch.gap, -touch.closing) if touching else 0.0
        if touching and laws.release[k] == RELEASE_CONSTRAINT:
            normal = contact_push(work, laws, k)
        if modes.mode[k] == MODE_PLAIN and laws.release[k] == RELEASE_FORCE:
            normal = max(normal, 0.0)
        tangential = friction_force(laws, modes, k, normal, touch) if touching else 0.0
        n, point = touch.normal, plus(kin.pose[pairs.a[k]], touch.arm_a)
        out[k, 0] = -touch.gap
        out[k, 1] = normal * n[0] + tangential * n[1]
        out[k, 2] = normal * n[1] - tangential * n[0]
        out[k, 3], out[k, 4] = point
