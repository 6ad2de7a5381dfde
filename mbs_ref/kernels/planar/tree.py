"""O(N) elimination of the augmented system along the joint tree.

Leaf to root, a body with block M, force f and joint rows J a + K a_parent = gamma is condensed into its
parent: with S = J M^-1 J^T,
    M_parent += K^T S^-1 K        f_parent -= K^T S^-1 (J M^-1 f - gamma)
Root to leaf, lambda = S^-1 (J M^-1 f + K a_parent - gamma) and a = M^-1 (f - J^T lambda). This is block
Gaussian elimination of [M Cq^T; Cq 0] (Fox 1999 eq 9) in tree order: no fill outside the blocks. Closures of loops
are eliminated on the way (mbs_ref.kernels.rigid.elimination).
"""

from __future__ import annotations

from mbs_ref.kernels.algebra.ldl import ldl3, ldl3_solve
from mbs_ref.kernels.jit import jit, placed
from mbs_ref.kernels.planar.model import RATES
from mbs_ref.kernels.rigid import elimination
from mbs_ref.kernels.rigid.model import bodies_of, closures_of, rows_of, slots_of, tree_of


@jit
def factor_tree(model, work, loops):
    """Factor every body's block and joint, leaf to root, and the closures at their apexes.

    `loops` is None in open trees, and for them no code that stands behind `loops is not None` is compiled.
    """
    bodies, slots, tree, rows = bodies_of(model), slots_of(model), tree_of(work), rows_of(work)
    n = bodies.mass.shape[0]
    if loops is not None:
        elimination.begin_closures(model, work)
    for i in range(n):
        art = tree.articulated[i]
        art[0, 0] = bodies.mass[i]
        art[1, 0] = 0.0
        art[1, 1] = bodies.mass[i]
        art[2, 0] = 0.0
        art[2, 1] = 0.0
        art[2, 2] = bodies.inertia[i]
    for i in range(n - 1, -1, -1):
        art = tree.articulated[i]
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.eliminate_closures(model, work, i)
        m = ldl3(art[0, 0], art[1, 0], art[1, 1], art[2, 0], art[2, 1], art[2, 2])
        for c in range(6):
            tree.mass_factor[i, c] = m[c]
        jac = rows.jacobian[i, 0]
        far = rows.jacobian[i, 1]
        # lift = M^-1 J^T, one column a row of J
        a0, a1, a2 = ldl3_solve(m[0], m[1], m[2], m[3], m[4], m[5], jac[0, 0], jac[0, 1], jac[0, 2])
        b0, b1, b2 = ldl3_solve(m[0], m[1], m[2], m[3], m[4], m[5], jac[1, 0], jac[1, 1], jac[1, 2])
        c0, c1, c2 = ldl3_solve(m[0], m[1], m[2], m[3], m[4], m[5], jac[2, 0], jac[2, 1], jac[2, 2])
        lift = tree.lift[i]
        lift[0, 0], lift[1, 0], lift[2, 0] = a0, a1, a2
        lift[0, 1], lift[1, 1], lift[2, 1] = b0, b1, b2
        lift[0, 2], lift[1, 2], lift[2, 2] = c0, c1, c2
        padding = slots.padding[i]
        s = ldl3(
            jac[0, 0] * a0 + jac[0, 1] * a1 + jac[0, 2] * a2 + padding[0],
            jac[1, 0] * a0 + jac[1, 1] * a1 + jac[1, 2] * a2,
            jac[1, 0] * b0 + jac[1, 1] * b1 + jac[1, 2] * b2 + padding[1],
            jac[2, 0] * a0 + jac[2, 1] * a1 + jac[2, 2] * a2,
            jac[2, 0] * b0 + jac[2, 1] * b1 + jac[2, 2] * b2,
            jac[2, 0] * c0 + jac[2, 1] * c1 + jac[2, 2] * c2 + padding[2],
        )
        for c in range(6):
            tree.row_factor[i, c] = s[c]
        p = bodies.parent[i]
        if p != n:
            transfer = tree.transfer[i]
            for c in range(3):
                x0, x1, x2 = ldl3_solve(s[0], s[1], s[2], s[3], s[4], s[5], far[0, c], far[1, c], far[2, c])
                transfer[0, c], transfer[1, c], transfer[2, c] = x0, x1, x2
            up = tree.articulated[p]
            for r in range(3):
                for c in range(r + 1):
                    up[r, c] += far[0, r] * transfer[0, c] + far[1, r] * transfer[1, c] + far[2, r] * transfer[2, c]
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.pass_rows(model, work, i)
    if loops is not None:
        elimination.eliminate_closures(model, work, n)


