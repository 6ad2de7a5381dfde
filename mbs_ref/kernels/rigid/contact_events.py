"""Contact modes: the functions whose roots end a mode, and what happens there.

Four functions a contact: the gap's, the force's (of a constraint, the multiplier's), friction's and that of open ends.
"""

import numpy as np

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.contact.modes import FRICTION, IMPACT, NOTHING, TOUCH, close, is_broken, next_mode, normal_roots
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import contact_forces as forces
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.dynamics import correct_rates, store_solved
from mbs_ref.kernels.rigid.grips import change_grip, grip_margin, is_still, probe, take_grip
from mbs_ref.kernels.rigid.landing import AT_REST, contact_mass, contact_push
from mbs_ref.kernels.rigid.marks import speed_between
from mbs_ref.kernels.rigid.shapes import contact_geometry, leaving_ends
from mbs_ref.kernels.rows import clear


@bare
def contact_roots(model, work, t, y, duration, table):
    """Fill four functions a contact, load the state at y, and return whether the list of near pairs is new.

    The list covers the last `duration` (s); where that is negative it stays as it is.
    """
    pairs, laws, modes = model.contact_pairs, model.contact_laws, model.contact_modes
    near = model.near_pairs
    if _some_constrained(laws, modes, table):
        ask.accelerate(model, work, t, y)  # their functions are multipliers
        store_solved(work, t, y)  # the step that goes on from here need not ask again
    else:
        core.load_state(model, work, y)
    is_new = duration >= 0.0 and ask.find_near(model, work, duration)
    for place in range(near.count[0]):
        k = near.pair[place]
        i = law.ROOTS_EACH * k
        if table[law.SPEED, i] == law.LEFT_OUT:
            continue
        touch = contact_geometry(model, work, k)
        if duration >= 0.0 and touch.gap > modes.lag[k] * modes.noise[0]:
            modes.lag[k] = 0.0
        leaving = leaving_ends(model, work, k) if touch.beyond > -np.inf else 0.0
        closed = modes.mode[k] == law.MODE_CLOSED
        speed = _gap_speed(model, work, k, touch)
        for c in range(law.ROOTS_EACH):
            table[law.TURN, i + c] = core.spin(work, pairs.a[k]) + core.spin(work, pairs.b[k])
        if modes.mode[k] != law.MODE_OPEN and touch.beyond > -np.inf:
            table[law.VALUE, i + law.ENDS] = 1.0 - touch.beyond / modes.noise[0]
            table[law.RATE, i + law.ENDS] = -leaving / modes.noise[0]
            table[law.SPEED, i + law.ENDS] = speed / modes.noise[0]
        if closed and laws.release[k] == law.RELEASE_CONSTRAINT:
            table[law.VALUE, i + 1] = contact_push(work, laws, k) / (modes.noise[2] * contact_mass(model, k)) + 1.0
            table[law.SPEED, i + 1] = law.UNKNOWN
            continue
        normal_roots(laws, modes, k, touch.gap, touch.closing, touch.beyond, leaving, speed, table)
        if closed and laws.friction[k] == law.FRICTION_STICK_SLIP:
            table[law.VALUE, i + 2] = grip_margin(model, work, k, touch) + 1.0
            table[law.SPEED, i + 2] = law.UNKNOWN
    return is_new


@bare
def _gap_speed(model, work, k, touch):
    """Return a bound (m/s) on the rate of a gap and of the excess over open ends."""
    pairs = model.contact_pairs
    a, b = pairs.a[k], pairs.b[k]
    turning = core.spin(work, a) * forces.norm(pairs.center[k])
    turning += core.spin(work, b) * (forces.norm(touch.arm_b) + pairs.radius[k])
    return speed_between(work, a, b) + turning


@bare
def _some_constrained(laws, modes, table):
    closed = 0
    for k in range(laws.slot.shape[0]):
        needed = table[law.SPEED, law.ROOTS_EACH * k] != law.LEFT_OUT
        closed += needed and laws.slot[k] >= 0 and modes.mode[k] == law.MODE_CLOSED
    return closed > 0


@jit
def contact_transition(model, work, t, y, g, dy):
    """Change the modes whose functions are negative, with impulses where rigid.

    dy is scratch of y's shape. Velocities in y change at rigid impacts, positions too where a constraint contact
    closes, and deflections where a contact sticks.
    """
    pairs, laws, modes = model.contact_pairs, model.contact_laws, model.contact_modes
    stopped = False
    held = False
    for k in range(pairs.kind.shape[0]):
        if not is_broken(g, k):
            continue
        held = held or laws.slot[k] >= 0
        core.load_state(model, work, y)
        touch = contact_geometry(model, work, k)
        before = modes.mode[k]
        due = next_mode(laws, modes, k, g, touch.closing, forces.is_behind(pairs, k, touch.gap))
        if law.MODE_BEHIND in (before, modes.mode[k]) or (before == law.MODE_LEAVING and due == NOTHING):
            for c in range(law.ROOTS_EACH):  # nothing touches, so it is not logged
                g[law.ROOTS_EACH * k + c] = 0.0
        if due == IMPACT:
            _impact(model, work, t, y, k)
        elif due == TOUCH:
            take_grip(model, y, k, touch)
        elif due == FRICTION:
            slid = modes.grip[k] != law.GRIP_STICK
            if change_grip(model, work, k, touch):
                probe(modes, k)
                stopped = True
            elif slid:
                g[law.ROOTS_EACH * k + 2] = law.TURNED
    if held:
        ask.settle_held(model, work, t, y, g)
    if stopped:
        core.stop_together(model, work, y, g)
        ask.settle_grips(model, work, t, y, dy)


