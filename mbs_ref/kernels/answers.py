"""Who answers which question (mbs_ref.kernels.border.questions): the table of the cores, and what Python itself asks.

Answers come in groups, and a system is prepared for a group when it is needed, so that nothing else is compiled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np

from mbs_ref.kernels.absent import NO_EVENTS, NO_ROWS
from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.border.calls import addresses, unanswered
from mbs_ref.kernels.border.handles import QUESTIONS
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles import dynamics as particles
from mbs_ref.kernels.planar import contact_events as planar_contact_events
from mbs_ref.kernels.planar import contact_rows as planar_rows
from mbs_ref.kernels.planar import contacts as planar_contacts
from mbs_ref.kernels.planar import descriptor as planar_form
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.planar import events as planar_events
from mbs_ref.kernels.planar import joints as planar_joints
from mbs_ref.kernels.planar import loads as planar_loads
from mbs_ref.kernels.relative import planar as relative_planar
from mbs_ref.kernels.relative import spatial as relative_spatial
from mbs_ref.kernels.relative.events import PASSED_ON
from mbs_ref.kernels.spatial import contact_events as spatial_contact_events
from mbs_ref.kernels.spatial import contacts as spatial_contacts
from mbs_ref.kernels.spatial import descriptor as spatial_form
from mbs_ref.kernels.spatial import dynamics as spatial
from mbs_ref.kernels.spatial import joints as spatial_joints
from mbs_ref.kernels.spatial import loads as spatial_loads


@jit
def _no_forces(model, work, t, y, out):
    pass


MOTION = "motion"  # what every run asks
EVENTS, UNEVENTFUL = "events", "uneventful"  # of contacts, one-sided springs and declared events; of scenes without
LOOPS, OPEN = "loops", "open"  # of closed loops, rows of contacts among them; of trees
FORM = "form"  # of methods on the DAE itself
REPORT = "report"  # afterwards
# core -> group -> question -> answer; UNEVENTFUL is answered alike everywhere
ANSWERS: dict[str, dict[str, dict[str, Callable[..., Any]]]] = {
    "planar": {
        MOTION: {
            "derivative": planar.planar_derivative,
            "compliance": planar.planar_compliance,
            "project": planar.planar_project,
            "tangent": planar.planar_tangent,
            "regularity": planar.planar_regularity,
            "accelerate": planar.planar_accelerate,
            "fill_rows": planar_joints.planar_fill_rows,
            "apply_loads": planar_loads.planar_apply_loads,
        },
        EVENTS: {
            "root_count": planar_events.planar_root_count,
            "roots": planar_events.planar_roots,
            "transition": planar_events.planar_transition,
            "start_modes": planar_events.planar_start_modes,
            "contact_mobility": planar_contact_events.planar_contact_mobility,
            "settle_grips": planar_contact_events.planar_settle_grips,
            "slip_velocities": planar_contact_events.planar_slip_velocities,
            "apply_contacts": planar_contacts.planar_apply_contacts,
            "fill_contact_rows": planar_rows.planar_fill_contact_rows,
        },
        LOOPS: {
            "factor": planar.planar_factor,
            "solve": planar.planar_solve,
        },
        OPEN: {
            "factor": planar.planar_factor_open,
            "solve": planar.planar_solve_open,
        },
        FORM: {
            "multipliers": planar.planar_multipliers,
            "position_count": planar_form.planar_position_count,
            "force_balance": planar_form.planar_force_balance,
            "times_mass": planar_form.planar_times_mass,
            "answer": planar_form.planar_answer,
            "row_times": planar_form.planar_row_times,
            "add_row": planar_form.planar_add_row,
            "displace": planar_form.planar_displace,
            "position_rate": planar_form.planar_position_rate,
            "defect_of": planar_form.planar_defect_of,
            "gamma_of": planar_form.planar_gamma_of,
        },
        REPORT: {
            "contact_forces": planar_contact_events.planar_contact_forces,
        },
    },
    "spatial": {
        MOTION: {
            "derivative": spatial.spatial_derivative,
            "compliance": spatial.spatial_compliance,
            "project": spatial.spatial_project,
            "tangent": spatial.spatial_tangent,
            "regularity": spatial.spatial_regularity,
            "accelerate": spatial.spatial_accelerate,
            "fill_rows": spatial_joints.spatial_fill_rows,
            "apply_loads": spatial_loads.spatial_apply_loads,
        },
        EVENTS: {
            "root_count": spatial_contact_events.spatial_root_count,
            "roots": spatial_contact_events.spatial_roots,
            "transition": spatial_contact_events.spatial_transition,
            "start_modes": spatial_contact_events.spatial_start_modes,
            "contact_mobility": spatial_contact_events.spatial_contact_mobility,
            "settle_grips": spatial_contact_events.spatial_settle_grips,
            "slip_velocities": spatial_contact_events.spatial_slip_velocities,
            "apply_contacts": spatial_contacts.spatial_apply_contacts,
            "fill_deflection_rates": spatial_contacts.spatial_fill_deflection_rates,
        },
        LOOPS: {
            "factor": spatial.spatial_factor,
            "solve": spatial.spatial_solve,
        },
        OPEN: {
            "factor": spatial.spatial_factor_open,
            "solve": spatial.spatial_solve_open,
        },
        FORM: {
            "multipliers": spatial.spatial_multipliers,
            "position_count": spatial_form.spatial_position_count,
            "force_balance": spatial_form.spatial_force_balance,
            "times_mass": spatial_form.spatial_times_mass,
            "answer": spatial_form.spatial_answer,
            "row_times": spatial_form.spatial_row_times,
            "add_row": spatial_form.spatial_add_row,
            "displace": spatial_form.spatial_displace,
            "position_rate": spatial_form.spatial_position_rate,
            "defect_of": spatial_form.spatial_defect_of,
            "gamma_of": spatial_form.spatial_gamma_of,
        },
        REPORT: {
            "contact_forces": spatial_contact_events.spatial_contact_forces,
        },
    },
    "relative_planar": {
        MOTION: {
            **NO_ROWS,
            "derivative": relative_planar.relative_planar_derivative,
        },
        EVENTS: {
            "tell": relative_planar.tell_planar,
            "take_velocities": relative_planar.take_planar_velocities,
            **PASSED_ON,
        },
    },
    "relative_spatial": {
        MOTION: {
            **NO_ROWS,
            "derivative": relative_spatial.relative_spatial_derivative,
            "compliance": relative_spatial.relative_spatial_compliance,
            "project": relative_spatial.relative_spatial_project,
        },
        EVENTS: {
            "tell": relative_spatial.tell_spatial,
            "take_velocities": relative_spatial.take_spatial_velocities,
            **PASSED_ON,
        },
    },
    "particles": {
        MOTION: {
            **NO_ROWS,
            "derivative": particles.particle_derivative,
        },
        FORM: {
            "multipliers": particles.particle_multipliers,
        },
        REPORT: {
            "contact_forces": _no_forces,
        },
    },
}


@cache
def _addresses(core: str, group: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the places in a handle and the addresses of a group's answers, which are compiled if they never were."""
    return addresses(({UNEVENTFUL: NO_EVENTS} | ANSWERS[core]).get(group, {}))


