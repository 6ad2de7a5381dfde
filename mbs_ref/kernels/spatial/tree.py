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

from mbs_ref.kernels.algebra.dense import factor3, factor6, factors_at, ldl3, ldl3_solve, put_factors, solve3, solve6
from mbs_ref.kernels.jit import jit, placed
from mbs_ref.kernels.spatial.marks import put, triple


@placed
def start_blocks(model, work):
    bodies, tree, kin = model.bodies, work.tree, work.kinematics
    for i in range(bodies.mass.shape[0]):
        art = tree.articulated[i]
        j = kin.inertia[i]
        if bodies.alone[i] == 1:
            put_factors(art, 3, ldl3(j[0], j[3], j[1], j[4], j[5], j[2]))
            continue
        for r in range(6):
            for c in range(r + 1):
                art[r, c] = 0.0
        for r in range(3):
            art[r, r] = bodies.mass[i]
        art[3, 3], art[4, 4], art[5, 5] = j[0], j[1], j[2]
        art[4, 3], art[5, 3], art[5, 4] = j[3], j[4], j[5]


_dot6 = jit(lambda a, b: a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5])


@jit
def _factor_rows(jac, lift, factor, count):
    """Factor S = J M^-1 J^T of one joint; of rows that it lacks, which are zero, the pivot is 1."""
    for r in range(3):
        for s in range(r + 1):
            factor[r, s] = _dot6(jac[r], lift[s])
    if count > 3:
        for r in range(3, 6):
            for s in range(r + 1):
                factor[r, s] = _dot6(jac[r], lift[s])
    for r in range(count, 6):
        factor[r, r] = 1.0
    if count > 3:
        factor6(factor)
    else:
        factor3(factor)


@jit
def _solve_rows(factor, count, b0, b1, b2, b3, b4, b5):
    """Return S^-1 b."""
    if count > 3:
        top, bottom = solve6(factor, (b0, b1, b2), (b3, b4, b5))
        return (*top, *bottom)
    return (*solve3(factor, (b0, b1, b2)), b3, b4, b5)


@placed
def factor_body(model, work, i, parent):
    if model.bodies.alone[i] == 1:
        return
    tree, jac, count = work.tree, work.rows.jacobian[i, 0], model.slots.count[i]
    art, lift = tree.articulated[i], tree.lift[i]
    factor6(art)
    for r in range(count):
        top, bottom = solve6(art, triple(jac[r], 0), triple(jac[r], 3))
        put(lift[r], 0, top)
        put(lift[r], 3, bottom)
    _factor_rows(jac, lift, tree.row_factor[i], count)
    if parent == model.bodies.mass.shape[0]:
        return
    far, transfer, up = work.rows.jacobian[i, 1], tree.transfer[i], tree.articulated[parent]
    for c in range(6):
        transfer[0, c], transfer[1, c], transfer[2, c], transfer[3, c], transfer[4, c], transfer[5, c] = _solve_rows(
            tree.row_factor[i], count, far[0, c], far[1, c], far[2, c], far[3, c], far[4, c], far[5, c]
        )
    for r in range(6):
        for c in range(r + 1):
            up[r, c] += far[0, r] * transfer[0, c] + far[1, r] * transfer[1, c] + far[2, r] * transfer[2, c]
    if count > 3:
        for r in range(6):
            for c in range(r + 1):
                up[r, c] += far[3, r] * transfer[3, c] + far[4, r] * transfer[4, c] + far[5, r] * transfer[5, c]


@placed
def solve_free(model, work, i, parent, gamma, multiplier):
    if model.bodies.alone[i] == 1:
        return
    tree, jac, far = work.tree, work.rows.jacobian[i, 0], work.rows.jacobian[i, 1]
    free, count = tree.free[i], model.slots.count[i]
    top, bottom = solve6(tree.articulated[i], triple(tree.load[i], 0), triple(tree.load[i], 3))
    put(free, 0, top)
    put(free, 3, bottom)
    u = _solve_rows(
        tree.row_factor[i], count, _dot6(jac[0], free) - gamma[0], _dot6(jac[1], free) - gamma[1],
        _dot6(jac[2], free) - gamma[2], _dot6(jac[3], free) - gamma[3], _dot6(jac[4], free) - gamma[4],
        _dot6(jac[5], free) - gamma[5],
    )  # fmt: skip
    for r in range(count):
        multiplier[r] = u[r]
    if parent != model.bodies.mass.shape[0]:
        for r in range(count):
            for c in range(6):
                tree.load[parent, c] -= far[r, c] * u[r]


@jit
def _accelerate_alone(mass, art, load, out):
    """a = f / m, alpha = J^-1 tau of a body without joints."""
    for c in range(3):
        out[c] = load[c] / mass
    put(out, 3, ldl3_solve(factors_at(art, 3), triple(load, 3)))


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
    passed = closures.passed[here]
    for r in range(6):
        top, bottom = (passed[0, r], passed[1, r], passed[2, r]), (passed[3, r], passed[4, r], passed[5, r])
        top, bottom = solve6(tree.articulated[i], top, bottom)
        column[0, r], column[1, r], column[2, r] = top
        column[3, r], column[4, r], column[5, r] = bottom
    jac = rows.jacobian[i, 0]
    for r in range(6):
        b = column[0, r], column[1, r], column[2, r], column[3, r], column[4, r], column[5, r]
        joint[0, r], joint[1, r], joint[2, r], joint[3, r], joint[4, r], joint[5, r] = _solve_rows(
            tree.row_factor[i], count, _dot6(jac[0], b), _dot6(jac[1], b), _dot6(jac[2], b), _dot6(jac[3], b),
            _dot6(jac[4], b), _dot6(jac[5], b),
        )  # fmt: skip
    for k in range(count):
        for c in range(6):
            for r in range(6):
                column[c, r] -= tree.lift[i, k, c] * joint[k, r]
    if there >= 0:
        for k in range(count):
            for c in range(6):
                for r in range(6):
                    closures.passed[there, c, r] -= rows.jacobian[i, 1, k, c] * joint[k, r]
