"""The answers about what a scene does not have: events to watch, or constraint rows to keep."""

from collections.abc import Callable
from typing import Any

from mbs_ref.kernels.jit import jit


@jit
def _no_count(model):
    return 0


@jit
def _no_roots(model, work, t, y, duration, table):
    return False


@jit
def _no_change(model, work, t, span, y, g, dy):
    return 0, 0


@jit
def _no_start(model, work, t, y, located):
    pass


@jit
def _no_mobility(model, work, t, y, k):
    return 0.0


@jit
def _nothing_added(model, work):
    pass


@jit
def _unchanged(model, work, values):
    pass


# A scene without contacts, one-sided springs or declared events.
NO_EVENTS: dict[str, Callable[..., Any]] = {
    "root_count": _no_count,
    "roots": _no_roots,
    "transition": _no_change,
    "start_modes": _no_start,
    "contact_mobility": _no_mobility,
    "apply_contacts": _nothing_added,
    "fill_contact_rows": _nothing_added,
    "fill_deflection_rates": _unchanged,
}


@jit
def _compliance(model, work, t, y):
    return 0.0, 0.0


@jit
def _project(model, work, t, y, tolerance, most):
    return 0.0


@jit
def _regularity(work):
    return 1.0


# A system without constraint rows.
NO_ROWS: dict[str, Callable[..., Any]] = {
    "compliance": _compliance,
    "project": _project,
    "tangent": _unchanged,
    "regularity": _regularity,
}
