"""A spatial scene as methods on the DAE itself see it: balances, masses and rows, all in the state's order.

Rates are (R', omega) with omega in body axes, where the inertia is constant. Orientations are moved by
theta exp(turn / 2), a turn in body axes (Bruls and Cardona, J. Comput. Nonlinear Dyn. 5 (2010) 031002): the
norm stays one, and needs no multiplier.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.spatial.contacts import apply_contacts
from mbs_ref.kernels.spatial.model import bodies_of, kinematics_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.spatial.orientation import load_state
from mbs_ref.kernels.spatial.vectors import symmetric_times, turn, turn_back


@jit
def spatial_position_count(model):
    """Return the entries of the state that are positions and orientations; rates follow."""
    rigid = bodies_of(model).rigid
    total = 0
    for i in range(rigid.shape[0]):
        total += 7 if rigid[i] == 1 else 3
    return total


@jit
def spatial_force_balance(model, work, t, y, lam, out):
    """Write f - C_q^T lambda, torques in body axes, and leave C, C_dot and C_q in `work`."""
    bodies, slots, rows, kin = bodies_of(model), slots_of(model), rows_of(work), kinematics_of(work)
    load_state(model, work, y)
    apply_loads(model, work, t)
    apply_contacts(model, work)
    fill_rows(model, work, t)
    n = bodies.mass.shape[0]
    for slot in range(slots.body.shape[0]):
        for side in range(2):
            body = slots.body[slot, side]
            for row in range(slots.count[slot]):
                for c in range(6):
                    kin.force[body, c] -= rows.jacobian[slot, side, row, c] * lam[slot, row]
    for c in range(6):
        kin.force[n, c] = 0.0
    _to_body(model, work, kin.force, out)


@jit
def _to_body(model, work, world, out):
    """Write vectors (n + 1, 6) in world axes and elimination order as the state has rates."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    start = spatial_position_count(model)
    for i in range(bodies.mass.shape[0]):
        k = bodies.v[i] - start
        for c in range(3):
            out[k + c] = world[i, c]
        if bodies.rigid[i] == 1:
            out[k + 3], out[k + 4], out[k + 5] = turn_back(kin.turned[i], world[i, 3], world[i, 4], world[i, 5])


@jit
def spatial_times_mass(model, rate, out):
    """Write M rate."""
    bodies = bodies_of(model)
    start = spatial_position_count(model)
    for i in range(bodies.mass.shape[0]):
        k = bodies.v[i] - start
        for c in range(3):
            out[k + c] = bodies.mass[i] * rate[k + c]
        if bodies.rigid[i] == 1:
            out[k + 3], out[k + 4], out[k + 5] = symmetric_times(
                bodies.inertia[i], rate[k + 3], rate[k + 4], rate[k + 5]
            )


@jit
def spatial_answer(model, work, balance, out):
    """Solve the augmented system for a balance and the gamma in `work`; write the accelerations to out."""
    bodies, kin, tree = bodies_of(model), kinematics_of(work), tree_of(work)
    start = spatial_position_count(model)
    factor(model, work)
    for i in range(bodies.mass.shape[0]):
        k = bodies.v[i] - start
        for c in range(3):
            tree.load[i, c] = balance[k + c]
            tree.load[i, 3 + c] = 0.0
        if bodies.rigid[i] == 1:
            tree.load[i, 3], tree.load[i, 4], tree.load[i, 5] = turn(kin.turned[i], balance[k + 3 : k + 6])
    solve(model, work, rows_of(work).gamma)
    _to_body(model, work, tree.acceleration, out)


