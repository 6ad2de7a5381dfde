"""The questions an integrator asks of a model, answered by the core the model belongs to.

Dispatch is by the model's type at compile time, so a planar scene never touches another core's code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.dynamics import planar_compliance, planar_derivative, planar_project, planar_regularity, planar_tangent
from mbs_ref.kernels.planar.model import PlanarModel, PlanarWork

CORES: dict[type, tuple[Callable[..., Any], ...]] = {
    PlanarModel: (planar_derivative, planar_compliance, planar_project, planar_tangent)}
REGULARITY = {PlanarWork: planar_regularity}


def derivative(model, work, t, y, dy):
    """Write dy/dt at (t, y)."""
    raise NotImplementedError("called from compiled code only")


def compliance(model, work, t, y):
    """Return max |C| and max |C_dot|."""
    raise NotImplementedError("called from compiled code only")


def project(model, work, t, y, tolerance, most):
    """Move y onto the constraints; return max |C| left."""
    raise NotImplementedError("called from compiled code only")


def tangent(model, work, x):
    """Remove from both halves of x what points off the constraints, at the last factorization."""
    raise NotImplementedError("called from compiled code only")


@overload(derivative, jit_options={"error_model": "numpy", "fastmath": {"contract"}})
def _derivative(model, work, t, y, dy):
    chosen = CORES[model.instance_class][0]
    return lambda model, work, t, y, dy: chosen(model, work, t, y, dy)


@overload(compliance, jit_options={"error_model": "numpy", "fastmath": {"contract"}})
def _compliance(model, work, t, y):
    chosen = CORES[model.instance_class][1]
    return lambda model, work, t, y: chosen(model, work, t, y)


@overload(project, jit_options={"error_model": "numpy", "fastmath": {"contract"}})
def _project(model, work, t, y, tolerance, most):
    chosen = CORES[model.instance_class][2]
    return lambda model, work, t, y, tolerance, most: chosen(model, work, t, y, tolerance, most)


@overload(tangent, jit_options={"error_model": "numpy", "fastmath": {"contract"}})
def _tangent(model, work, x):
    chosen = CORES[model.instance_class][3]
    return lambda model, work, x: chosen(model, work, x)


def regularity(work):
    """Return how far the last factorization is from a singular pose: 1 far, 0 there."""
    raise NotImplementedError("called from compiled code only")


@overload(regularity, jit_options={"error_model": "numpy", "fastmath": {"contract"}})
def _regularity(work):
    chosen = REGULARITY[work.instance_class]
    return lambda work: chosen(work)


@jit
def call_derivative(model, work, t, y, dy):
    """Entry point from Python."""
    derivative(model, work, t, y, dy)


@jit
def call_compliance(model, work, t, y):
    """Entry point from Python."""
    return compliance(model, work, t, y)


@jit
def call_project(model, work, t, y, tolerance, most):
    """Entry point from Python."""
    return project(model, work, t, y, tolerance, most)