def connected(core: str, handle: np.ndarray, groups: Iterable[str]) -> np.ndarray:
    """Let a core answer groups of questions; others raise an error until their group is prepared."""
    handle[:QUESTIONS] = unanswered()
    for group in groups:
        prepare(core, handle, group)
    return handle


def prepare(core: str, handle: np.ndarray, group: str) -> None:
    """Connect the answers of a group."""
    places, where = _addresses(core, group)
    handle[places] = where


@jit
def call_contact_forces(model, work, t, y, out):
    """Entry point from Python."""
    ask.contact_forces(model, work, t, y, out)


@jit
def call_contact_mobility(model, work, t, y, k):
    """Entry point from Python."""
    return ask.contact_mobility(model, work, t, y, k)


@jit
def call_start_modes(model, work, t, y, located):
    """Entry point from Python."""
    ask.start_modes(model, work, t, y, located)


@jit
def call_roots(model, work, t, y, g, rate):
    """Entry point from Python."""
    ask.roots(model, work, t, y, g, rate)


@jit
def call_regularity(work):
    """Entry point from Python."""
    return ask.regularity(work)


@jit
def call_derivative(model, work, t, y, dy):
    """Entry point from Python."""
    ask.derivative(model, work, t, y, dy)


@jit
def call_compliance(model, work, t, y):
    """Entry point from Python."""
    return ask.compliance(model, work, t, y)


@jit
def call_project(model, work, t, y, tolerance, most):
    """Entry point from Python."""
    return ask.project(model, work, t, y, tolerance, most)


@jit
def call_tangent(model, work, x):
    """Entry point from Python."""
    ask.tangent(model, work, x)
