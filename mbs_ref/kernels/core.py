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
from mbs_ref.kernels.planar import descriptor as planar_form
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.planar import events as planar_events
from mbs_ref.kernels.planar.model import PlanarModel, PlanarWork
from mbs_ref.kernels.spatial import contact_events as spatial_contacts
from mbs_ref.kernels.spatial import descriptor as spatial_form
from mbs_ref.kernels.spatial import dynamics as spatial
from mbs_ref.kernels.spatial.model import SpatialModel, SpatialWork


# particles know no contact, and have no events
@jit
def _none(model):
    return 0


@jit
def _nothing(model, work, t, y, g, rate):
    pass


@jit
def _no_change(model, work, t, y, g, dy):
    return 0, 0


@jit
def _no_start(model, work, t, y, located):
    pass


@jit
def _no_forces(model, work, t, y, out):
    pass


@jit
def _no_mobility(model, work, t, y, k):
    return 0.0


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
    "position_count": {
        PlanarModel: planar_form.planar_position_count,
        SpatialModel: spatial_form.spatial_position_count,
    },
    "force_balance": {PlanarModel: planar_form.planar_force_balance, SpatialModel: spatial_form.spatial_force_balance},
    "times_mass": {PlanarModel: planar_form.planar_times_mass, SpatialModel: spatial_form.spatial_times_mass},
    "answer": {PlanarModel: planar_form.planar_answer, SpatialModel: spatial_form.spatial_answer},
    "row_times": {PlanarModel: planar_form.planar_row_times, SpatialModel: spatial_form.spatial_row_times},
    "add_row": {PlanarModel: planar_form.planar_add_row, SpatialModel: spatial_form.spatial_add_row},
    "displace": {PlanarModel: planar_form.planar_displace, SpatialModel: spatial_form.spatial_displace},
    "position_rate": {PlanarModel: planar_form.planar_position_rate, SpatialModel: spatial_form.spatial_position_rate},
    "defect_of": {PlanarWork: planar_form.planar_defect_of, SpatialWork: spatial_form.spatial_defect_of},
    "gamma_of": {PlanarWork: planar_form.planar_gamma_of, SpatialWork: spatial_form.spatial_gamma_of},
    "root_count": {
        PlanarModel: planar_events.planar_root_count,
        SpatialModel: spatial_contacts.spatial_root_count,
        ParticleModel: _none,
    },
    "roots": {
        PlanarModel: planar_events.planar_roots,
        SpatialModel: spatial_contacts.spatial_roots,
        ParticleModel: _nothing,
    },
    "transition": {
        PlanarModel: planar_events.planar_transition,
        SpatialModel: spatial_contacts.spatial_transition,
        ParticleModel: _no_change,
    },
    "start_modes": {
        PlanarModel: planar_events.planar_start_modes,
        SpatialModel: spatial_contacts.spatial_start_modes,
        ParticleModel: _no_start,
    },
    "contact_forces": {
        PlanarModel: planar_contacts.planar_contact_forces,
        SpatialModel: spatial_contacts.spatial_contact_forces,
        ParticleModel: _no_forces,
    },
    "contact_mobility": {
        PlanarModel: planar_contacts.planar_contact_mobility,
        SpatialModel: spatial_contacts.spatial_contact_mobility,
        ParticleModel: _no_mobility,
    },
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


def position_count(model) -> Any:
    """Return how many entries of the state are positions; rates follow."""
    raise NotImplementedError("called from compiled code only")


def force_balance(model, work, t, y, lam, out) -> Any:
    """Write f - C_q^T lambda as rates are ordered; leave C, C_dot, C_q and gamma in `work`."""
    raise NotImplementedError("called from compiled code only")


def times_mass(model, rate, out) -> Any:
    """Write M rate."""
    raise NotImplementedError("called from compiled code only")


def answer(model, work, balance, out) -> Any:
    """Solve the augmented system for a balance and the gamma in `work`; write the accelerations."""
    raise NotImplementedError("called from compiled code only")


def row_times(model, work, slot, row, rate) -> Any:
    """Return one constraint row applied to rates."""
    raise NotImplementedError("called from compiled code only")


def add_row(model, work, slot, row, factor, out) -> Any:
    """Add factor times one constraint row to out."""
    raise NotImplementedError("called from compiled code only")


