"""The planar system as an ODE, its constraints, and their coordinate projection.

State y = [q, v] in scene order, q_i = [Rx, Ry, theta]. The index-3 DAE is reduced to its underlying ODE
(Fox 1999 eq 9; Fox 2001 eq 19), optionally with Baumgarte's terms.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import accelerate, fill_rows
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.model import (
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
from mbs_ref.kernels.planar.tree import factor_tree, solve_tree
from mbs_ref.kernels.rigid.elimination import rows_times
from mbs_ref.kernels.rigid.reduction import project_by, reduce_to_accelerations, refine_by, respond
from mbs_ref.kernels.rows import (
    copy_rows,
    largest_entry,
)


@jit
def load_state(model, work, y):
    """Copy the state into elimination order and turn angles into cosines and sines."""
    bodies, kin = bodies_of(model), kinematics_of(work)
    tree_of(work).holds[0] = np.nan
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
    factor_tree(model, work, loops_of(model))


@jit
def planar_solve(model, work, gamma):
    """Solve the augmented system for the tree's load and `gamma` into its acceleration and the multipliers."""
    tree_of(work).holds[0] = np.nan
    solve_tree(model, work, loops_of(model), gamma, tree_of(work).acceleration, rows_of(work).multiplier)


@jit
def planar_factor_open(model, work):
    """The same of a tree without closed loops."""
    factor_tree(model, work, None)


@jit
def planar_solve_open(model, work, gamma):
    """The same of a tree without closed loops."""
    tree_of(work).holds[0] = np.nan
    solve_tree(model, work, None, gamma, tree_of(work).acceleration, rows_of(work).multiplier)


@jit
def _leave_inertia(model, work, acceleration, load):
    """Write f - M a into load."""
    bodies, force = bodies_of(model), kinematics_of(work).force
    for i in range(bodies.mass.shape[0]):
        load[i, 0] = force[i, 0] - bodies.mass[i] * acceleration[i, 0]
        load[i, 1] = force[i, 1] - bodies.mass[i] * acceleration[i, 1]
        load[i, 2] = force[i, 2] - bodies.inertia[i] * acceleration[i, 2]


@jit
def _refine(model, work):
    refine_by(model, work, _leave_inertia, slots_of(model).body, rows_of(work), tree_of(work))


@jit
def planar_accelerate(model, work, t, y):
    """Compute accelerations and multipliers at (t, y) into `work`."""
    reduce_to_accelerations(
        model, work, t, y, load_state, _refine,
        world_of(model).control, kinematics_of(work).force, rows_of(work), tree_of(work), closures_of(work),
    )  # fmt: skip


@jit
def _holds(model, work, t, y):
    """Return whether the accelerations in `work` are those at (t, y)."""
    if tree_of(work).holds[0] != t:
        return False
    bodies, kin = bodies_of(model), kinematics_of(work)
    n = bodies.mass.shape[0]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        if y[k] != kin.pose[i, 0] or y[k + 1] != kin.pose[i, 1] or y[k + 2] != kin.motion[i, 3]:
            return False
        for c in range(3):
            if y[3 * n + k + c] != kin.motion[i, c]:
                return False
    return True


@jit
def planar_derivative(model, work, t, y, dy):
    """Write dy/dt = [v, a]."""
    if not _holds(model, work, t, y):
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
def _add_correction(model, work, y, offset):
    bodies, tree = bodies_of(model), tree_of(work)
    for i in range(bodies.mass.shape[0]):
        k = offset + 3 * bodies.scene_index[i]
        for c in range(3):
            y[k + c] += tree.acceleration[i, c]


@jit
def _correct_places(model, work, y):
    """Add the correction in `work` to the places and angles in y."""
    _add_correction(model, work, y, 0)


@jit
def _correct_rates(model, work, y):
    """Add the correction in `work` to the rates in y."""
    _add_correction(model, work, y, 3 * bodies_of(model).mass.shape[0])


@jit
def planar_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints.

    Uses the factorization in `work`, of the last acceleration or projection.
    """
    bodies, slots, rows, tree = bodies_of(model), slots_of(model), rows_of(work), tree_of(work)
    n = bodies.mass.shape[0]
    for offset in (0, 3 * n):
        for i in range(n):
            k = offset + 3 * bodies.scene_index[i]
            for c in range(3):
                tree.acceleration[i, c] = x[k + c]
        rows_times(RATES, slots.body, rows.jacobian, tree.acceleration, rows.rate)
        respond(model, work, rows, tree, rows.rate)
        _add_correction(model, work, x, offset)


@jit
def planar_project(model, work, t, y, tolerance, most):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one.
    """
    load_state(model, work, y)
    return project_by(
        model, work, t, y, tolerance, most, load_state, _correct_places, _correct_rates, rows_of(work), tree_of(work)
    )