@jit
def _put_answer(tree, i, multiplier, out):
    """a = M^-1 (f - J^T lambda)."""
    free, lift = tree.free[i], tree.lift[i]
    for r in range(3):
        out[r] = free[r] - (lift[r, 0] * multiplier[0] + lift[r, 1] * multiplier[1] + lift[r, 2] * multiplier[2])


@jit
def solve_tree(model, work, loops, gamma, acceleration, multiplier):
    """Solve with the forces in the tree's load (overwritten) and the rows' right-hand side `gamma`.

    acceleration (n + 1, 3) and multiplier (n_slots, 3) receive the result; ground's row stays zero.
    """
    bodies, tree, rows = bodies_of(model), tree_of(work), rows_of(work)
    closures = closures_of(work)
    n = bodies.mass.shape[0]
    load = tree.load
    if loops is not None:
        elimination.start_rows(RATES, loops, closures, gamma)
    for i in range(n - 1, -1, -1):
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.condense(RATES, loops, closures, i, load[i])
        m = tree.mass_factor[i]
        s = tree.row_factor[i]
        jac = rows.jacobian[i, 0]
        f0, f1, f2 = ldl3_solve(m[0], m[1], m[2], m[3], m[4], m[5], load[i, 0], load[i, 1], load[i, 2])
        tree.free[i, 0] = f0
        tree.free[i, 1] = f1
        tree.free[i, 2] = f2
        u0, u1, u2 = ldl3_solve(
            s[0], s[1], s[2], s[3], s[4], s[5],
            jac[0, 0] * f0 + jac[0, 1] * f1 + jac[0, 2] * f2 - gamma[i, 0],
            jac[1, 0] * f0 + jac[1, 1] * f1 + jac[1, 2] * f2 - gamma[i, 1],
            jac[2, 0] * f0 + jac[2, 1] * f1 + jac[2, 2] * f2 - gamma[i, 2],
        )  # fmt: skip
        multiplier[i, 0] = u0
        multiplier[i, 1] = u1
        multiplier[i, 2] = u2
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_free(RATES, loops, closures, i, load[i], gamma[i])
        p = bodies.parent[i]
        if p == n:
            continue
        far = rows.jacobian[i, 1]
        for c in range(3):
            load[p, c] -= far[0, c] * u0 + far[1, c] * u1 + far[2, c] * u2
    if loops is not None:
        elimination.condense(RATES, loops, closures, n, load[n])
        elimination.substitute(RATES, loops, closures, n, acceleration[n], multiplier)
    for i in range(n):
        p = bodies.parent[i]
        if p != n:
            transfer = tree.transfer[i]
            for r in range(3):
                multiplier[i, r] += (
                    transfer[r, 0] * acceleration[p, 0]
                    + transfer[r, 1] * acceleration[p, 1]
                    + transfer[r, 2] * acceleration[p, 2]
                )
        _put_answer(tree, i, multiplier[i], acceleration[i])
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_closures(RATES, loops, closures, i, acceleration[i], multiplier[i])
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.substitute(RATES, loops, closures, i, acceleration[i], multiplier)


# --- closures of loops (mbs_ref.kernels.rigid.elimination) ------------------------------------------


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
