"""The reduction of the DAE to an ODE, and the projection onto its constraints, in the plane and in space.

The index-3 DAE is reduced to its underlying ODE (Fox 1999 eq 9; Fox 2001 eq 19), optionally with Baumgarte's terms.

The augmented system is eliminated along the joint tree, in blocks that a core supplies. Leaf to root, a body with block
M, force f and joint rows J a + K a_parent = gamma is condensed into its parent: with S = J M^-1 J^T,
    M_parent += K^T S^-1 K        f_parent -= K^T S^-1 (J M^-1 f - gamma)
Root to leaf, lambda = S^-1 (J M^-1 f + K a_parent - gamma) and a = M^-1 (f - J^T lambda). This is block
Gaussian elimination of [M Cq^T; Cq 0] in tree order, O(N): no fill outside the blocks. Closures of loops
are eliminated on the way (mbs_ref.kernels.rigid.elimination).

`loops` is None in open trees, and for them no code that stands behind `loops is not None` is compiled.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import either, exceeds, lane_by_lane, larger, largest_of, vanishes
from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, refine, solve
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import elimination
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.model import CONTROL_POSITION_GAIN, CONTROL_VELOCITY_GAIN
from mbs_ref.kernels.rows import add_to, clear, copy_rows, largest_entry, scale, take_accelerations, take_reactions


@jit
def factor_tree(model, work, loops):
    """Factor every body's block and joint, leaf to root, and the closures at their apexes."""
    parent = model.bodies.parent
    n = parent.shape[0]
    core.start_blocks(model, work)
    if loops is not None:
        elimination.begin_closures(model, work)
    for i in range(n - 1, -1, -1):
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.eliminate_closures(model, work, i)
        core.factor_body(model, work, i, parent[i])
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.pass_rows(model, work, i)
    if loops is not None:
        elimination.eliminate_closures(model, work, n)


@jit
def solve_tree(model, work, loops, gamma, acceleration, multiplier):
    """Solve with the forces in the tree's load (overwritten) and the rows' right-hand side `gamma`.

    acceleration (n + 1, rates) and multiplier (n_slots, rates) receive the result; ground's row stays zero.
    """
    parent, load, closures, block = model.bodies.parent, work.tree.load, work.closures, core.block(model)
    n = parent.shape[0]
    if loops is not None:
        elimination.start_rows(block, loops, closures, gamma)
    for i in range(n - 1, -1, -1):
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.condense(block, loops, closures, i, load[i])
        core.solve_free(model, work, i, parent[i], gamma[i], multiplier[i])
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_free(block, loops, closures, i, load[i], gamma[i])
    if loops is not None:
        elimination.condense(block, loops, closures, n, load[n])
        elimination.substitute(block, loops, closures, n, acceleration[n], multiplier)
    for i in range(n):
        core.accelerate_body(model, work, i, parent[i], multiplier[i], acceleration)
        if loops is not None and loops.entry[i] < loops.entry[i + 1]:
            elimination.take_closures(block, loops, closures, i, acceleration[i], multiplier[i])
        if loops is not None and loops.closed[i, 0] < loops.closed[i, 1]:
            elimination.substitute(block, loops, closures, i, acceleration[i], multiplier)


EPS = 2.220446049250313e-16
BORNE = 100.0 * EPS  # relative: below the tightest tolerance in use, 1e-13
REFINED_BELOW = EPS / BORNE  # pivot: elimination alone loses no more above it
MOST_REFINEMENTS = 4
CONVERGES = 1e-4  # relative: where elimination loses more, a rank is lost and nothing is there to refine


@jit
def refinements(pivot):
    """Return the steps of refinement after which what elimination lost at this relative pivot is borne, a float."""
    steps = 0.0
    if pivot >= REFINED_BELOW or pivot * CONVERGES < EPS:
        return steps
    error = EPS / pivot
    while error > BORNE and steps < MOST_REFINEMENTS:
        error *= EPS / pivot
        steps += 1.0
    return steps


# The same, of each lane.
_refinements = lane_by_lane("_refinements(pivot)", refinements)


# Factor the augmented matrix at the Jacobians in `work`; the second one of a tree without closed loops.
rigid_factor = jit(lambda model, work: factor_tree(model, work, model.loops))
rigid_factor_open = jit(lambda model, work: factor_tree(model, work, None))


@jit
def rigid_solve(model, work, gamma):
    work.solved.time[0] = np.nan
    solve_tree(model, work, model.loops, gamma, work.tree.acceleration, work.rows.multiplier)


@jit
def rigid_solve_open(model, work, gamma):
    work.solved.time[0] = np.nan
    solve_tree(model, work, None, gamma, work.tree.acceleration, work.rows.multiplier)


@jit
def _stabilize(control, gamma, rate, residual):
    """gamma -= 2 g C_dot + g^2 C (Baumgarte 1972), with the gains in a model's `control`."""
    velocity_gain, position_gain = control[CONTROL_VELOCITY_GAIN], control[CONTROL_POSITION_GAIN]
    if vanishes(velocity_gain) and vanishes(position_gain):
        return
    for slot in range(gamma.shape[0]):
        for row in range(gamma.shape[1]):
            gamma[slot, row] -= velocity_gain * rate[slot, row] + position_gain * residual[slot, row]


