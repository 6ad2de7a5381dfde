"""The blocks of the elimination along the joint tree (mbs_ref.kernels.rigid.dynamics), 6 x 6 in space.

With Euler parameters a body's part of the augmented matrix (Fox 1999 eq 9 and appendix) is, with omega = 2 E theta',
E theta = 0, E E^T = I and nu the multiplier of theta^T theta = 1,

    [ 4 E^T J E   2 theta ] [ theta'' ]   [ 2 E^T (tau - omega x J omega) ]
    [ 2 theta^T   0       ] [ nu      ] = [ -2 theta'^T theta'            ]

whose upper-left block is singular (rank 3), so that it is factored whole: alpha = 2 E theta'' and the first rows
times E / 2 give J alpha = tau - omega x J omega; theta'' = E^T alpha / 2 - theta |theta'|^2 keeps the last row, and
joint rows in theta'' are rows in omega times 2 E. Eliminating the four parameters and their norm row first is
thus exact and leaves the 6 x 6 block diag(m I, J) of (R'', alpha). A test forms the whole
matrix densely and compares.
"""

from mbs_ref.kernels.algebra.dense import factor_ldl, ldl3, ldl3_solve, solve_ldl
from mbs_ref.kernels.jit import jit, placed


@placed
def start_blocks(model, work):
    bodies, tree, kin = model.bodies, work.tree, work.kinematics
    for i in range(bodies.mass.shape[0]):
        art = tree.articulated[i]
        j = kin.inertia[i]
        if bodies.alone[i] == 1:
            art[3, 3], art[4, 3], art[4, 4], art[5, 3], art[5, 4], art[5, 5] = ldl3(j[0], j[3], j[1], j[4], j[5], j[2])
            continue
        for r in range(6):
            for c in range(r + 1):
                art[r, c] = 0.0
        for r in range(3):
            art[r, r] = bodies.mass[i]
        art[3, 3], art[4, 4], art[5, 5] = j[0], j[1], j[2]
        art[4, 3], art[5, 3], art[5, 4] = j[3], j[4], j[5]


@jit
def _factor_rows(jac, lift, factor, count):
    """Factor S = J M^-1 J^T of one joint."""
    for r in range(count):
        for s in range(r + 1):
            total = 0.0
            for c in range(6):
                total += jac[r, c] * lift[s, c]
            factor[r, s] = total
    factor_ldl(factor, count)


@placed
def factor_body(model, work, i, parent):
    if model.bodies.alone[i] == 1:
        return
    tree, jac, count = work.tree, work.rows.jacobian[i, 0], model.slots.count[i]
    art, lift = tree.articulated[i], tree.lift[i]
    factor_ldl(art, 6)
    for r in range(count):
        for c in range(6):
            lift[r, c] = jac[r, c]
        solve_ldl(art, 6, lift[r])
    _factor_rows(jac, lift, tree.row_factor[i], count)
    if parent == model.bodies.mass.shape[0]:
        return
    far, transfer, up = work.rows.jacobian[i, 1], tree.transfer[i], tree.articulated[parent]
    for r in range(count):
        for c in range(6):
            transfer[r, c] = far[r, c]
    _solve_rows(tree.row_factor[i], count, transfer)
    for k in range(count):
        for r in range(6):
            weight = far[k, r]
            for c in range(r + 1):
                up[r, c] += weight * transfer[k, c]


@placed
def solve_free(model, work, i, parent, gamma, multiplier):
    if model.bodies.alone[i] == 1:
        return
    tree, jac, far = work.tree, work.rows.jacobian[i, 0], work.rows.jacobian[i, 1]
    free, count = tree.free[i], model.slots.count[i]
    for c in range(6):
        free[c] = tree.load[i, c]
    solve_ldl(tree.articulated[i], 6, free)
    for r in range(count):
        total = -gamma[r]
        for c in range(6):
            total += jac[r, c] * free[c]
        multiplier[r] = total
    solve_ldl(tree.row_factor[i], count, multiplier)
    if parent != model.bodies.mass.shape[0]:
        for r in range(count):
            for c in range(6):
                tree.load[parent, c] -= far[r, c] * multiplier[r]


@jit
def _accelerate_alone(mass, art, load, out):
    """a = f / m, alpha = J^-1 tau of a body without joints."""
    for c in range(3):
        out[c] = load[c] / mass
    out[3], out[4], out[5] = ldl3_solve(
        art[3, 3], art[4, 3], art[4, 4], art[5, 3], art[5, 4], art[5, 5], load[3], load[4], load[5]
    )


@placed
def accelerate_body(model, work, i, parent, multiplier, acceleration):
    bodies, tree, out, count = model.bodies, work.tree, acceleration[i], model.slots.count[i]
    if bodies.alone[i] == 1:
        _accelerate_alone(bodies.mass[i], tree.articulated[i], tree.load[i], out)
        return
    if parent != bodies.mass.shape[0]:
        for r in range(count):
            total = 0.0
            for c in range(6):
                total += tree.transfer[i, r, c] * acceleration[parent, c]
            multiplier[r] += total
    for c in range(6):
        out[c] = tree.free[i, c]
    for r in range(count):
        u = multiplier[r]
        for c in range(6):
            out[c] -= tree.lift[i, r, c] * u


@jit
def plus_mobility(model, work, total, i, row):
    """A body counts as a sphere."""
    j = work.kinematics.inertia[i]
    total += (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]) / model.bodies.mass[i]
    return total + 3.0 * (row[3] * row[3] + row[4] * row[4] + row[5] * row[5]) / (j[0] + j[1] + j[2])


@placed
def pass_closure(model, work, i, here, there, _count):
    """Condense body i under one closure, all of whose rows go through the same steps at once."""
    tree, rows, closures, count = work.tree, work.rows, work.closures, model.slots.count[i]
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
