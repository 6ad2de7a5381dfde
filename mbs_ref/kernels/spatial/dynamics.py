"""The spatial system as an ODE, its constraints, and their coordinate projection.

State y = [q, u, s] in scene order: q = R, theta0..theta3 of a rigid body and R of a point mass, u = R', omega
and R', s the deflections of contacts that can stick. The state holds omega in body axes: on a free top at rtol
1e-12 that is 500 times more accurate than in world axes, where a steady spin already moves omega; everything
else is in world axes. The index-3 DAE is reduced to its underlying ODE (Fox 1999 eq 9; Fox 2001 eq 19),
optionally with Baumgarte's terms.
theta^T theta = 1 is part of C; its multiplier and the four parameters are eliminated exactly (see `tree`),
and projection restores it.
"""

from __future__ import annotations

from mbs_ref.kernels.border.questions import accelerate, fill_deflection_rates, fill_rows
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid.elimination import rows_times
from mbs_ref.kernels.rigid.reduction import project_by, reduce_to_accelerations, refine_by, respond
from mbs_ref.kernels.rows import (
    copy_rows,
    largest_entry,
)
from mbs_ref.kernels.spatial.joints import leave_slips
from mbs_ref.kernels.spatial.model import (
    RATES,
    bodies_of,
    closures_of,
    kinematics_of,
    loops_of,
    rows_of,
    slots_of,
    tree_of,
    world_of,
)
from mbs_ref.kernels.spatial.orientation import (
    load_state,
    parameters,
    put_parameters,
    theta_rate,
    turn_theta,
    turning_of,
)
from mbs_ref.kernels.spatial.tree import factor_tree, solve_tree
from mbs_ref.kernels.spatial.vectors import add, minus, put, symmetric_times, triple, turn, turn_back


@jit
def spatial_factor(model, work):
    """Factor the augmented matrix at the Jacobians in `work`."""
    factor_tree(model, work, loops_of(model))


@jit
def spatial_solve(model, work, gamma):
    """Solve the augmented system for the tree's load and `gamma` into its acceleration and the multipliers."""
    solve_tree(model, work, loops_of(model), gamma, tree_of(work).acceleration, rows_of(work).multiplier)


@jit
def spatial_factor_open(model, work):
    """The same of a tree without closed loops."""
    factor_tree(model, work, None)


@jit
def spatial_solve_open(model, work, gamma):
    """The same of a tree without closed loops."""
    solve_tree(model, work, None, gamma, tree_of(work).acceleration, rows_of(work).multiplier)


