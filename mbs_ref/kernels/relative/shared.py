"""What trees in the plane and in space answer alike: they have no rows, and the redundant system knows the events."""

from __future__ import annotations

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.relative.model import inner_model, inner_work, told_of


@jit
def relative_tangent(model, work, x):
    """Every direction is free."""


@jit
def relative_regularity(work):
    return 1.0


@jit
def relative_root_count(model):
    return ask.root_count(inner_model(model))


@jit
def relative_roots(model, work, t, y, g, rate):
    ask.tell(model, work, y)
    ask.roots(inner_model(model), inner_work(model), t, told_of(work).state, g, rate)


@jit
def relative_transition(model, work, t, span, y, g, dy):
    """Let the redundant system change its modes, and take over the velocities that an impulse changed."""
    ask.tell(model, work, y)
    told = told_of(work)
    answer = ask.transition(inner_model(model), inner_work(model), t, span, told.state, g, told.slope)
    ask.take_velocities(model, work, y)
    return answer


@jit
def relative_start_modes(model, work, t, y, located):
    ask.tell(model, work, y)
    ask.start_modes(inner_model(model), inner_work(model), t, told_of(work).state, located)


@jit
def relative_contact_mobility(model, work, t, y, k):
    ask.tell(model, work, y)
    return ask.contact_mobility(inner_model(model), inner_work(model), t, told_of(work).state, k)