def displace(model, y, move, out) -> Any:
    """Write y's positions moved along the rates' directions by `move`."""
    raise NotImplementedError("called from compiled code only")


def position_rate(model, y, rate, out) -> Any:
    """Write the rates of the positions that `rate` means."""
    raise NotImplementedError("called from compiled code only")


def defect_of(work, velocity_level) -> Any:
    """Return C, or C_dot where asked (n_slots, rows a slot), as the last balance left it."""
    raise NotImplementedError("called from compiled code only")


def gamma_of(work) -> Any:
    """Return gamma (n_slots, rows a slot), to be read or replaced."""
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


@overload(position_count, jit_options=_OPTIONS)
def _position_count(model):
    chosen = _ANSWERS["position_count"][model.instance_class]
    return lambda model: chosen(model)


@overload(force_balance, jit_options=_OPTIONS)
def _force_balance(model, work, t, y, lam, out):
    chosen = _ANSWERS["force_balance"][model.instance_class]
    return lambda model, work, t, y, lam, out: chosen(model, work, t, y, lam, out)


@overload(times_mass, jit_options=_OPTIONS)
def _times_mass(model, rate, out):
    chosen = _ANSWERS["times_mass"][model.instance_class]
    return lambda model, rate, out: chosen(model, rate, out)


@overload(answer, jit_options=_OPTIONS)
def _answer(model, work, balance, out):
    chosen = _ANSWERS["answer"][model.instance_class]
    return lambda model, work, balance, out: chosen(model, work, balance, out)


@overload(row_times, jit_options=_OPTIONS)
def _row_times(model, work, slot, row, rate):
    chosen = _ANSWERS["row_times"][model.instance_class]
    return lambda model, work, slot, row, rate: chosen(model, work, slot, row, rate)


@overload(add_row, jit_options=_OPTIONS)
def _add_row(model, work, slot, row, factor, out):
    chosen = _ANSWERS["add_row"][model.instance_class]
    return lambda model, work, slot, row, factor, out: chosen(model, work, slot, row, factor, out)


@overload(displace, jit_options=_OPTIONS)
def _displace(model, y, move, out):
    chosen = _ANSWERS["displace"][model.instance_class]
    return lambda model, y, move, out: chosen(model, y, move, out)


@overload(position_rate, jit_options=_OPTIONS)
def _position_rate(model, y, rate, out):
    chosen = _ANSWERS["position_rate"][model.instance_class]
    return lambda model, y, rate, out: chosen(model, y, rate, out)


@overload(defect_of, jit_options=_OPTIONS)
def _defect_of(work, velocity_level):
    chosen = _ANSWERS["defect_of"][work.instance_class]
    return lambda work, velocity_level: chosen(work, velocity_level)


@overload(gamma_of, jit_options=_OPTIONS)
def _gamma_of(work):
    chosen = _ANSWERS["gamma_of"][work.instance_class]
    return lambda work: chosen(work)


@overload(root_count, jit_options=_OPTIONS)
def _root_count(model):
    answer = _ANSWERS["root_count"][model.instance_class]
    return lambda model: answer(model)


@overload(roots, jit_options=_OPTIONS)
def _roots(model, work, t, y, g, rate):
    answer = _ANSWERS["roots"][model.instance_class]
    return lambda model, work, t, y, g, rate: answer(model, work, t, y, g, rate)


@overload(transition, jit_options=_OPTIONS)
def _transition(model, work, t, y, g, dy):
    answer = _ANSWERS["transition"][model.instance_class]
    return lambda model, work, t, y, g, dy: answer(model, work, t, y, g, dy)


@overload(start_modes, jit_options=_OPTIONS)
def _start_modes(model, work, t, y, located):
    answer = _ANSWERS["start_modes"][model.instance_class]
    return lambda model, work, t, y, located: answer(model, work, t, y, located)


@overload(contact_forces, jit_options=_OPTIONS)
def _contact_forces(model, work, t, y, out):
    answer = _ANSWERS["contact_forces"][model.instance_class]
    return lambda model, work, t, y, out: answer(model, work, t, y, out)


@overload(contact_mobility, jit_options=_OPTIONS)
def _contact_mobility(model, work, t, y, k):
    answer = _ANSWERS["contact_mobility"][model.instance_class]
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