@jit
def rigid_refine(model, work, forces, factor):
    """Add to the accelerations and multipliers of a solution what the residuals of both equations require.

    `forces` (n + 1, rates) is the load of that solution, whose right-hand side is rows.gamma. `factor` is 1, or 0 of a
    lane that is to stay as it is.
    """
    rows, tree, body, before = work.rows, work.tree, model.slots.body, work.before
    copy_rows(tree.acceleration, before.acceleration)
    copy_rows(rows.multiplier, before.multiplier)
    copy_rows(rows.gamma, before.gamma)
    copy_rows(forces, tree.load)
    core.subtract_inertia(model, work, before.acceleration, tree.load)
    take_reactions(tree.load, body, rows.jacobian, before.multiplier)
    take_accelerations(before.gamma, body, rows.jacobian, before.acceleration)
    scale(factor, tree.load, tree.load)
    scale(factor, before.gamma, before.gamma)
    solve(model, work, before.gamma)
    add_to(tree.acceleration, before.acceleration)
    add_to(rows.multiplier, before.multiplier)


@jit
def _refine(model, work, forces):
    """Refine a solution for these forces as often as the loops' pose asks for."""
    steps = _refinements(work.closures.regularity[0])
    while largest_of(steps) > 0.0:
        refine(model, work, forces, exceeds(steps, 0.0))
        steps = steps - 1.0


@jit
def rigid_accelerate(model, work, t, y):
    """Compute accelerations and multipliers at (t, y) into `work`; refine them as often as the loops' pose asks for."""
    core.load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    rows = work.rows
    _stabilize(model.world.control, rows.gamma, rows.rate, rows.residual)
    factor(model, work)
    copy_rows(work.kinematics.force, work.tree.load)
    solve(model, work, rows.gamma)
    _refine(model, work, work.kinematics.force)


@bare
def store_solved(work, t, y):
    """State that the accelerations in `work` are those at (t, y)."""
    solved = work.solved
    solved.time[0] = t
    for k in range(y.shape[0]):
        solved.state[k] = y[k]


@bare
def _is_solved(work, t, y):
    solved = work.solved
    if solved.time[0] != t:
        return False
    same = True
    for k in range(y.shape[0]):
        same &= y[k] == solved.state[k]
    return same


# Return whether the accelerations in `work` are those at (t, y); of lanes they are not looked at.
is_solved = either("is_solved(work, t, y)", _is_solved, bare(lambda work, t, y: False))


@jit
def rigid_compliance(model, work, t, y):
    """Return max |C|, with the norms that the state keeps, and max |C_dot| over all rows (m, rad; m/s, rad/s)."""
    core.load_state(model, work, y)
    fill_rows(model, work, t)
    rows = work.rows
    return larger(largest_entry(rows.residual), core.largest_norm_defect(model, work)), largest_entry(rows.rate)


# Return the smallest relative closure pivot of the last factorization; 1 without closures.
rigid_regularity = jit(lambda work: work.closures.regularity[0])


rigid_multipliers = jit(lambda work, lam: copy_rows(work.rows.multiplier, lam))


@jit
def respond(model, work, defect, share=1.0):
    """Solve for the mass-weighted least-squares correction that removes a share of `defect`."""
    gamma = work.rows.gamma
    scale(-share, defect, gamma)
    clear(work.tree.load)
    solve(model, work, gamma)


@jit
def correct_rates(model, work, factor, y):
    """Add factor times the accelerations in `work` to the rates in y."""
    bodies, acceleration = model.bodies, work.tree.acceleration
    for i in range(bodies.mass.shape[0]):
        core.add_rates(model, work, i, factor, acceleration[i], y, bodies.v[i])


@jit
def _has_no_rows(model):
    alone = model.bodies.alone
    count = 0
    for i in range(alone.shape[0]):
        count += alone[i]
    return count == alone.shape[0]


@jit
def rigid_project(model, work, t, y, tolerance, most):
    """Project positions, then velocities, onto the constraints in the mass norm; return max |C| left.

    At most `most` Gauss-Newton iterations for the positions; velocities are linear and need one, refined as
    accelerations are.
    """
    core.normalize(model, y)
    core.load_state(model, work, y)
    if _has_no_rows(model):
        return core.largest_norm_defect(model, work)
    rows = work.rows
    fill_rows(model, work, t)
    left = largest_entry(rows.residual)
    moves = exceeds(left, tolerance)  # 1 or 0, of each lane: one that is close enough stays where it is
    for _ in range(most):
        if largest_of(moves) == 0.0:
            break
        factor(model, work)
        respond(model, work, rows.residual, moves)
        core.correct_places(model, work, y)
        core.load_state(model, work, y)
        fill_rows(model, work, t)
        previous = left
        left = largest_entry(rows.residual)
        moves = moves * exceeds(left, tolerance) * (1.0 - exceeds(left, 0.5 * previous))
    factor(model, work)
    respond(model, work, rows.rate)
    _refine(model, work, work.before.nothing)
    correct_rates(model, work, 1.0, y)
    return larger(left, core.largest_norm_defect(model, work))
