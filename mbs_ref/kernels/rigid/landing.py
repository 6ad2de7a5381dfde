"""Constraint contacts at an event: who holds and who lets go, decided together for all that touch.

With v the gap's rate, two linear complementarity problems (Pfeiffer and Glocker 1996, secs 5 and 8): of the impulses of
a plastic impact, 0 <= v, Lambda >= 0, v Lambda = 0; then of the forces, 0 <= v', lambda >= 0, v' lambda = 0. Each is
solved by principal pivoting: a contact that pulls opens, one that closes in is closed, the worst first, and by the
least index if that goes on (Murty 1974), which ends. Accelerations are unique even where forces are not.
"""

import numpy as np

from mbs_ref.kernels.border.questions import accelerate, project
from mbs_ref.kernels.contact.laws import MODE_CLOSED, MODE_OPEN, ROOTS_EACH
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.contact_forces import gap_gamma, gap_response
from mbs_ref.kernels.rigid.model import (
    bodies_of,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    near_pairs_of,
    position_count,
    rows_of,
    tree_of,
)
from mbs_ref.kernels.rigid.shapes import contact_geometry

ITERATIONS = 8  # of the projection of the positions
FINER = 0.1  # of the noise: how close the projection brings the surfaces
AT_REST = 10.0  # of the noise: how close surfaces are, and how slow, that touch
SLIGHT = 1e-8  # of the largest acceleration, about eps^(1/2): less is roundoff, and decides nothing that matters
IMPULSES, FORCES = range(2)
PATIENT, MOST = 2, 20  # pivots a touching contact: of the worst, and in all


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
def settle_held(model, work, t, y, g):
    """Let the constraint contacts that touch hold or go, and take the approach speeds of those that hold away.

    The function in g of each that changes turns negative, as of all that change.
    """
    modes = contact_modes_of(model)
    touching = _touching(model, work, y)
    before = modes.mode[touching]
    for k in touching:
        modes.mode[k] = MODE_CLOSED
    _close_gaps(model, work, t, y)
    _pivot(model, work, t, y, touching, IMPULSES)
    _pivot(model, work, t, y, touching, FORCES)
    _move(model, work, t, y)
    for i in range(touching.shape[0]):
        if modes.mode[touching[i]] != before[i]:
            g[ROOTS_EACH * touching[i]] = -1.0


@jit
def _touching(model, work, y):
    """Return the constraint contacts that are closed, or open with no gap that counts."""
    laws, modes, near = contact_laws_of(model), contact_modes_of(model), near_pairs_of(model)
    core.load_state(model, work, y)
    found, count = np.empty(near.count[0], dtype=np.int64), 0
    for place in range(near.count[0]):
        k = near.pair[place]
        if laws.slot[k] < 0:
            continue
        holds = modes.mode[k] == MODE_CLOSED
        if modes.mode[k] == MODE_OPEN:
            touch = contact_geometry(model, work, k)
            holds = touch.beyond <= 0.0 and abs(touch.gap) <= AT_REST * modes.noise[0]
        if holds:
            found[count] = k
            count += 1
    return found[:count]


@jit
def _move(model, work, t, y):
    """Project onto joints and closed contacts in the mass norm: of the velocities, a plastic impact."""
    project(model, work, t, y, FINER * contact_modes_of(model).noise[0], ITERATIONS)
    core.load_state(model, work, y)


@jit
def _close_gaps(model, work, t, y):
    """Project the positions alone."""
    first = position_count(model)
    before = y[first:].copy()
    _move(model, work, t, y)
    _put_back(y, first, before)


@jit
def _put_back(y, first, before):
    for k in range(before.shape[0]):  # to assign the slice would compile its error messages too, for seconds
        y[first + k] = before[k]


@jit
def _pivot(model, work, t, y, touching, level):
    """Open and close contacts until the complementarity of impulses or of forces holds."""
    modes, first = contact_modes_of(model), position_count(model)
    before = y[first:].copy()
    for turn in range(MOST * touching.shape[0]):
        if level == IMPULSES:
            _put_back(y, first, before)
            _move(model, work, t, y)
        else:
            accelerate(model, work, t, y)
        worst = _worst(model, work, touching, level, turn > PATIENT * touching.shape[0])
        if worst < 0:
            return
        modes.mode[worst] = MODE_OPEN if modes.mode[worst] == MODE_CLOSED else MODE_CLOSED


@jit
def _worst(model, work, touching, level, in_order):
    """Return the contact farthest from complementarity, or the first that is off where asked `in_order`; else -1."""
    worst, most = -1, 0.0
    slight = SLIGHT * _largest_acceleration(work, contact_modes_of(model).anchor.shape[1] + 1)
    for k in touching:
        lack = _lack(model, work, k, level, slight)
        if lack > most:
            worst, most = k, lack
            if in_order:
                return worst
    return worst


@jit
def _largest_acceleration(work, dimension):
    acceleration = tree_of(work).acceleration
    largest = 0.0
    for i in range(acceleration.shape[0]):
        for c in range(dimension):
            largest = max(largest, abs(acceleration[i, c]))
    return largest


@jit
def _lack(model, work, k, level, slight):
    """Return by how much (m/s or m/s^2) a contact pulls, or closes in, beyond roundoff.

    One that leaves, but is drawn back before its gap would count, closes in.
    """
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    near, slow, slight_push = modes.noise
    if modes.mode[k] == MODE_CLOSED:
        least = slow if level == IMPULSES else slight_push
        return -contact_push(work, laws, k) / contact_mass(model, k) - least
    touch = contact_geometry(model, work, k)
    if level == IMPULSES:
        return -touch.closing - AT_REST * slow
    drawn = gap_gamma(model, work, k, touch) - gap_response(model, work, k, touch)
    leaves = max(touch.closing, 0.0)
    if leaves * leaves > 2.0 * drawn * AT_REST * near:
        return 0.0
    return drawn - AT_REST * slight_push - slight
