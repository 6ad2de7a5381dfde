"""Loop closures in space: what their rows do to a body and its joint (mbs_ref.kernels.rigid.elimination)."""

from __future__ import annotations

from mbs_ref.kernels.jit import jit, placed
from mbs_ref.kernels.rigid.model import bodies_of, closures_of, kinematics_of, rows_of, slots_of, tree_of


@jit
def row_mobility(model, work, slot, row):
    """Return a scale of G M^-1 G^T of one row, the bodies taken as free and as spheres."""
    bodies, slots, rows, kin = bodies_of(model), slots_of(model), rows_of(work), kinematics_of(work)
    n = bodies.mass.shape[0]
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < n:
            g = rows.jacobian[slot, side, row]
            j = kin.inertia[body]
            total += (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]) / bodies.mass[body]
            total += 3.0 * (g[3] * g[3] + g[4] * g[4] + g[5] * g[5]) / (j[0] + j[1] + j[2])
    return total


@placed
def pass_closure(model, work, i, here, there, _count):
    """Condense body i under one closure, all of whose rows go through the same steps at once."""
    tree, rows, closures, count = tree_of(work), rows_of(work), closures_of(work), slots_of(model).count[i]
    joint, column = closures.joint[here], closures.column[here]
    for c in range(6):
        for r in range(6):
            column[c, r] = closures.passed[here, c, r]
    _solve_rows(tree.articulated[i], 6, column)
    for k in range(count):
        for r in range(6):
            joint[k, r] = 0.0
        for c in range(6):
            for r in range(6):
                joint[k, r] += rows.jacobian[i, 0, k, c] * column[c, r]
    _solve_rows(tree.row_factor[i], count, joint)
    for k in range(count):
        for c in range(6):
            for r in range(6):
                column[c, r] -= tree.lift[i, k, c] * joint[k, r]
    if there >= 0:
        for k in range(count):
            for c in range(6):
                for r in range(6):
                    closures.passed[there, c, r] -= rows.jacobian[i, 1, k, c] * joint[k, r]


@placed
def _solve_rows(a, n, b):
    """Solve in place, for six right-hand sides at once, with the factors of `factor_ldl`."""
    for i in range(1, n):
        for k in range(i):
            for r in range(6):
                b[i, r] -= a[i, k] * b[k, r]
    for i in range(n - 1, -1, -1):
        for r in range(6):
            b[i, r] *= a[i, i]
        for k in range(i + 1, n):
            for r in range(6):
                b[i, r] -= a[k, i] * b[k, r]
