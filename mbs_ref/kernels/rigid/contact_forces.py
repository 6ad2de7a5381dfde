"""What contacts do to the bodies: forces, in the frozen mode of each or clipped by the state, or rows of constraints.

A force acts on both bodies at the point of contact, so momentum is conserved to roundoff. A contact as a constraint has
the row gap = 0 while contact lasts, and none otherwise. The row's multiplier is the force that pulls the bodies
together; the contact pushes with its negative.
"""

import numpy as np

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.contact.near_pairs import refresh
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.marks import exchange, inward, magnitude, place_of_mark, separation
from mbs_ref.kernels.rigid.shapes import contact_geometry

# Return whether a depth is more than the surface is thick.
is_behind = bare(lambda pairs, k, gap: pairs.kind[k] == law.PAIR_FLAT and -gap > pairs.thickness[k])


@bare
def is_touching(pairs, laws, modes, k, touch):
    """Return whether the contact has a force: by its frozen mode, or in the plain mode by the state."""
    if modes.mode[k] != law.MODE_PLAIN:
        return modes.mode[k] == law.MODE_CLOSED
    if touch.gap >= 0.0 or touch.beyond > 0.0 or is_behind(pairs, k, touch.gap):
        return False
    return laws.release[k] != law.RELEASE_FORCE or law.normal_force(laws, modes, k, -touch.gap, -touch.closing) >= 0.0


@bare
def contact_force(model, work, k, touch, normal):
    """Return the force on body a (N) at a normal force (N), with friction in the frozen mode."""
    force = core.times(work, normal, touch.normal)
    if model.contact_laws.friction[k] == law.FRICTION_NONE:
        return force
    return core.plus(work, force, core.friction_force(model, work, k, touch, normal))


@bare
def ahead(model, work, k, touch):
    """Return how far (m) ahead of the point of contact the force acts, which resists rolling."""
    pairs, laws, n = model.contact_pairs, model.contact_laws, touch.normal
    if laws.lever[k] == 0.0:
        return core.times(work, 0.0, n)
    rolling = core.minus(work, core.swing(work, pairs.a[k], n), core.swing(work, pairs.b[k], n))
    return core.times(work, laws.lever[k] * law.share(magnitude(work, rolling), laws.roll[k]), rolling)


@jit
def rigid_find_near(model, work, duration):
    near = model.near_pairs
    for s in range(near.body.shape[0]):
        body = near.body[s]
        place = place_of_mark(work, body, near.center[s])
        for c in range(len(place)):
            near.place[s, c] = place[c]
        speed = magnitude(work, core.speed(work, body))
        near.travel[s] = duration * (speed + core.spin(work, body) * norm(near.center[s]))
    return refresh(near, model.contact_modes)


@jit
def norm(row):
    """Return the length of a row."""
    square = 0.0
    for value in row:
        square += value * value
    return np.sqrt(square)


@bare
def rigid_apply_contacts(model, work):
    pairs = model.contact_pairs
    if pairs.kind.shape[0] == 0:
        return
    laws, modes, near = model.contact_laws, model.contact_modes, model.near_pairs
    if modes.roots[0] == 0 or near.stale[0] == 1:  # while modes are frozen, what touches is in the list already
        ask.find_near(model, work, 0.0)
    for place in range(near.count[0]):
        k = near.pair[place]
        if modes.mode[k] != law.MODE_CLOSED and modes.mode[k] != law.MODE_PLAIN:
            continue
        touch = contact_geometry(model, work, k)
        if is_touching(pairs, laws, modes, k, touch):
            normal = law.normal_force(laws, modes, k, -touch.gap, -touch.closing)
            force, lead = contact_force(model, work, k, touch, normal), ahead(model, work, k, touch)
            on_a, on_b = core.plus(work, touch.arm_a, lead), core.plus(work, touch.arm_b, lead)
            exchange(work, pairs.a[k], on_a, pairs.b[k], on_b, force)


# --- rows -------------------------------------------------------------------------------------------


@jit
def rigid_fill_contact_rows(model, work):
    laws, modes = model.contact_laws, model.contact_modes
    for k in range(laws.slot.shape[0]):
        if laws.slot[k] >= 0:
            if modes.mode[k] == law.MODE_CLOSED:
                _fill_contact(model, work, k)
            else:
                _clear(model, work.rows, laws.slot[k])


@jit
def _clear(model, rows, slot):
    """An open contact's row is empty: the solver leaves it out."""
    used = False
    for c in range(len(core.block(model))):
        used |= rows.jacobian[slot, 0, 0, c] != 0.0  # a closed one's holds the normal
    if not used:
        return
    for side in range(2):
        for c in range(len(core.block(model))):
            rows.jacobian[slot, side, 0, c] = 0.0
    rows.residual[slot, 0] = rows.rate[slot, 0] = rows.gamma[slot, 0] = 0.0


@jit
def _fill_contact(model, work, k):
    rows, slot, lead = work.rows, model.contact_laws.slot[k], model.contact_modes.lead
    touch = contact_geometry(model, work, k)
    on_a, on_b = gap_rows(work, touch)
    for c in range(len(core.block(model))):
        rows.jacobian[slot, 0, 0, c] = on_a[c]
        rows.jacobian[slot, 1, 0, c] = on_b[c]
    rows.residual[slot, 0] = touch.gap - lead[k, 0]
    rows.rate[slot, 0] = touch.closing - lead[k, 1]
    rows.gamma[slot, 0] = gap_gamma(model, work, k, touch)


@bare
def gap_rows(work, touch):
    """Return the rows (rates,) that give the gap's rate from the rates of body a and of body b."""
    ahead, back = touch.normal, core.times(work, -1.0, touch.normal)
    return ahead + core.moment(work, touch.arm_a, ahead), back + core.moment(work, touch.arm_b, back)


@bare
def gap_gamma(model, work, k, touch):
    """Return what the gap's second rate lacks of its rows applied to accelerations, negative (m/s^2)."""
    pairs, n = model.contact_pairs, touch.normal
    a, b = pairs.a[k], pairs.b[k]
    apart = separation(work, b, a, pairs.origin[k], pairs.center[k])
    surplus = core.dot(work, n, inward(work, b, a, apart))
    if pairs.kind[k] == law.PAIR_FLAT:
        return core.surplus_of_turning(work, b, n, apart, surplus)
    along = core.dot(work, n, apart.rate)
    across = core.dot(work, apart.rate, apart.rate) - along * along
    return surplus - across / np.sqrt(core.dot(work, apart.gap, apart.gap))


@bare
def gap_response(model, work, k, touch):
    """Return the gap's rows applied to the accelerations in the tree."""
    pairs, acceleration = model.contact_pairs, work.tree.acceleration
    on_a, on_b = gap_rows(work, touch)
    total = 0.0
    for c in range(len(core.block(model))):
        total += on_a[c] * acceleration[pairs.a[k], c] + on_b[c] * acceleration[pairs.b[k], c]
    return total