@jit
def _leave_inertia(model, work, acceleration, load):
    """Write f - M a into load."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    for i in range(bodies.mass.shape[0]):
        for c in range(3):
            load[i, c] = kin.force[i, c] - bodies.mass[i] * acceleration[i, c]
        put(load[i], 3, minus(triple(kin.force[i], 3), symmetric_times(kin.inertia[i], triple(acceleration[i], 3))))


@jit
def _refine(model, work):
    refine_by(model, work, _leave_inertia, slots_of(model).body, rows_of(work), tree_of(work))


@jit
def spatial_accelerate(model, work, t, y):
    """Compute accelerations and multipliers at (t, y) into `work`; norms act on nothing, and need no stabilization."""
    reduce_to_accelerations(
        model, work, t, y, load_state, _refine,
        world_of(model).control, kinematics_of(work).force, rows_of(work), tree_of(work), closures_of(work),
    )  # fmt: skip


@jit
def spatial_derivative(model, work, t, y, dy):
    """Write dy/dt = [R', E^T omega / 2; R'', alpha]."""
    accelerate(model, work, t, y)
    bodies, kin, acceleration = bodies_of(model), kinematics_of(work), tree_of(work).acceleration
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        v = bodies.v[i]
        for c in range(3):
            dy[q + c] = y[v + c]
            dy[v + c] = acceleration[i, c]
        if bodies.rigid[i] == 1:
            put_parameters(dy, q + 3, theta_rate(parameters(y, q + 3), triple(kin.omega[i], 0)))
            # omega_body' = A^T alpha: the body axes' own turning drops out
            put(dy, v + 3, turn_back(kin.turned[i], triple(acceleration[i], 3)))
    fill_deflection_rates(model, work, dy)


@jit
def spatial_compliance(model, work, t, y):
    """Return max |C| with the norm constraints and max |C_dot| over all rows (m, rad; m/s, rad/s)."""
    load_state(model, work, y)
    fill_rows(model, work, t)
    return max(largest_entry(rows_of(work).residual), _largest_norm(model, work)), largest_entry(rows_of(work).rate)


@jit
def spatial_regularity(work):
    """Return the smallest relative closure pivot of the last factorization; 1 without closures."""
    return closures_of(work).regularity[0]


@jit
def spatial_multipliers(work, lam):
    """Copy the multipliers of the last solution into lam (n_slots, 6)."""
    copy_rows(rows_of(work).multiplier, lam)


@jit
def _largest_norm(model, work):
    largest = 0.0
    norm, rigid = kinematics_of(work).norm, bodies_of(model).rigid
    for i in range(rigid.shape[0]):
        if rigid[i] == 1 and not abs(norm[i]) <= largest:
            largest = abs(norm[i])
    return largest


@jit
def _correct_rates(model, work, y):
    """Add the correction in `work` to the rates in y."""
    bodies, kin, acceleration = bodies_of(model), kinematics_of(work), tree_of(work).acceleration
    for i in range(bodies.mass.shape[0]):
        v = bodies.v[i]
        add(y, v, acceleration[i])
        if bodies.rigid[i] == 1:
            add(y, v + 3, turn_back(kin.turned[i], triple(acceleration[i], 3)))


@jit
def _correct_places(model, work, y):
    """Move and turn the bodies in y by the correction in `work`."""
    bodies, acceleration = bodies_of(model), tree_of(work).acceleration
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        add(y, q, acceleration[i])
        if bodies.rigid[i] == 1:
            turn_theta(y, q + 3, triple(acceleration[i], 3))


@jit
def _removed(model, work, of_places):
    """Turn the increments in the tree's acceleration into the correction that lets them keep the rows.

    Increments of places may be off what rows on velocities alone ask for, and the correction leaves that as it is.
    """
    rows, tree = rows_of(work), tree_of(work)
    rows_times(RATES, slots_of(model).body, rows.jacobian, tree.acceleration, rows.rate)
    if of_places:
        leave_slips(model, rows.rate)
    respond(model, work, rows, tree, rows.rate)


@jit
def spatial_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints and the norms.

    Uses the factorization in `work`, of the last acceleration or projection.
    """
    bodies, kin, acceleration = bodies_of(model), kinematics_of(work), tree_of(work).acceleration
    n = bodies.mass.shape[0]
    for i in range(n):
        q = bodies.q[i]
        put(acceleration[i], 0, triple(x, q))
        if bodies.rigid[i] == 1:
            theta = parameters(kin.theta[i], 0)
            turning = turning_of(theta, parameters(x, q + 3))
            put(acceleration[i], 3, turning)
            put_parameters(x, q + 3, theta_rate(theta, turning))
    _removed(model, work, True)
    for i in range(n):
        q = bodies.q[i]
        add(x, q, acceleration[i])
        if bodies.rigid[i] == 1:
            change = theta_rate(parameters(kin.theta[i], 0), triple(acceleration[i], 3))
            for c in range(4):
                x[q + 3 + c] += change[c]
    for i in range(n):
        v = bodies.v[i]
        put(acceleration[i], 0, triple(x, v))
        if bodies.rigid[i] == 1:
            put(acceleration[i], 3, turn(kin.turned[i], triple(x, v + 3)))
    _removed(model, work, False)
    _correct_rates(model, work, x)


@jit
def _normalize(model, y):
    """Scale every body's Euler parameters to norm one: the orientation does not change."""
    bodies = bodies_of(model)
    for i in range(bodies.mass.shape[0]):
        if bodies.rigid[i] == 1:
            turn_theta(y, bodies.q[i] + 3, (0.0, 0.0, 0.0))


@jit
def spatial_project(model, work, t, y, tolerance, most):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one.
    """
    rows = rows_of(work)
    _normalize(model, y)
    load_state(model, work, y)
    if rows.residual.shape[0] == 0 or _no_rows(model):
        return _largest_norm(model, work)
    left = project_by(
        model, work, t, y, tolerance, most, load_state, _correct_places, _correct_rates, rows, tree_of(work)
    )
    return max(left, _largest_norm(model, work))


@jit
def _no_rows(model):
    alone = bodies_of(model).alone
    count = 0
    for i in range(alone.shape[0]):
        count += alone[i]
    return count == alone.shape[0]
