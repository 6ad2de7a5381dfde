"""A planar or spatial scene as methods on the DAE itself see it: balances and rows, all in the state's order."""

from mbs_ref.kernels.border.questions import apply_loads, factor, fill_rows, solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.model import rigid_position_count
from mbs_ref.kernels.rows import take_reactions


@jit
def _as_rates(model, work, rates, out):
    """Write rates (n + 1, rates) of bodies in elimination order as the state has rates."""
    bodies, start = model.bodies, rigid_position_count(model)
    out[:] = 0.0
    for i in range(bodies.mass.shape[0]):
        core.add_rates(model, work, i, 1.0, rates[i], out, bodies.v[i] - start)


@jit
def rigid_force_balance(model, work, t, y, lam, out):
    slots, rows, kin = model.slots, work.rows, work.kinematics
    core.load_state(model, work, y)
    apply_loads(model, work, t)
    fill_rows(model, work, t)
    take_reactions(kin.force, slots.body, rows.jacobian, lam)
    kin.force[model.bodies.mass.shape[0]] = 0.0
    _as_rates(model, work, kin.force, out)


@jit
def rigid_answer(model, work, balance, out):
    bodies, tree, start = model.bodies, work.tree, rigid_position_count(model)
    factor(model, work)
    for i in range(bodies.mass.shape[0]):
        rates = core.world_rates(model, work, i, balance, bodies.v[i] - start)
        for c in range(len(core.block(model))):
            tree.load[i, c] = rates[c]
    solve(model, work, work.rows.gamma)
    _as_rates(model, work, tree.acceleration, out)


@jit
def rigid_row_times(model, work, slot, row, rate):
    bodies, slots, rows, start = model.bodies, model.slots, work.rows, rigid_position_count(model)
    total = 0.0
    for side in range(2):
        i = slots.body[slot, side]
        if i < bodies.mass.shape[0]:
            jacobian = rows.jacobian[slot, side, row]
            total = core.plus_product(model, work, total, i, jacobian, rate, bodies.v[i] - start)
    return total


@jit
def rigid_add_row(model, work, slot, row, factor, out):
    bodies, slots, rows, start = model.bodies, model.slots, work.rows, rigid_position_count(model)
    for side in range(2):
        i = slots.body[slot, side]
        if i < bodies.mass.shape[0]:
            core.add_rates(model, work, i, factor, rows.jacobian[slot, side, row], out, bodies.v[i] - start)


@jit
def rigid_defect_of(work, velocity_level):
    rows = work.rows
    return rows.rate if velocity_level else rows.residual


# Return gamma (n_slots, rates).
rigid_gamma_of = jit(lambda work: work.rows.gamma)
