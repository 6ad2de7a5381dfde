"""The planar system as an ODE, its constraints, and their coordinate projection.

State y = [q, v] in scene order, q_i = [Rx, Ry, theta]. The index-3 DAE is reduced to its underlying ODE
(Fox 1999 eq 9; Fox 2001 eq 19), optionally with Baumgarte's terms.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.closure import correct_for_closures, factor_closures, row_times
from mbs_ref.kernels.planar.joints import fill_joints
from mbs_ref.kernels.planar.loads import apply_loads
from mbs_ref.kernels.planar.tree import factor_tree, solve_tree


@jit
def load_state(model, work, y):
    """Copy the state into elimination order and turn angles into cosines and sines."""
    n = model.bodies.mass.shape[0]
    for i in range(n):
        k = 3 * model.bodies.scene_index[i]
        angle = y[k + 2]
        work.pose[i, 0] = y[k]
        work.pose[i, 1] = y[k + 1]
        work.pose[i, 2] = np.cos(angle)
        work.pose[i, 3] = np.sin(angle)
        work.motion[i, 0] = y[3 * n + k]
        work.motion[i, 1] = y[3 * n + k + 1]
        work.motion[i, 2] = y[3 * n + k + 2]
        work.motion[i, 3] = angle


@jit
def factor(model, work):
    """Factor the augmented matrix at the Jacobians in `work`."""
    factor_tree(model, work)
    if model.slots.closure_slot.shape[0] > 0:
        for i in range(work.rate.shape[0]):
            for c in range(3):
                work.multiplier[i, c] = 0.0
        factor_closures(model, work, work.multiplier)


@jit
def solve(model, work, gamma):
    """Solve the augmented system for work.load and `gamma` into work.acceleration and work.multiplier."""
    solve_tree(model, work, gamma, work.acceleration, work.multiplier)
    if model.slots.closure_slot.shape[0] > 0:
        correct_for_closures(model, work, gamma, work.acceleration, work.multiplier)


@jit
def _stabilize(model, work):
    """gamma -= 2 g C_dot + g^2 C (Baumgarte 1972)."""
    twice = model.control[1]
    square = model.control[2]
    if twice == 0.0 and square == 0.0:
        return
    for i in range(work.gamma.shape[0]):
        for c in range(3):
            work.gamma[i, c] -= twice * work.rate[i, c] + square * work.residual[i, c]


@jit
def accelerate(model, work, t, y):
    """Compute accelerations and multipliers at (t, y) into `work`."""
    load_state(model, work, y)
    apply_loads(model, work, t)
    fill_joints(model, work, t)
    _stabilize(model, work)
    factor(model, work)
    n = model.bodies.mass.shape[0]
    for i in range(n):
        for c in range(3):
            work.load[i, c] = work.force[i, c]
    solve(model, work, work.gamma)


@jit
def planar_derivative(model, work, t, y, dy):
    """Write dy/dt = [v, a]."""
    accelerate(model, work, t, y)
    n = model.bodies.mass.shape[0]
    for k in range(3 * n):
        dy[k] = y[3 * n + k]
    for i in range(n):
        k = 3 * (n + model.bodies.scene_index[i])
        dy[k] = work.acceleration[i, 0]
        dy[k + 1] = work.acceleration[i, 1]
        dy[k + 2] = work.acceleration[i, 2]


@jit
def planar_compliance(model, work, t, y):
    """Return max |C| and max |C_dot| over all rows (m, rad; m/s, rad/s)."""
    load_state(model, work, y)
    fill_joints(model, work, t)
    return _largest(work.residual), _largest(work.rate)


@jit
def _largest(values):
    largest = 0.0
    for i in range(values.shape[0]):
        for c in range(3):
            size = abs(values[i, c])
            if not size <= largest:  # a NaN must win
                largest = size
    return largest


@jit
def _correct(model, work, defect, y, offset):
    """Add the mass-weighted least-squares correction that removes `defect` to half of the state."""
    n = model.bodies.mass.shape[0]
    for i in range(defect.shape[0]):
        for c in range(3):
            work.gamma[i, c] = -defect[i, c]
    for i in range(n):
        for c in range(3):
            work.load[i, c] = 0.0
    solve(model, work, work.gamma)
    for i in range(n):
        k = offset + 3 * model.bodies.scene_index[i]
        for c in range(3):
            y[k + c] += work.acceleration[i, c]


@jit
def planar_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints.

    Uses the factorization in `work`, of the last acceleration or projection.
    """
    n = model.bodies.mass.shape[0]
    for offset in (0, 3 * n):
        for i in range(n):
            k = offset + 3 * model.bodies.scene_index[i]
            for c in range(3):
                work.acceleration[i, c] = x[k + c]
        for slot in range(work.rate.shape[0]):
            for row in range(3):
                work.rate[slot, row] = row_times(model, work, slot, row, work.acceleration)
        _correct(model, work, work.rate, x, offset)


@jit
def planar_project(model, work, t, y, tolerance, most):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one.
    """
    n = model.bodies.mass.shape[0]
    load_state(model, work, y)
    fill_joints(model, work, t)
    left = _largest(work.residual)
    for _ in range(most):
        if not left > tolerance:
            break
        factor(model, work)
        _correct(model, work, work.residual, y, 0)
        load_state(model, work, y)
        fill_joints(model, work, t)
        previous = left
        left = _largest(work.residual)
        if left > 0.5 * previous:
            break
    factor(model, work)
    _correct(model, work, work.rate, y, 3 * n)
    return left
