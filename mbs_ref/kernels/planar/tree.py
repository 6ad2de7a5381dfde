"""The blocks of the elimination along the joint tree (mbs_ref.kernels.rigid.dynamics), 3 x 3 in the plane.

Factors L D L^T lie in the lower triangles: L below the diagonal, and 1 / D on it.
"""

from mbs_ref.kernels.algebra.dense import factors_at, ldl3, ldl3_at, ldl3_solve, put_factors
from mbs_ref.kernels.algebra.lanes import vanishes
from mbs_ref.kernels.jit import bare, jit, placed

# Return row r of a times b.
_product = bare(lambda a, r, b: a[r, 0] * b[0] + a[r, 1] * b[1] + a[r, 2] * b[2])
# Return the pivot of an unused row, which keeps S regular; 0 for a row in use.
_idle = bare(lambda count, row: 1.0 if row >= count else 0.0)


@placed
def start_blocks(model, work):
    bodies, tree = model.bodies, work.tree
    for i in range(bodies.mass.shape[0]):
        art = tree.articulated[i]
        art[0, 0] = art[1, 1] = bodies.mass[i]
        art[1, 0] = art[2, 0] = art[2, 1] = 0.0
        art[2, 2] = bodies.inertia[i, 0]


@placed
def factor_body(model, work, i, parent):
    tree, jac, count = work.tree, work.rows.jacobian[i, 0], model.slots.count[i]
    art, lift = tree.articulated[i], tree.lift[i]
    m = ldl3_at(art, 0)
    put_factors(art, 0, m)
    a, b, c = ldl3_solve(m, jac[0]), ldl3_solve(m, jac[1]), ldl3_solve(m, jac[2])  # columns of M^-1 J^T
    for r in range(3):
        lift[r, 0], lift[r, 1], lift[r, 2] = a[r], b[r], c[r]
    s = ldl3(
        _product(jac, 0, a) + _idle(count, 0),
        _product(jac, 1, a),
        _product(jac, 1, b) + _idle(count, 1),
        _product(jac, 2, a),
        _product(jac, 2, b),
        _product(jac, 2, c) + _idle(count, 2),
    )
    put_factors(tree.row_factor[i], 0, s)
    if parent == model.bodies.mass.shape[0]:
        return
    far, transfer, up = work.rows.jacobian[i, 1], tree.transfer[i], tree.articulated[parent]
    for c in range(3):
        transfer[0, c], transfer[1, c], transfer[2, c] = ldl3_solve(s, (far[0, c], far[1, c], far[2, c]))
    for r in range(3):
        for c in range(r + 1):
            up[r, c] += far[0, r] * transfer[0, c] + far[1, r] * transfer[1, c] + far[2, r] * transfer[2, c]


@placed
def solve_free(model, work, i, parent, gamma, multiplier):
    tree, jac, far = work.tree, work.rows.jacobian[i, 0], work.rows.jacobian[i, 1]
    load, free = tree.load[i], tree.free[i]
    f = ldl3_solve(factors_at(tree.articulated[i], 0), load)
    free[0], free[1], free[2] = f
    rest = _product(jac, 0, f) - gamma[0], _product(jac, 1, f) - gamma[1], _product(jac, 2, f) - gamma[2]
    u = ldl3_solve(factors_at(tree.row_factor[i], 0), rest)
    multiplier[0], multiplier[1], multiplier[2] = u
    if parent != model.bodies.mass.shape[0]:
        for c in range(3):
            tree.load[parent, c] -= far[0, c] * u[0] + far[1, c] * u[1] + far[2, c] * u[2]


@placed
def accelerate_body(model, work, i, parent, multiplier, acceleration):
    tree, out = work.tree, acceleration[i]
    if parent != model.bodies.mass.shape[0]:
        for r in range(3):
            multiplier[r] += _product(tree.transfer[i], r, acceleration[parent])
    for r in range(3):
        out[r] = tree.free[i, r] - _product(tree.lift[i], r, multiplier)


@jit
def plus_mobility(model, work, total, i, row):
    if vanishes(row[0]) and vanishes(row[1]) and vanishes(row[2]):
        return total  # an open contact's: most are
    bodies = model.bodies
    return total + ((row[0] * row[0] + row[1] * row[1]) / bodies.mass[i] + row[2] * row[2] / bodies.inertia[i, 0])


@placed
def pass_closure(model, work, i, here, there, count):
    tree, closures = work.tree, work.closures
    lift, transfer = tree.lift[i], tree.transfer[i]
    m, s = factors_at(tree.articulated[i], 0), factors_at(tree.row_factor[i], 0)
    joint, column = closures.joint[here], closures.column[here]
    for r in range(count):
        p0, p1, p2 = closures.passed[here, 0, r], closures.passed[here, 1, r], closures.passed[here, 2, r]
        w0 = lift[0, 0] * p0 + lift[1, 0] * p1 + lift[2, 0] * p2
        w1 = lift[0, 1] * p0 + lift[1, 1] * p1 + lift[2, 1] * p2
        w2 = lift[0, 2] * p0 + lift[1, 2] * p1 + lift[2, 2] * p2
        if there >= 0:
            for c in range(3):
                closures.passed[there, c, r] -= transfer[0, c] * w0 + transfer[1, c] * w1 + transfer[2, c] * w2
        v = ldl3_solve(m, (p0, p1, p2))
        u = ldl3_solve(s, (w0, w1, w2))
        for c in range(3):
            joint[c, r] = u[c]
            column[c, r] = v[c] - _product(lift, c, u)
