"""Constraint contacts: touch-down as a projection of the velocities, and who lets go again at once."""

from __future__ import annotations

from mbs_ref.kernels.border.questions import project
from mbs_ref.kernels.contact.laws import (
    MODE_CLOSED,
    MODE_OPEN,
    ROOTS_EACH,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.model import (
    bodies_of,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    rows_of,
)

ITERATIONS = 8  # of the projection of the positions
FINER = 0.1  # of the noise: how close the projection brings the surfaces


@jit
def contact_push(work, laws, k):
    """Return the force (N), or impulse (N s) after a projection, with which a closed contact pushes."""
    return -rows_of(work).multiplier[laws.slot[k], 0]


@jit
def contact_mass(model, k):
    """Return the mass (kg) of the bodies of a contact: with the noise, what roundoff leaves of a force."""
    pairs, bodies = contact_pairs_of(model), bodies_of(model)
    total = 0.0
    for body in (pairs.a[k], pairs.b[k]):
        if body < bodies.mass.shape[0]:
            total += bodies.mass[body]
    return total


@jit
def land(model, work, t, y, g):
    """Take the approach speeds away by the smallest impulses that only push.

    The velocities are projected onto joints and closed contacts in the mass norm (a plastic impact); a
    contact whose impulse would pull opens, the worst first, and the projection is made anew. Its function in
    g turns negative, as of all that change.
    """
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    half = y.shape[0] // 2
    before = y[half:].copy()
    for _ in range(laws.slot.shape[0] + 1):
        for k in range(before.shape[0]):  # to assign the slice would compile its error messages too, for seconds
            y[half + k] = before[k]
        project(model, work, t, y, FINER * modes.noise[0], ITERATIONS)
        worst = _worst_pull(model, work)
        if worst < 0:
            return
        modes.mode[worst] = MODE_OPEN
        g[ROOTS_EACH * worst] = -1.0


@jit
def _worst_pull(model, work):
    """Return the contact that pulls most, or -1."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    worst = -1
    least = 0.0
    for k in range(laws.slot.shape[0]):
        if laws.slot[k] >= 0 and modes.mode[k] == MODE_CLOSED:
            push = contact_push(work, laws, k) + modes.noise[0] * contact_mass(model, k)
            if push < least:
                least = push
                worst = k
    return worst
