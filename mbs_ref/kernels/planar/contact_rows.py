"""Contacts as constraints: the row gap = 0 while contact lasts, and none otherwise.

gap = n . (c - o) - r with n fixed in body b for a line, gap = |c - o| - r for two circles. The row's
multiplier is the force that pulls the bodies together; the contact pushes with its negative.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.contact.laws import (
    MODE_CLOSED,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.contacts import contact_geometry
from mbs_ref.kernels.planar.joints import arm, fill_joints
from mbs_ref.kernels.planar.model import (
    PAIR_LINE,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    kinematics_of,
    rows_of,
)


@jit
def planar_fill_rows(model, work, t):
    """Evaluate every constraint row, of joints and of closed constraint contacts."""
    fill_joints(model, work, t)
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
    for side in range(2):
        for c in range(3):
            rows.jacobian[slot, side, 0, c] = 0.0
    rows.residual[slot, 0] = 0.0
    rows.rate[slot, 0] = 0.0
    rows.gamma[slot, 0] = 0.0


@jit
def _fill_contact(model, work, k):
    pairs, kin, rows = contact_pairs_of(model), kinematics_of(work), rows_of(work)
    slot = contact_laws_of(model).slot[k]
    gap, rate, nx, ny, _, _, _, ax, ay, bx, by = contact_geometry(pairs, kin, k)
    on_a = rows.jacobian[slot, 0, 0]
    on_b = rows.jacobian[slot, 1, 0]
    on_a[0], on_a[1], on_a[2] = nx, ny, ax * ny - ay * nx
    on_b[0], on_b[1], on_b[2] = -nx, -ny, -(bx * ny - by * nx)
    rows.residual[slot, 0] = gap
    rows.rate[slot, 0] = rate
    rows.gamma[slot, 0] = _contact_gamma(pairs, kin, k, nx, ny)


@jit
def _contact_gamma(pairs, kin, k, nx, ny):
    """Return what the gap's second rate lacks of J a, negative: d = c - o in world axes."""
    a = pairs.a[k]
    b = pairs.b[k]
    cx, cy = arm(kin.pose, a, pairs.center[k])
    ox, oy = arm(kin.pose, b, pairs.origin[k])
    wa = kin.motion[a, 2]
    wb = kin.motion[b, 2]
    dx = kin.pose[a, 0] + cx - kin.pose[b, 0] - ox
    dy = kin.pose[a, 1] + cy - kin.pose[b, 1] - oy
    ux = kin.motion[a, 0] - cy * wa - kin.motion[b, 0] + oy * wb
    uy = kin.motion[a, 1] + cx * wa - kin.motion[b, 1] - ox * wb
    centripetal = nx * (cx * wa * wa - ox * wb * wb) + ny * (cy * wa * wa - oy * wb * wb)
    if pairs.kind[k] == PAIR_LINE:
        sweep = nx * uy - ny * ux  # perp(n) . d_dot
        return centripetal - 2.0 * wb * sweep + wb * wb * (nx * dx + ny * dy)
    along = nx * ux + ny * uy
    return centripetal - (ux * ux + uy * uy - along * along) / np.sqrt(dx * dx + dy * dy)
