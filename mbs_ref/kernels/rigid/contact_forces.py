"""Contact forces, in the frozen mode of each contact or clipped by the state, and the list of near pairs.

The force acts on both bodies at the point of contact, so momentum is kept to roundoff.
"""

from __future__ import annotations

from mbs_ref.kernels.contact.laws import FRICTION_NONE, MODE_CLOSED, MODE_PLAIN, PAIR_FLAT, RELEASE_FORCE, normal_force
from mbs_ref.kernels.contact.near_pairs import refresh
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.marks import exchange, place_of_mark
from mbs_ref.kernels.rigid.model import contact_laws_of, contact_modes_of, contact_pairs_of, near_pairs_of
from mbs_ref.kernels.rigid.shapes import contact_geometry


@bare
def is_behind(pairs, k, gap):
    """Return whether a depth is more than the surface is thick."""
    return pairs.kind[k] == PAIR_FLAT and -gap > pairs.thickness[k]


@bare
def is_touching(pairs, laws, modes, k, touch):
    """Return whether the contact has a force: by its frozen mode, or in the plain mode by the state."""
    if modes.mode[k] != MODE_PLAIN:
        return modes.mode[k] == MODE_CLOSED
    if touch.gap >= 0.0 or touch.beyond > 0.0 or is_behind(pairs, k, touch.gap):
        return False
    return laws.release[k] != RELEASE_FORCE or normal_force(laws, modes, k, -touch.gap, -touch.closing) >= 0.0


@bare
def contact_force(model, work, k, touch, normal):
    """Return the force on body a (N) at a normal force (N), with friction in the frozen mode."""
    force = core.times(work, normal, touch.normal)
    if contact_laws_of(model).friction[k] == FRICTION_NONE:
        return force
    return core.plus(work, force, core.friction_force(model, work, k, touch, normal))


@jit
def find_near(model, work):
    """Bring the list of near pairs up to the pose in `work`."""
    near = near_pairs_of(model)
    for s in range(near.body.shape[0]):
        place = place_of_mark(work, near.body[s], near.center[s])
        for c in range(len(place)):
            near.place[s, c] = place[c]
    refresh(near, contact_modes_of(model))


@bare
def rigid_apply_contacts(model, work):
    """Add the forces of every contact that is closed."""
    pairs = contact_pairs_of(model)
    if pairs.kind.shape[0] == 0:
        return
    laws, modes, near = contact_laws_of(model), contact_modes_of(model), near_pairs_of(model)
    if modes.roots[0] == 0 or near.stale[0] == 1:  # while modes are frozen, what touches is in the list already
        find_near(model, work)
    for place in range(near.count[0]):
        k = near.pair[place]
        if modes.mode[k] != MODE_CLOSED and modes.mode[k] != MODE_PLAIN:
            continue
        touch = contact_geometry(model, work, k)
        if is_touching(pairs, laws, modes, k, touch):
            normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
            force = contact_force(model, work, k, touch, normal)
            exchange(work, pairs.a[k], touch.arm_a, pairs.b[k], touch.arm_b, force)
