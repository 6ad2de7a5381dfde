"""The questions an integrator asks of a model, answered by the core the model belongs to.

Dispatch is by the model's type at compile time, so a planar scene never touches another core's code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles import dynamics as particles
from mbs_ref.kernels.particles.model import ParticleModel, ParticleWork
from mbs_ref.kernels.planar import contact_events as planar_contacts
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.planar import events as planar_events
from mbs_ref.kernels.planar import implicit as planar_implicit
from mbs_ref.kernels.planar.model import PlanarModel, PlanarWork
from mbs_ref.kernels.spatial import contact_events as spatial_contacts
from mbs_ref.kernels.spatial import dynamics as spatial
from mbs_ref.kernels.spatial.model import SpatialModel, SpatialWork

# question -> {type of its first argument: answer}
_ANSWERS: dict[str, dict[type, Callable[..., Any]]] = {
    "derivative": {
        PlanarModel: planar.planar_derivative,
        SpatialModel: spatial.spatial_derivative,
        ParticleModel: particles.particle_derivative,
    },
    "compliance": {
        PlanarModel: planar.planar_compliance,
        SpatialModel: spatial.spatial_compliance,
        ParticleModel: particles.particle_compliance,
    },
    "project": {
        PlanarModel: planar.planar_project,
        SpatialModel: spatial.spatial_project,
        ParticleModel: particles.particle_project,
    },
    "tangent": {
        PlanarModel: planar.planar_tangent,
        SpatialModel: spatial.spatial_tangent,
        ParticleModel: particles.particle_tangent,
    },
    "regularity": {
        PlanarWork: planar.planar_regularity,
        SpatialWork: spatial.spatial_regularity,
        ParticleWork: particles.particle_regularity,
    },
    "multipliers": {
        PlanarWork: planar.planar_multipliers,
        SpatialWork: spatial.spatial_multipliers,
        ParticleWork: particles.particle_multipliers,
    },
    "tree_correction": {PlanarModel: planar_implicit.planar_tree_correction},
    "dense_correction": {PlanarModel: planar_implicit.planar_dense_correction},
    "factor_tangent": {PlanarModel: planar_implicit.planar_factor_tangent},
}


def _none(model):
    return 0


def _nothing(model, work, t, y, g, rate):
    pass


def _no_change(model, work, t, y, g, dy):
    return 0, 0


def _no_start(model, work, t, y, located):
    pass


def _no_forces(model, work, t, y, out):
    pass


def _no_mobility(model, work, t, y, k):
    return 0.0


# a core that knows no contact has no events
_EVENTS: dict[str, tuple[Callable[..., Any], dict[type, Callable[..., Any]]]] = {
    "root_count": (
        jit(_none),
        {PlanarModel: planar_events.planar_root_count, SpatialModel: spatial_contacts.spatial_root_count},
    ),
    "roots": (
        jit(_nothing),
        {PlanarModel: planar_events.planar_roots, SpatialModel: spatial_contacts.spatial_roots},
    ),
    "transition": (
        jit(_no_change),
        {PlanarModel: planar_events.planar_transition, SpatialModel: spatial_contacts.spatial_transition},
    ),
    "start_modes": (
        jit(_no_start),
        {PlanarModel: planar_events.planar_start_modes, SpatialModel: spatial_contacts.spatial_start_modes},
    ),
    "contact_forces": (
        jit(_no_forces),
        {PlanarModel: planar_contacts.planar_contact_forces, SpatialModel: spatial_contacts.spatial_contact_forces},
    ),
    "contact_mobility": (
        jit(_no_mobility),
        {PlanarModel: planar_contacts.planar_contact_mobility, SpatialModel: spatial_contacts.spatial_contact_mobility},
    ),
}
_OPTIONS: Any = {"error_model": "numpy", "fastmath": {"contract"}}


def derivative(model, work, t, y, dy) -> Any:
    """Write dy/dt at (t, y)."""
    raise NotImplementedError("called from compiled code only")


def compliance(model, work, t, y) -> Any:
    """Return max |C| and max |C_dot|."""
    raise NotImplementedError("called from compiled code only")


def project(model, work, t, y, tolerance, most) -> Any:
    """Move y onto the constraints; return max |C| left."""
    raise NotImplementedError("called from compiled code only")


def tangent(model, work, x) -> Any:
    """Remove from both halves of x what points off the constraints, at the last factorization."""
    raise NotImplementedError("called from compiled code only")


def regularity(work) -> Any:
    """Return how far the last factorization is from a singular pose: 1 far, 0 there."""
    raise NotImplementedError("called from compiled code only")


def multipliers(work, lam) -> Any:
    """Copy the multipliers of the last acceleration into lam (n_slots, rows a slot)."""
    raise NotImplementedError("called from compiled code only")


def tree_correction(model, work, t, y, qdd, lam, weight, velocity_level) -> Any:
    """Correct (qdd, lam) towards the DAE at (t, y) with the mass matrix alone."""
    raise NotImplementedError("called from compiled code only")


def dense_correction(model, work, t, y, qdd, lam, weight, velocity_level, row_slot, row_row, lu, pivots) -> Any:
    """Correct (qdd, lam) with the factored full tangent."""
    raise NotImplementedError("called from compiled code only")


def factor_tangent(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots) -> Any:
    """Form and factor the full tangent; return False where it is singular."""
    raise NotImplementedError("called from compiled code only")


def root_count(model) -> Any:
    """Return the number of event functions watched."""
    raise NotImplementedError("called from compiled code only")


def roots(model, work, t, y, g, rate) -> Any:
    """Fill the event functions, positive while the frozen modes hold, and their rates where known, else 0."""
    raise NotImplementedError("called from compiled code only")


def transition(model, work, t, y, g, dy) -> Any:
    """Change the modes whose event functions are negative; return 0, 1 (endless) or 2 (stop), and the last source."""
    raise NotImplementedError("called from compiled code only")


def start_modes(model, work, t, y, located) -> Any:
    """Set every contact's mode by the state."""
    raise NotImplementedError("called from compiled code only")


