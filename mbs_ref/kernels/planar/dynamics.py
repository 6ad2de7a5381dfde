"""The planar system as an ODE, its constraints, and their coordinate projection.

State y = [q, v] in scene order, q_i = [Rx, Ry, theta]. The index-3 DAE is reduced to its underlying ODE
(Fox 1999 eq 9; Fox 2001 eq 19), optionally with Baumgarte's terms.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.algebra.refinement import refinements
from mbs_ref.kernels.border.questions import accelerate, apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.model import (
    RATES,
    bodies_of,
    closures_of,
    kinematics_of,
    rows_of,
    slots_of,
    tree_of,
    world_of,
)
from mbs_ref.kernels.planar.tree import factor_tree, solve_tree
from mbs_ref.kernels.rigid.elimination import row_times
from mbs_ref.kernels.rows import (
    add_to,
    clear,
    copy_rows,
    largest_entry,
    negate,
    stabilize,
    take_accelerations,
    take_reactions,
)


@jit
def load_state(model, work, y):
    """Copy the state into elimination order and turn angles into cosines and sines."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    n = bodies.mass.shape[0]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        angle = y[k + 2]
        kin.pose[i, 0] = y[k]
        kin.pose[i, 1] = y[k + 1]
        kin.pose[i, 2] = np.cos(angle)
        kin.pose[i, 3] = np.sin(angle)
        kin.motion[i, 0] = y[3 * n + k]
        kin.motion[i, 1] = y[3 * n + k + 1]
        kin.motion[i, 2] = y[3 * n + k + 2]
        kin.motion[i, 3] = angle


@jit
def planar_factor(model, work):
    """Factor the augmented matrix at the Jacobians in `work`."""
    factor_tree(model, work)


@jit
def planar_solve(model, work, gamma):
    """Solve the augmented system for the tree's load and `gamma` into its acceleration and the multipliers."""
    solve_tree(model, work, gamma, tree_of(work).acceleration, rows_of(work).multiplier)


@jit
def _refine(model, work):
    """Add to acceleration and multipliers what the residuals of both equations ask for."""
    bodies, slots, rows, tree = bodies_of(model), slots_of(model), rows_of(work), tree_of(work)
    force, load, acceleration = kinematics_of(work).force, tree.load, tree.acceleration
    first, multiplier, gamma = acceleration.copy(), rows.multiplier.copy(), rows.gamma.copy()
    for i in range(bodies.mass.shape[0]):
        load[i, 0] = force[i, 0] - bodies.mass[i] * first[i, 0]
        load[i, 1] = force[i, 1] - bodies.mass[i] * first[i, 1]
        load[i, 2] = force[i, 2] - bodies.inertia[i] * first[i, 2]
    take_reactions(load, slots.body, rows.jacobian, multiplier)
    take_accelerations(gamma, slots.body, rows.jacobian, first)
    solve(model, work, gamma)
    add_to(acceleration, first)
    add_to(rows.multiplier, multiplier)


@jit
def planar_accelerate(model, work, t, y):
    """Compute accelerations and multipliers at (t, y) into `work`."""
    load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    rows = rows_of(work)
    stabilize(world_of(model).control, rows.gamma, rows.rate, rows.residual)
    factor(model, work)
    copy_rows(kinematics_of(work).force, tree_of(work).load)
    solve(model, work, rows.gamma)
    for _ in range(refinements(closures_of(work).regularity[0])):
        _refine(model, work)


@jit
def planar_derivative(model, work, t, y, dy):
    """Write dy/dt = [v, a]."""
    accelerate(model, work, t, y)
    bodies, acceleration = bodies_of(model), tree_of(work).acceleration
    n = bodies.mass.shape[0]
    for k in range(3 * n):
        dy[k] = y[3 * n + k]
    for i in range(n):
        k = 3 * (n + bodies.scene_index[i])
        dy[k] = acceleration[i, 0]
        dy[k + 1] = acceleration[i, 1]
        dy[k + 2] = acceleration[i, 2]


@jit
def planar_compliance(model, work, t, y):
    """Return max |C| and max |C_dot| over all rows (m, rad; m/s, rad/s)."""
    load_state(model, work, y)
    fill_rows(model, work, t)
    return largest_entry(rows_of(work).residual), largest_entry(rows_of(work).rate)


@jit
def planar_regularity(work):
    """Return the smallest relative closure pivot of the last factorization; 1 without closures."""
    return closures_of(work).regularity[0]


@jit
def planar_multipliers(work, lam):
    """Copy the multipliers of the last solution into lam (n_slots, 3)."""
    copy_rows(rows_of(work).multiplier, lam)


@jit
def _correct(model, work, defect, y, offset):
    """Add the mass-weighted least-squares correction that removes `defect` to half of the state."""
    bodies, tree, gamma = bodies_of(model), tree_of(work), rows_of(work).gamma
    negate(defect, gamma)
    clear(tree.load)
    solve(model, work, gamma)
    for i in range(bodies.mass.shape[0]):
        k = offset + 3 * bodies.scene_index[i]
        for c in range(3):
            y[k + c] += tree.acceleration[i, c]


@jit
def planar_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints.

    Uses the factorization in `work`, of the last acceleration or projection.
    """
    bodies, slots, rows, acceleration = bodies_of(model), slots_of(model), rows_of(work), tree_of(work).acceleration
    n = bodies.mass.shape[0]
    for offset in (0, 3 * n):
        for i in range(n):
            k = offset + 3 * bodies.scene_index[i]
            for c in range(3):
                acceleration[i, c] = x[k + c]
        for slot in range(rows.rate.shape[0]):
            for row in range(3):
                rows.rate[slot, row] = row_times(RATES, slots.body, rows.jacobian, slot, row, acceleration)
        _correct(model, work, rows.rate, x, offset)


@jit
def planar_project(model, work, t, y, tolerance, most):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one.
    """
    rows, n = rows_of(work), bodies_of(model).mass.shape[0]
    load_state(model, work, y)
    fill_rows(model, work, t)
    left = largest_entry(rows.residual)
    for _ in range(most):
        if not left > tolerance:
            break
        factor(model, work)
        _correct(model, work, rows.residual, y, 0)
        load_state(model, work, y)
        fill_rows(model, work, t)
        previous = left
        left = largest_entry(rows.residual)
        if left > 0.5 * previous:
            break
    factor(model, work)
    _correct(model, work, rows.rate, y, 3 * n)
    return left
