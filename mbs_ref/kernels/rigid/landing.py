"""Constraint contacts at an event: who holds and who lets go, decided together for all that touch.

With v the gap's rate, two linear complementarity problems (Pfeiffer and Glocker 1996, secs 5 and 8): of the impulses,
0 <= v - u, Lambda >= 0, (v - u) Lambda = 0 with u = -e v of a contact before it lands (Newton's restitution), else 0;
then of the forces, 0 <= v', lambda >= 0, v' lambda = 0. Each is solved by principal pivoting: a contact that pulls
opens, one that closes in is closed, the worst first, and by the least index if that goes on (Murty 1974), which ends.
Accelerations are unique even where forces are not.

A contact that would rebound by less than a gap can be resolved rests, and its event is at the limit of its bounces.
"""

import numpy as np

from mbs_ref.kernels.border.questions import accelerate, project
from mbs_ref.kernels.contact.laws import MODE_CLOSED, MODE_OPEN, ROOTS_EACH
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.contact_forces import gap_gamma, gap_response
from mbs_ref.kernels.rigid.model import rigid_position_count
from mbs_ref.kernels.rigid.shapes import contact_geometry

ITERATIONS = 8  # of the projection of the positions
FINER = 0.1  # of the noise: how close the projection brings the surfaces
AT_REST = 10.0  # of the noise: how close surfaces are, and how slow, that touch
SLIGHT = 1e-8  # of the largest acceleration, about eps^(1/2): less is roundoff, and decides nothing that matters
IMPULSES, FORCES = range(2)
AIMS = 2  # at the rates of a rebound, the second where accelerations depend on them
PATIENT, MOST = 2, 20  # pivots a touching contact: of the worst, and in all


# Return the force (N), or impulse (N s) after a projection, with which a closed contact pushes.
contact_push = jit(lambda work, laws, k: -work.rows.multiplier[laws.slot[k], 0])


@jit
def _drawn(model, work, k, touch):
    """Return how fast an open gap is accelerated to close (m/s^2)."""
    return gap_gamma(model, work, k, touch) - gap_response(model, work, k, touch)


@jit
def contact_mass(model, k):
    """Return the mass (kg) of the bodies of a contact: with the noise, what roundoff leaves of a force."""
    pairs, bodies = model.contact_pairs, model.bodies
    total = 0.0
    for body in (pairs.a[k], pairs.b[k]):
        if body < bodies.mass.shape[0]:
            total += bodies.mass[body]
    return total


@jit
def rigid_settle_held(model, work, t, y, g):
    """Let the constraint contacts that touch hold or go, and take the approach speeds of those that hold away.

    The function in g of each that changes turns negative, as of all that change.
    """
    modes, first = model.contact_modes, rigid_position_count(model)
    touching = _touching(model, work, y)
    before, rates, landings = modes.mode[touching], y[first:].copy(), np.zeros((touching.shape[0], 2))
    for turn in range(AIMS):
        if not _aim(model, work, t, y, touching, landings) and turn > 0:
            break
        _put_back(y, first, rates)
        for k in touching:
            modes.mode[k] = MODE_CLOSED
            modes.stamp[k], modes.burst[k] = t, 0  # what is solved here does not go on without end
        _close_gaps(model, work, t, y)
        _pivot(model, work, t, y, touching, IMPULSES)
        for k in touching:
            if modes.lead[k, 1] > 0.0:
                modes.mode[k] = MODE_OPEN
    for k in touching:
        modes.lead[k, 0], modes.lead[k, 1] = 0.0, 0.0
    _pivot(model, work, t, y, touching, FORCES)
    _move(model, work, t, y)
    for i in range(touching.shape[0]):
        k = touching[i]
        modes.lag[k] = modes.first_lag[0]
        if modes.mode[k] != before[i]:
            g[ROOTS_EACH * k] = -1.0


@jit
def _touching(model, work, y):
    """Return the constraint contacts that are closed, or open with no gap that counts, but for those that rebound."""
    laws, modes, near = model.contact_laws, model.contact_modes, model.near_pairs
    core.load_state(model, work, y)
    found, count = np.empty(near.count[0], dtype=np.int64), 0
    for place in range(near.count[0]):
        k = near.pair[place]
        if laws.slot[k] < 0:
            continue
        holds = modes.mode[k] == MODE_CLOSED
        if modes.mode[k] == MODE_OPEN:
            touch = contact_geometry(model, work, k)
            holds = touch.beyond <= 0.0 and abs(touch.gap) <= (AT_REST + modes.lag[k]) * modes.noise[0]
            holds = holds and (laws.restitution[k] == 0.0 or touch.closing < 0.0)
        if holds:
            found[count] = k
            count += 1
    return found[:count]