def contact_forces(model, work, t, y, out) -> Any:
    """Fill out (n_contacts, 1 + 2 dimension): depth (m), force on body a (N), its point (m), in the present modes."""
    raise NotImplementedError("called from compiled code only")


def contact_mobility(model, work, t, y, k) -> Any:
    """Return n^T W n (1/kg) of a contact within the joints."""
    raise NotImplementedError("called from compiled code only")


@overload(derivative, jit_options=_OPTIONS)
def _derivative(model, work, t, y, dy):
    answer = _ANSWERS["derivative"][model.instance_class]
    return lambda model, work, t, y, dy: answer(model, work, t, y, dy)


@overload(compliance, jit_options=_OPTIONS)
def _compliance(model, work, t, y):
    answer = _ANSWERS["compliance"][model.instance_class]
    return lambda model, work, t, y: answer(model, work, t, y)


@overload(project, jit_options=_OPTIONS)
def _project(model, work, t, y, tolerance, most):
    answer = _ANSWERS["project"][model.instance_class]
    return lambda model, work, t, y, tolerance, most: answer(model, work, t, y, tolerance, most)


@overload(tangent, jit_options=_OPTIONS)
def _tangent(model, work, x):
    answer = _ANSWERS["tangent"][model.instance_class]
    return lambda model, work, x: answer(model, work, x)


@overload(regularity, jit_options=_OPTIONS)
def _regularity(work):
    answer = _ANSWERS["regularity"][work.instance_class]
    return lambda work: answer(work)


@overload(multipliers, jit_options=_OPTIONS)
def _multipliers(work, lam):
    answer = _ANSWERS["multipliers"][work.instance_class]
    return lambda work, lam: answer(work, lam)


@overload(tree_correction, jit_options=_OPTIONS)
def _tree_correction(model, work, t, y, qdd, lam, weight, velocity_level):
    answer = _ANSWERS["tree_correction"][model.instance_class]
    return lambda model, work, t, y, qdd, lam, weight, velocity_level: answer(
        model, work, t, y, qdd, lam, weight, velocity_level
    )


@overload(dense_correction, jit_options=_OPTIONS)
def _dense_correction(model, work, t, y, qdd, lam, weight, velocity_level, row_slot, row_row, lu, pivots):
    answer = _ANSWERS["dense_correction"][model.instance_class]
    return lambda model, work, t, y, qdd, lam, weight, velocity_level, row_slot, row_row, lu, pivots: answer(
        model, work, t, y, qdd, lam, weight, velocity_level, row_slot, row_row, lu, pivots
    )


@overload(factor_tangent, jit_options=_OPTIONS)
def _factor_tangent(model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots):
    answer = _ANSWERS["factor_tangent"][model.instance_class]
    return lambda model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots: answer(
        model, work, t, y, lam, by_position, by_velocity, row_slot, row_row, lu, pivots
    )


def _event_answer(question, model):
    default, answers = _EVENTS[question]
    return answers.get(model.instance_class, default)


@overload(root_count, jit_options=_OPTIONS)
def _root_count(model):
    answer = _event_answer("root_count", model)
    return lambda model: answer(model)


@overload(roots, jit_options=_OPTIONS)
def _roots(model, work, t, y, g, rate):
    answer = _event_answer("roots", model)
    return lambda model, work, t, y, g, rate: answer(model, work, t, y, g, rate)


@overload(transition, jit_options=_OPTIONS)
def _transition(model, work, t, y, g, dy):
    answer = _event_answer("transition", model)
    return lambda model, work, t, y, g, dy: answer(model, work, t, y, g, dy)


@overload(start_modes, jit_options=_OPTIONS)
def _start_modes(model, work, t, y, located):
    answer = _event_answer("start_modes", model)
    return lambda model, work, t, y, located: answer(model, work, t, y, located)


@overload(contact_forces, jit_options=_OPTIONS)
def _contact_forces(model, work, t, y, out):
    answer = _event_answer("contact_forces", model)
    return lambda model, work, t, y, out: answer(model, work, t, y, out)


@overload(contact_mobility, jit_options=_OPTIONS)
def _contact_mobility(model, work, t, y, k):
    answer = _event_answer("contact_mobility", model)
    return lambda model, work, t, y, k: answer(model, work, t, y, k)


@jit
def call_contact_forces(model, work, t, y, out):
    """Entry point from Python."""
    contact_forces(model, work, t, y, out)


@jit
def call_contact_mobility(model, work, t, y, k):
    """Entry point from Python."""
    return contact_mobility(model, work, t, y, k)


@jit
def call_start_modes(model, work, t, y, located):
    """Entry point from Python."""
    start_modes(model, work, t, y, located)


@jit
def call_root_count(model):
    """Entry point from Python."""
    return root_count(model)


@jit
def call_roots(model, work, t, y, g, rate):
    """Entry point from Python."""
    roots(model, work, t, y, g, rate)


@jit
def call_transition(model, work, t, y, g, dy):
    """Entry point from Python."""
    return transition(model, work, t, y, g, dy)


@jit
def call_regularity(work):
    """Entry point from Python."""
    return regularity(work)


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


@jit
def call_tangent(model, work, x):
    """Entry point from Python."""
    tangent(model, work, x)
