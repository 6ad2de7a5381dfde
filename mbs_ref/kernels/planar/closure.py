"""Loop closures in the plane: what their rows do to a body and its joint (mbs_ref.kernels.rigid.elimination)."""

from __future__ import annotations

from mbs_ref.kernels.algebra.ldl import ldl3_solve
from mbs_ref.kernels.jit import jit, placed
from mbs_ref.kernels.rigid.model import bodies_of, closures_of, rows_of, slots_of, tree_of


@jit
def row_mobility(model, work, slot, row):
    """Return G M^-1 G^T of one row, the bodies taken as free."""
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    n = bodies.mass.shape[0]
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < n:
            g = rows.jacobian[slot, side, row]
            if g[0] == 0.0 and g[1] == 0.0 and g[2] == 0.0:
                continue  # an open contact's: most are
            total += (g[0] * g[0] + g[1] * g[1]) / bodies.mass[body] + g[2] * g[2] / bodies.inertia[body]
    return total


@placed
def pass_closure(model, work, i, here, there, count):
    for r in range(count):
        _pass_row(model, work, i, here, there, r)


@placed
def _pass_row(model, work, i, here, there, r):
    tree, closures = tree_of(work), closures_of(work)
    m, s, lift, transfer = tree.mass_factor[i], tree.row_factor[i], tree.lift[i], tree.transfer[i]
    joint, column = closures.joint[here], closures.column[here]
    p0, p1, p2 = closures.passed[here, 0, r], closures.passed[here, 1, r], closures.passed[here, 2, r]
    w0 = lift[0, 0] * p0 + lift[1, 0] * p1 + lift[2, 0] * p2
    w1 = lift[0, 1] * p0 + lift[1, 1] * p1 + lift[2, 1] * p2
    w2 = lift[0, 2] * p0 + lift[1, 2] * p1 + lift[2, 2] * p2
    if there >= 0:
        for c in range(3):
            closures.passed[there, c, r] -= transfer[0, c] * w0 + transfer[1, c] * w1 + transfer[2, c] * w2
    v0, v1, v2 = ldl3_solve(m[0], m[1], m[2], m[3], m[4], m[5], p0, p1, p2)
    u0, u1, u2 = ldl3_solve(s[0], s[1], s[2], s[3], s[4], s[5], w0, w1, w2)
    joint[0, r], joint[1, r], joint[2, r] = u0, u1, u2
    column[0, r] = v0 - (lift[0, 0] * u0 + lift[0, 1] * u1 + lift[0, 2] * u2)
    column[1, r] = v1 - (lift[1, 0] * u0 + lift[1, 1] * u1 + lift[1, 2] * u2)
    column[2, r] = v2 - (lift[2, 0] * u0 + lift[2, 1] * u1 + lift[2, 2] * u2)
