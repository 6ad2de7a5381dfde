"""The events of trees in the plane and in space: the redundant system knows them, and is told the state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.relative.model import inner_model, inner_work, told_of


@jit
def _root_count(model):
    return ask.root_count(inner_model(model))


@jit
def _roots(model, work, t, y, g, rate):
    ask.tell(model, work, y)
    ask.roots(inner_model(model), inner_work(model), t, told_of(work).state, g, rate)


@jit
def _transition(model, work, t, span, y, g, dy):
    """Let the redundant system change its modes, and take over the velocities that an impulse changed."""
    ask.tell(model, work, y)
    told = told_of(work)
    answer = ask.transition(inner_model(model), inner_work(model), t, span, told.state, g, told.slope)
    ask.take_velocities(model, work, y)
    return answer


@jit
def _start_modes(model, work, t, y, located):
    ask.tell(model, work, y)
    ask.start_modes(inner_model(model), inner_work(model), t, told_of(work).state, located)


@jit
def _contact_mobility(model, work, t, y, k):
    ask.tell(model, work, y)
    return ask.contact_mobility(inner_model(model), inner_work(model), t, told_of(work).state, k)


PASSED_ON: dict[str, Callable[..., Any]] = {
    "root_count": _root_count,
    "roots": _roots,
    "transition": _transition,
    "start_modes": _start_modes,
    "contact_mobility": _contact_mobility,
}