@jit
def _row_times(model, work, slot, row, rate):
    """Return one constraint row applied to rates."""
    bodies, kin, slots, rows = bodies_of(model), kinematics_of(work), slots_of(model), rows_of(work)
    start = spatial_position_count(model)
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < bodies.mass.shape[0]:
            k = bodies.v[body] - start
            g = rows.jacobian[slot, side, row]
            total += g[0] * rate[k] + g[1] * rate[k + 1] + g[2] * rate[k + 2]
            if bodies.rigid[body] == 1:
                w0, w1, w2 = turn(kin.turned[body], rate[k + 3 : k + 6])
                total += g[3] * w0 + g[4] * w1 + g[5] * w2
    return total


@jit
def spatial_rows_times(model, work, slots, rows, rate, out):
    """Write constraint rows applied to rates."""
    for r in range(slots.shape[0]):
        out[r] = _row_times(model, work, slots[r], rows[r], rate)


@jit
def spatial_add_row(model, work, slot, row, factor, out):
    """Add factor times one constraint row to out."""
    bodies, kin, slots, rows = bodies_of(model), kinematics_of(work), slots_of(model), rows_of(work)
    start = spatial_position_count(model)
    for side in range(2):
        body = slots.body[slot, side]
        if body < bodies.mass.shape[0]:
            k = bodies.v[body] - start
            g = rows.jacobian[slot, side, row]
            for c in range(3):
                out[k + c] += factor * g[c]
            if bodies.rigid[body] == 1:
                w0, w1, w2 = turn_back(kin.turned[body], g[3], g[4], g[5])
                out[k + 3] += factor * w0
                out[k + 4] += factor * w1
                out[k + 5] += factor * w2


@jit
def spatial_subtract_rows(model, work, slots, rows, factors, out):
    """Subtract constraint rows, each times its factor, from out."""
    for r in range(slots.shape[0]):
        spatial_add_row(model, work, slots[r], rows[r], -factors[r], out)


@jit
def _parameters_times(e0, e1, e2, e3, s, x, y, z):
    """Return the product of theta and the quaternion (s, x, y, z)."""
    return (
        e0 * s - e1 * x - e2 * y - e3 * z,
        e0 * x + e1 * s + e2 * z - e3 * y,
        e0 * y + e2 * s + e3 * x - e1 * z,
        e0 * z + e3 * s + e1 * y - e2 * x,
    )


@jit
def spatial_displace(model, y, move, out):
    """Write y's positions moved by `move`, turns in body axes, to out."""
    bodies = bodies_of(model)
    start = spatial_position_count(model)
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        k = bodies.v[i] - start
        for c in range(3):
            out[q + c] = y[q + c] + move[k + c]
        if bodies.rigid[i] == 1:
            square = move[k + 3] * move[k + 3] + move[k + 4] * move[k + 4] + move[k + 5] * move[k + 5]
            half = 0.5 * np.sqrt(square)
            s = 0.5 if half < 1e-8 else 0.5 * np.sin(half) / half
            out[q + 3], out[q + 4], out[q + 5], out[q + 6] = _parameters_times(
                y[q + 3], y[q + 4], y[q + 5], y[q + 6], np.cos(half), s * move[k + 3], s * move[k + 4], s * move[k + 5]
            )


@jit
def spatial_position_rate(model, y, rate, out):
    """Write the rates of positions and Euler parameters at `rate`: theta' = theta (0, omega) / 2."""
    bodies = bodies_of(model)
    start = spatial_position_count(model)
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        k = bodies.v[i] - start
        for c in range(3):
            out[q + c] = rate[k + c]
        if bodies.rigid[i] == 1:
            out[q + 3], out[q + 4], out[q + 5], out[q + 6] = _parameters_times(
                y[q + 3], y[q + 4], y[q + 5], y[q + 6], 0.0, 0.5 * rate[k + 3], 0.5 * rate[k + 4], 0.5 * rate[k + 5]
            )


@jit
def spatial_defect_of(work, velocity_level):
    """Return C or C_dot (n_slots, 6)."""
    rows = rows_of(work)
    return rows.rate if velocity_level else rows.residual


@jit
def spatial_gamma_of(work):
    """Return gamma (n_slots, 6)."""
    return rows_of(work).gamma