@jit
def start_contacts(model, work, t, y, located):
    """Set every contact's mode by the state; events are watched only where `located`."""
    pairs, laws, modes = model.contact_pairs, model.contact_laws, model.contact_modes
    resting = False
    model.near_pairs.stale[0] = 1
    core.load_state(model, work, y)
    for k in range(pairs.kind.shape[0]):
        touch = contact_geometry(model, work, k)
        modes.dashpot[k] = laws.damping[k] + laws.impact_damping[k] * laws.stiffness[k] / laws.slowest[k]
        modes.grip[k] = law.GRIP_STICK
        modes.lag[k] = 0.0
        core.start_grip(model, k, touch)
        if not located:
            modes.mode[k] = law.MODE_PLAIN
        elif laws.release[k] == law.RELEASE_CONSTRAINT:
            moves = max(abs(touch.gap) / modes.noise[0], abs(touch.closing) / modes.noise[1])
            rests = touch.beyond <= 0.0 and moves <= AT_REST and laws.restitution[k] == 0.0
            modes.mode[k] = law.MODE_CLOSED if rests else law.MODE_OPEN
        elif touch.beyond > 0.0 or touch.gap > 0.0:
            modes.mode[k] = law.MODE_OPEN
        elif forces.is_behind(pairs, k, touch.gap):
            modes.mode[k] = law.MODE_BEHIND
        elif laws.release[k] == law.RELEASE_RIGID:
            modes.mode[k] = law.MODE_OPEN
        else:
            close(laws, modes, k, max(-touch.closing, 0.0))
            take_grip(model, y, k, touch)
            if laws.friction[k] == law.FRICTION_STICK_SLIP and is_still(core.slip_of(model, touch)):
                probe(modes, k)
                resting = True
    if resting:
        ask.settle_grips(model, work, t, y, np.empty_like(y))


@jit
def rigid_contact_mobility(model, work, t, y, k):
    """Return n^T W n (1/kg), the normal mobility of a contact within the joints; leave W n as tree acceleration."""
    pairs, tree, rows = model.contact_pairs, work.tree, work.rows
    core.load_state(model, work, y)
    ask.fill_rows(model, work, t)
    ask.factor(model, work)
    touch = contact_geometry(model, work, k)
    on_a, on_b = forces.gap_rows(work, touch)
    clear(tree.load)
    for c in range(len(core.block(model))):
        tree.load[pairs.a[k], c] += on_a[c]
        tree.load[pairs.b[k], c] += on_b[c]
    clear(rows.gamma)
    load = tree.load.copy()
    ask.solve(model, work, rows.gamma)
    ask.refine(model, work, load, 1.0)  # where n acts through a joint, all but a small share of it cancels
    return forces.gap_response(model, work, k, touch)


@jit
def _impact(model, work, t, y, k):
    """Reverse the normal speed by an impulse, v+ = -e v-, within the joints: dv = W n p."""
    mobility = ask.contact_mobility(model, work, t, y, k)
    closing = contact_geometry(model, work, k).closing
    impulse = -(1.0 + model.contact_laws.restitution[k]) * closing / mobility
    correct_rates(model, work, impulse, y)


@jit
def rigid_contact_forces(model, work, t, y, out):
    pairs, laws, modes = model.contact_pairs, model.contact_laws, model.contact_modes
    ask.accelerate(model, work, t, y)
    for k in range(pairs.kind.shape[0]):
        touch = contact_geometry(model, work, k)
        out[k, 0] = -touch.gap
        place, touching = core.centre(work, pairs.a[k]), forces.is_touching(pairs, laws, modes, k, touch)
        normal = law.normal_force(laws, modes, k, -touch.gap, -touch.closing)
        if laws.release[k] == law.RELEASE_CONSTRAINT:
            normal = contact_push(work, laws, k)
        force, lead = forces.contact_force(model, work, k, touch, normal), forces.ahead(model, work, k, touch)
        for c in range(len(place)):
            out[k, 1 + c] = force[c] if touching else 0.0
            out[k, 1 + len(place) + c] = place[c] + touch.arm_a[c] + lead[c]
