"""A spatial scene as methods on the DAE itself see it: balances, masses and rows, all in the state's order.

Rates are (R', omega) with omega in body axes, where the inertia is constant. Orientations are moved by
theta exp(turn / 2), a turn in body axes (Bruls and Cardona, J. Comput. Nonlinear Dyn. 5 (2010) 031002): the
norm stays one, and needs no multiplier.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rows import take_reactions
from mbs_ref.kernels.spatial.model import bodies_of, kinematics_of, rows_of, slots_of, tree_of
from mbs_ref.kernels.spatial.orientation import load_state, parameters, put_parameters
from mbs_ref.kernels.spatial.vectors import add, dot, put, symmetric_times, times, triple, turn, turn_back


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
    fill_rows(model, work, t)
    take_reactions(kin.force, slots.body, rows.jacobian, lam)
    kin.force[bodies.mass.shape[0]] = 0.0
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
            put(out, k + 3, turn_back(kin.turned[i], triple(world[i], 3)))


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
            put(out, k + 3, symmetric_times(bodies.inertia[i], triple(rate, k + 3)))


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
            put(tree.load[i], 3, turn(kin.turned[i], triple(balance, k + 3)))
    solve(model, work, rows_of(work).gamma)
    _to_body(model, work, tree.acceleration, out)


@jit
def spatial_row_times(model, work, slot, row, rate):
    """Return one constraint row applied to rates."""
    bodies, kin, slots, rows = bodies_of(model), kinematics_of(work), slots_of(model), rows_of(work)
    start = spatial_position_count(model)
    total = 0.0
    for side in range(2):
        body = slots.body[slot, side]
        if body < bodies.mass.shape[0]:
            k = bodies.v[body] - start
            g = rows.jacobian[slot, side, row]
            total += dot(g, triple(rate, k))
            if bodies.rigid[body] == 1:
                total += dot(triple(g, 3), turn(kin.turned[body], triple(rate, k + 3)))
    return total


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
            add(out, k, times(factor, g))
            if bodies.rigid[body] == 1:
                add(out, k + 3, times(factor, turn_back(kin.turned[body], triple(g, 3))))


@jit
def _parameters_times(theta, s, v):
    """Return the product of theta and the quaternion (s, v)."""
    e0, e1, e2, e3 = theta
    x, y, z = v
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
            turning = triple(move, k + 3)
            half = 0.5 * np.sqrt(dot(turning, turning))
            s = 0.5 if half < 1e-8 else 0.5 * np.sin(half) / half
            put_parameters(out, q + 3, _parameters_times(parameters(y, q + 3), np.cos(half), times(s, turning)))


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
            half = times(0.5, triple(rate, k + 3))
            put_parameters(out, q + 3, _parameters_times(parameters(y, q + 3), 0.0, half))


@jit
def spatial_defect_of(work, velocity_level):
    """Return C or C_dot (n_slots, 6)."""
    rows = rows_of(work)
    return rows.rate if velocity_level else rows.residual


@jit
def spatial_gamma_of(work):
    """Return gamma (n_slots, 6)."""
    return rows_of(work).gamma
