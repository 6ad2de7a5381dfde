"""Contacts as constraints: the row gap = 0 while contact lasts, and none otherwise.

gap = n . (c - o) - r with n fixed in body b for a line, gap = |c - o| - r for two circles. The row's
multiplier is the force that pulls the bodies together; the contact pushes with its negative.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.contact.laws import MODE_CLOSED
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.contacts import contact_geometry
from mbs_ref.kernels.planar.marks import separation
from mbs_ref.kernels.planar.model import (
    PAIR_LINE,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    kinematics_of,
    rows_of,
    tree_of,
)
from mbs_ref.kernels.planar.vectors import cross, dot


@jit
def planar_fill_contact_rows(model, work):
    """Evaluate the row of every contact as a constraint; an open one's is empty."""
    laws, modes = contact_laws_of(model), contact_modes_of(model)
    for k in range(laws.slot.shape[0]):
        if laws.slot[k] >= 0:
            if modes.mode[k] == MODE_CLOSED:
                _fill_contact(model, work, k)
            else:
                _clear(rows_of(work), laws.slot[k])


@jit
def _clear(rows, slot):
    """An open contact's row is empty: the solver leaves it out."""
    if rows.jacobian[slot, 0, 0, 0] == 0.0 and rows.jacobian[slot, 0, 0, 1] == 0.0:
        return  # a closed one's holds the normal
    for side in range(2):
        for c in range(3):
            rows.jacobian[slot, side, 0, c] = 0.0
    rows.residual[slot, 0] = 0.0
    rows.rate[slot, 0] = 0.0
    rows.gamma[slot, 0] = 0.0


@jit
def _fill_contact(model, work, k):
    rows, slot = rows_of(work), contact_laws_of(model).slot[k]
    touch = contact_geometry(model, work, k)
    n = touch.normal
    on_a, on_b = rows.jacobian[slot, 0, 0], rows.jacobian[slot, 1, 0]
    on_a[0], on_a[1], on_a[2] = n[0], n[1], cross(touch.arm_a, n)
    on_b[0], on_b[1], on_b[2] = -n[0], -n[1], -cross(touch.arm_b, n)
    rows.residual[slot, 0] = touch.gap
    rows.rate[slot, 0] = touch.closing
    rows.gamma[slot, 0] = _contact_gamma(model, work, k, n)


@jit
def gap_acceleration(model, work, k, touch):
    """Return the gap's second rate (m/s^2) at the accelerations in `work`, whether the contact is closed or open."""
    pairs, acceleration, n = contact_pairs_of(model), tree_of(work).acceleration, touch.normal
    of_a, of_b = acceleration[pairs.a[k]], acceleration[pairs.b[k]]
    pushed = n[0] * (of_a[0] - of_b[0]) + n[1] * (of_a[1] - of_b[1])
    turned = cross(touch.arm_a, n) * of_a[2] - cross(touch.arm_b, n) * of_b[2]
    return pushed + turned - _contact_gamma(model, work, k, n)


@jit
def _contact_gamma(model, work, k, n):
    """Return what the gap's second rate lacks of J a, negative."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    apart = separation(kin, b, a, pairs.origin[k], pairs.center[k])
    surplus = dot(n, apart.centripetal)
    if pairs.kind[k] == PAIR_LINE:
        wb = kin.motion[b, 2]
        sweep = cross(n, apart.rate)  # d(n)/d(theta_b) . d_dot
        return surplus - 2.0 * wb * sweep + wb * wb * dot(n, apart.gap)
    along = dot(n, apart.rate)
    return surplus - (dot(apart.rate, apart.rate) - along * along) / np.sqrt(dot(apart.gap, apart.gap))
