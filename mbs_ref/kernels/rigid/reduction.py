"""The reduction of the DAE to an ODE, and the projection onto its constraints, in the plane and in space.

A core hands over its arrays and what knows its geometry. These functions are written into the core's own.
"""

from __future__ import annotations

from mbs_ref.kernels.algebra.refinement import refinements
from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import inlined
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


@inlined
def reduce_to_accelerations(model, work, t, y, load_state, refine, control, force, rows, tree, closures):
    """Solve for accelerations and multipliers at (t, y), and refine them as often as the loops' pose asks for."""
    load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    stabilize(control, rows.gamma, rows.rate, rows.residual)
    factor(model, work)
    copy_rows(force, tree.load)
    solve(model, work, rows.gamma)
    for _ in range(refinements(closures.regularity[0])):
        refine(model, work)


@inlined
def refine_by(model, work, leave_inertia, body, rows, tree):
    """Add to acceleration and multipliers what the residuals of both equations ask for.

    leave_inertia(model, work, a, load) writes f - M a into load.
    """
    first, multiplier, gamma = tree.acceleration.copy(), rows.multiplier.copy(), rows.gamma.copy()
    leave_inertia(model, work, first, tree.load)
    take_reactions(tree.load, body, rows.jacobian, multiplier)
    take_accelerations(gamma, body, rows.jacobian, first)
    solve(model, work, gamma)
    add_to(tree.acceleration, first)
    add_to(rows.multiplier, multiplier)


@inlined
def respond(model, work, rows, tree, defect):
    """Solve for the mass-weighted least-squares correction that removes `defect`."""
    negate(defect, rows.gamma)
    clear(tree.load)
    solve(model, work, rows.gamma)


@inlined
def project_by(model, work, t, y, tolerance, most, load_state, correct_places, correct_rates, rows, tree):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one. The state at y is in
    `work`; the corrections take what `respond` has found.
    """
    fill_rows(model, work, t)
    left = largest_entry(rows.residual)
    for _ in range(most):
        if not left > tolerance:
            break
        factor(model, work)
        respond(model, work, rows, tree, rows.residual)
        correct_places(model, work, y)
        load_state(model, work, y)
        fill_rows(model, work, t)
        previous = left
        left = largest_entry(rows.residual)
        if left > 0.5 * previous:
            break
    factor(model, work)
    respond(model, work, rows, tree, rows.rate)
    correct_rates(model, work, y)
    return left
