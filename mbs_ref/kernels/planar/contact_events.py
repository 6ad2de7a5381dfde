"""Contact modes: the functions whose roots end a mode, and what happens there.

Three functions a contact: the gap's, the force's (of a constraint, the multiplier's) and friction's.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import (
    accelerate,
    contact_mobility,
    derivative,
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
    LANDING,
    TOUCH,
    close,
    is_broken,
    next_mode,
    normal_roots,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.contacts import contact_geometry, find_near, friction_force, is_behind
from mbs_ref.kernels.planar.dynamics import load_state
from mbs_ref.kernels.planar.landing import contact_mass, contact_push, land
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

PROBE_SWEEPS = 200  # for the friction of contacts that stop sliding together
AT_REST = 10.0  # of the noise: how close and slow a constraint contact must be to begin closed


@jit
def contact_roots(model, work, t, y, g, rate):
    """Fill three functions a contact, and the rate of the first where known, else 0; load the state at y."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    kin, near = kinematics_of(work), near_pairs_of(model)
    if _some_constrained(laws, modes):
        accelerate(model, work, t, y)  # their functions are multipliers
    else:
        load_state(model, work, y)
    find_near(model, work)
    for i in range(ROOTS_EACH * pairs.kind.shape[0]):
        g[i] = 1.0
        rate[i] = 0.0
    for place in range(near.count[0]):
        k = near.pair[place]
        touch = contact_geometry(pairs, kin, k)
        i = ROOTS_EACH * k
        closed = modes.mode[k] == MODE_CLOSED
        if closed and laws.release[k] == RELEASE_CONSTRAINT:
            g[i] = modes.noise[0] - touch.beyond
            g[i + 1] = contact_push(work, laws, k) + modes.noise[0] * contact_mass(model, k)
            continue
        normal_roots(laws, modes, k, touch.gap, touch.closing, touch.beyond, g, rate)
        if closed and laws.friction[k] == FRICTION_STICK_SLIP:
            g[i + 2] = _grip_margin(laws, modes, k, touch) + modes.noise[0]


@jit
def _some_constrained(laws, modes):
    closed = 0
    for k in range(laws.slot.shape[0]):
        closed += laws.slot[k] >= 0 and modes.mode[k] == MODE_CLOSED
    return closed > 0


@jit
def _grip_margin(laws, modes, k, touch):
    if modes.grip[k] == GRIP_STICK:
        normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
        return laws.static[k] * normal - abs(friction_force(laws, modes, k, normal, touch))
    return modes.grip[k] * touch.slip


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
    kin = kinematics_of(work)
    regrip = False
    landed = False
    for k in range(pairs.kind.shape[0]):
        if not is_broken(g, k):
            continue
        load_state(model, work, y)
        touch = contact_geometry(pairs, kin, k)
        left = next_mode(laws, modes, k, g, touch.closing, is_behind(pairs, k, touch.gap))
        if left == IMPACT:
            _impact(model, work, t, y, k)
        elif left == LANDING:
            landed = True
        elif left == TOUCH:
            _take_grip(modes, k, touch)
        elif left == FRICTION and modes.grip[k] == GRIP_STICK:
            normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
            modes.grip[k] = -1 if friction_force(laws, modes, k, normal, touch) > 0.0 else 1
        elif left == FRICTION:
            modes.grip[k] = GRIP_PROBE
            modes.anchor[k, 0] = 0.0
            regrip = True
    if landed:
        land(model, work, t, y, g)
    if regrip:
        settle_grips(model, work, t, y, dy)


@jit
def _slide_rate(model, work, t, y, dy, k):
    """Return the rate of a contact's sliding speed in the present modes, by differences along the motion."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    derivative(model, work, t, y, dy)
    step = 1e-6
    ahead = y + step * dy
    load_state(model, work, ahead)
    later = contact_geometry(pairs, kin, k).slip
    ahead = y - step * dy
    load_state(model, work, ahead)
    return (later - contact_geometry(pairs, kin, k).slip) / (2.0 * step)


@jit
def _probed_load(pairs, laws, modes, kin):
    """Return the sum of the normal forces of the contacts under probe, and their number."""
    total = 0.0
    count = 0
    for k in range(pairs.kind.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            touch = contact_geometry(pairs, kin, k)
            total += max(normal_force(laws, modes, k, -touch.gap, -touch.closing), 0.0)
            count += 1
    return total, count


@jit
def planar_settle_grips(model, work, t, y, dy):
    """Find the friction that keeps the stopped contacts at rest; stick where mu_s allows it, else slide on.

    Each probe force changes its own sliding rate linearly. Where friction is not unique, as under two
    corners of one block, weights by the normal force make the contacts share in proportion to it.
    """
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    kin = kinematics_of(work)
    load_state(model, work, y)
    total, count = _probed_load(pairs, laws, modes, kin)
    change = np.zeros(pairs.kind.shape[0])
    for _ in range(PROBE_SWEEPS):
        largest = 0.0
        most = 0.0
        for k in range(pairs.kind.shape[0]):
            if modes.grip[k] != GRIP_PROBE:
                continue
            before = modes.anchor[k, 0]
            rate = _slide_rate(model, work, t, y, dy, k)
            modes.anchor[k, 0] = before + 1.0
            mobility = _slide_rate(model, work, t, y, dy, k) - rate
            modes.anchor[k, 0] = before
            load_state(model, work, y)
            touch = contact_geometry(pairs, kin, k)
            normal = max(normal_force(laws, modes, k, -touch.gap, -touch.closing), 0.0)
            share = normal / total if total > 0.0 else 1.0 / count
            change[k] = -share * rate / mobility if mobility > 0.0 else 0.0
            largest = max(largest, abs(change[k]))
        for k in range(pairs.kind.shape[0]):
            if modes.grip[k] == GRIP_PROBE:
                modes.anchor[k, 0] += change[k]
                most = max(most, abs(modes.anchor[k, 0]))
        if largest <= 1e-10 * most:
            break
    for k in range(pairs.kind.shape[0]):
        if modes.grip[k] != GRIP_PROBE:
            continue
        load_state(model, work, y)
        touch = contact_geometry(pairs, kin, k)
        needed = modes.anchor[k, 0]
        if abs(needed) <= laws.static[k] * normal_force(laws, modes, k, -touch.gap, -touch.closing):
            modes.grip[k] = GRIP_STICK
            modes.anchor[k, 0] = touch.along + needed / laws.grip_stiffness[k]
        else:
            modes.grip[k] = -1 if needed > 0.0 else 1


@jit
def start_contacts(model, work, t, y, located):
    """Set every contact's mode by the state; events are watched only where `located`."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    kin = kinematics_of(work)
    resting = False
    near_pairs_of(model).stale[0] = 1
    for k in range(pairs.kind.shape[0]):
        load_state(model, work, y)
        touch = contact_geometry(pairs, kin, k)
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
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    tree, rows = tree_of(work), rows_of(work)
    load_state(model, work, y)
    fill_rows(model, work, t)
    factor(model, work)
    touch = contact_geometry(pairs, kin, k)
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
    pairs, laws, bodies = contact_pairs_of(model), contact_laws_of(model), bodies_of(model)
    mobility = contact_mobility(model, work, t, y, k)
    closing = contact_geometry(pairs, kinematics_of(work), k).closing
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
        touch = contact_geometry(pairs, kin, k)
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
