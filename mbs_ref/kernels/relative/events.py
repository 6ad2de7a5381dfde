"""The events of trees in the plane and in space: the redundant system evaluates them at the full state."""

import numpy as np

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.border.handles import Model, Work
from mbs_ref.kernels.jit import bare, jit

# Return the redundant system's model.
_inner_model = jit(lambda model: Model(model.redundant.address[0]))
# Return the redundant system's scratch.
_inner_work = jit(lambda model: Work(model.redundant.address[1]))
relative_position_count = jit(lambda model: np.min(model.joints.v))
relative_root_count = jit(lambda model: ask.root_count(_inner_model(model)))


@bare
def relative_roots(model, work, t, y, duration, table):
    ask.expand(model, work, y)
    return ask.roots(_inner_model(model), _inner_work(model), t, work.full.state, duration, table)


@jit
def relative_transition(model, work, t, span, y, g, dy):
    """Let the redundant system change its modes, and take over the velocities that an impulse changed."""
    ask.expand(model, work, y)
    full = work.full
    answer = ask.transition(_inner_model(model), _inner_work(model), t, span, full.state, g, full.slope)
    ask.take_velocities(model, work, y)
    return answer


@jit
def relative_start_modes(model, work, t, y, located):
    ask.expand(model, work, y)
    ask.start_modes(_inner_model(model), _inner_work(model), t, work.full.state, located)


@jit
def relative_contact_mobility(model, work, t, y, k):
    ask.expand(model, work, y)
    return ask.contact_mobility(_inner_model(model), _inner_work(model), t, work.full.state, k)


@jit
def expand_over(model, work, states, out):
    """Write the redundant system's state of each state (n, n_state) to out (n, n_full)."""
    full = work.full.state
    for k in range(states.shape[0]):
        ask.expand(model, work, states[k])
        out[k] = full


@jit
def take_velocities_over(model, work, full, states):
    """Write to each state (n, n_state), of given coordinates, the rates that the redundant ones (n, n_full) mean."""
    place = work.full.state
    for k in range(states.shape[0]):
        ask.expand(model, work, states[k])
        place[:] = full[k]
        ask.take_velocities(model, work, states[k])
