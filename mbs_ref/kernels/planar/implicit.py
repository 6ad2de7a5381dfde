"""What methods on the DAE itself need: force balance, Newton corrections in (qdd, lambda).

One correction solves [M + g C_t + b K_t, C_q^T; C_q, 0][d_qdd; d_lambda] = [f - M qdd - C_q^T lambda; -C/b]
with b = dq/dqdd and g = dv/dqdd of the method. The cheap correction keeps M alone and runs along the
joint tree in O(N); the full one forms the tangent by differences, and is dense.
"""

from __future__ import annotations

from mbs_ref.kernels.dense import lu_factor, lu_solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.contact_rows import fill_rows
from mbs_ref.kernels.planar.dynamics import factor, load_state, solve
from mbs_ref.kernels.planar.loads import apply_loads
from mbs_ref.kernels.planar.model import bodies_of, kinematics_of, rows_of, slots_of, tree_of

PROXIMAL = 1e-12  # weight on the multipliers' diagonal: dependent rows then share, instead of failing


@jit
def planar_force_balance(model, work, t, y, lam, out):
    """Write f - C_q^T lambda (3 n,) in scene order and leave C, C_dot and C_q in `work`."""
    bodies, slots, rows, kin = bodies_of(model), slots_of(model), rows_of(work), kinematics_of(work)
    load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    n = bodies.mass.shape[0]
    for slot in range(slots.body.shape[0]):
        for side in range(2):
            body = slots.body[slot, side]
            for row in range(3):
                for c in range(3):
                    kin.force[body, c] -= rows.jacobian[slot, side, row, c] * lam[slot, row]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            out[k + c] = kin.force[i, c]
    for c in range(3):
        kin.force[n, c] = 0.0


@jit
def _largest_defect(rows, velocity_level):
    largest = 0.0
    defect = rows.rate if velocity_level else rows.residual
    for slot in range(defect.shape[0]):
        for row in range(3):
            if not abs(defect[slot, row]) <= largest:
                largest = abs(defect[slot, row])
    return largest


@jit
def planar_tree_correction(model, work, t, y, qdd, lam, weight, velocity_level):
    """Correct qdd (3 n,) and lam (n_slots, 3) with the mass matrix alone; return |d_qdd| and max defect."""
    bodies, rows, tree = bodies_of(model), rows_of(work), tree_of(work)
    n = bodies.mass.shape[0]
    balance = tree.load
    scratch = qdd.copy()
    planar_force_balance(model, work, t, y, lam, scratch)
    defect_size = _largest_defect(rows, velocity_level)
    factor(model, work)
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            mass = bodies.inertia[i] if c == 2 else bodies.mass[i]
            balance[i, c] = scratch[k + c] - mass * qdd[k + c]
    defect = rows.rate if velocity_level else rows.residual
    for slot in range(defect.shape[0]):
        for row in range(3):
            rows.gamma[slot, row] = -defect[slot, row] / weight
    solve(model, work, rows.gamma)
    largest = 0.0
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        for c in range(3):
            qdd[k + c] += tree.acceleration[i, c]
            if not abs(tree.acceleration[i, c]) <= largest:
                largest = abs(tree.acceleration[i, c])
    for slot in range(lam.shape[0]):
        for row in range(3):
            lam[slot, row] += rows.multiplier[slot, row]
    return largest, defect_size


@jit
def planar_tangent_matrix(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, out):
    """Fill out (3 n + m, 3 n + m) with the full Newton matrix; row_slot, row_row (m,) name the rows in use."""
    bodies, slots, rows = bodies_of(model), slots_of(model), rows_of(work)
    n = bodies.mass.shape[0]
    size = 3 * n
    base, shifted = y[:size].copy(), y[:size].copy()
    state = y.copy()
    planar_force_balance(model, work, t, y, lam, base)
    out[:] = 0.0
    for r in range(row_slot.shape[0]):
        slot, row = row_slot[r], row_row[r]
        for side in range(2):
            body = slots.body[slot, side]
            if body < n:
                k = 3 * bodies.scene_index[body]
                for c in range(3):
                    out[size + r, k + c] += rows.jacobian[slot, side, row, c]
                    out[k + c, size + r] += rows.jacobian[slot, side, row, c]
        out[size + r, size + r] = -PROXIMAL
    for j in range(size):
        delta = 1e-7
        state[j] = y[j] + delta * by_position
        state[size + j] = y[size + j] + delta * by_velocity
        planar_force_balance(model, work, t, state, lam, shifted)
        for i in range(size):
            out[i, j] -= (shifted[i] - base[i]) / delta
        state[j] = y[j]
        state[size + j] = y[size + j]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        out[k, k] += bodies.mass[i]
        out[k + 1, k + 1] += bodies.mass[i]
        out[k + 2, k + 2] += bodies.inertia[i]


@jit
def planar_dense_correction(model, work, t, y, qdd, lam, weight, velocity_level, row_slot, row_row, lu, pivots):
    """Correct qdd and lam with the factored full Newton matrix; return |d_qdd| and max defect."""
    bodies, rows = bodies_of(model), rows_of(work)
    n = bodies.mass.shape[0]
    size = 3 * n
    rhs = y[:1].repeat(size + row_slot.shape[0])
    planar_force_balance(model, work, t, y, lam, rhs[:size])
    defect_size = _largest_defect(rows, velocity_level)
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        rhs[k] -= bodies.mass[i] * qdd[k]
        rhs[k + 1] -= bodies.mass[i] * qdd[k + 1]
        rhs[k + 2] -= bodies.inertia[i] * qdd[k + 2]
    defect = rows.rate if velocity_level else rows.residual
    for r in range(row_slot.shape[0]):
        rhs[size + r] = -defect[row_slot[r], row_row[r]] / weight
    lu_solve(lu, pivots, rhs)
    largest = 0.0
    for k in range(size):
        qdd[k] += rhs[k]
        if not abs(rhs[k]) <= largest:
            largest = abs(rhs[k])
    for r in range(row_slot.shape[0]):
        lam[row_slot[r], row_row[r]] += rhs[size + r]
    return largest, defect_size


@jit
def planar_factor_tangent(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots):
    """Form and factor the full Newton matrix; return False where it is singular."""
    planar_tangent_matrix(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu)
    return lu_factor(lu, pivots)