@jit
def _aim(model, work, t, y, touching, landings):
    """Set the gaps and rates with which the contacts that land rebound, as if each had done so where its gap was 0.

    `landings` (n, 2) holds the speed there (m/s) and the time since (s) once they are known. Return whether the rate of
    one that has rebounded changes: its acceleration depends on the speeds after the impact.
    """
    laws, modes = model.contact_laws, model.contact_modes
    slow, changed, known, before = modes.noise[1], False, np.any(landings > 0.0), modes.mode[touching]
    for i in range(touching.shape[0]):
        k = touching[i]
        if not known and laws.restitution[k] > 0.0:
            landings[i, 0] = max(-contact_geometry(model, work, k).closing - AT_REST * slow, 0.0)
        if landings[i, 0] > 0.0:
            modes.mode[k] = MODE_OPEN
    if not np.any(landings > 0.0):
        return False
    accelerate(model, work, t, y)
    for i in range(touching.shape[0]):
        k = touching[i]
        modes.mode[k] = before[i]
        if landings[i, 0] > 0.0:
            touch = contact_geometry(model, work, k)
            drawn = _drawn(model, work, k, touch)
            if not known:
                landings[i, 0] = np.sqrt(max(touch.closing**2 + 2.0 * drawn * touch.gap, 0.0))
                landings[i, 1] = -2.0 * touch.gap / (landings[i, 0] - touch.closing)
            late, slip = landings[i, 1], drawn * landings[i, 1]
            rate = max(laws.restitution[k] * landings[i, 0] - slip, 0.0)
            if abs(slip) > landings[i, 0]:  # it rebounds by less than its gap, which shows no time of landing
                late, rate = 0.0, 0.0
            changed |= abs(rate - modes.lead[k, 1]) > slow
            modes.lead[k, 0], modes.lead[k, 1] = max(rate + 0.5 * slip, 0.0) * late, rate
    return changed


@jit
def _move(model, work, t, y):
    """Project onto joints and closed contacts in the mass norm: of the velocities, a plastic impact."""
    project(model, work, t, y, FINER * model.contact_modes.noise[0], ITERATIONS)
    core.load_state(model, work, y)


@jit
def _close_gaps(model, work, t, y):
    """Project the positions alone."""
    first = rigid_position_count(model)
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
    modes, first = model.contact_modes, rigid_position_count(model)
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
        if modes.mode[worst] == MODE_CLOSED:
            modes.mode[worst] = MODE_OPEN
            continue
        if level == FORCES:
            modes.stamp[worst] = t + _rest_after(model, work, worst)
        modes.mode[worst] = MODE_CLOSED


@jit
def _rest_after(model, work, k):
    """Return the time (s) in which the bounces of a contact end, a geometric series, that leaves and is drawn back."""
    touch, e = contact_geometry(model, work, k), model.contact_laws.restitution[k]
    drawn, up = _drawn(model, work, k, touch), max(touch.closing, 0.0)
    down = np.sqrt(max(up * up + 2.0 * drawn * touch.gap, 0.0))
    return (up + down * (1.0 + e) / (1.0 - e)) / drawn


@jit
def _worst(model, work, touching, level, in_order):
    """Return the contact farthest from complementarity, or the first that is off if `in_order`; else -1."""
    worst, most = -1, 0.0
    slight = SLIGHT * _largest_acceleration(work, model.contact_modes.anchor.shape[1] + 1)
    for k in touching:
        lack = _lack(model, work, k, level, slight)
        if lack > most:
            worst, most = k, lack
            if in_order:
                return worst
    return worst


@jit
def _largest_acceleration(work, dimension):
    acceleration = work.tree.acceleration
    largest = 0.0
    for i in range(acceleration.shape[0]):
        for c in range(dimension):
            largest = max(largest, abs(acceleration[i, c]))
    return largest


@jit
def _lack(model, work, k, level, slight):
    """Return by how much (m/s or m/s^2) a closed contact pulls or leaves, or an open one closes in, beyond roundoff.

    A closed one leaves whose row depends on others: the solver drops it. An open one that leaves, but is drawn back
    before its gap would count, closes in.
    """
    laws, modes = model.contact_laws, model.contact_modes
    near, slow, slight_push = modes.noise
    touch = contact_geometry(model, work, k)
    if level == IMPULSES:
        drawn, least, roundoff = modes.lead[k, 1] - touch.closing, slow, AT_REST * slow
    else:
        drawn, least, roundoff = _drawn(model, work, k, touch), slight_push, AT_REST * slight_push + slight
    if modes.mode[k] == MODE_CLOSED:
        return max(-contact_push(work, laws, k) / contact_mass(model, k) - least, -drawn - roundoff)
    if level == IMPULSES:
        return drawn - roundoff
    leaves = max(touch.closing, 0.0)
    if leaves * leaves > 2.0 * drawn * AT_REST * near:
        return 0.0
    return drawn - roundoff
