"""Who answers which question (mbs_ref.kernels.border.questions): the table of the cores, and what Python itself asks.

Answers come in groups, and a system is prepared for a group when it is needed, so that nothing else is compiled.
"""

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
from mbs_ref.kernels.particles.model import ParticleModel, ParticleWork
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.planar.dynamics import PlanarModel, PlanarWork
from mbs_ref.kernels.relative import planar as relative_planar
from mbs_ref.kernels.relative import spatial as relative_spatial
from mbs_ref.kernels.relative.events import PASSED_ON
from mbs_ref.kernels.relative.model import TreeModel, TreeWork
from mbs_ref.kernels.rigid import contact_events, contact_forces, descriptor, dynamics, events, grips, joints, loads
from mbs_ref.kernels.rigid.model import position_count
from mbs_ref.kernels.spatial import descriptor as spatial_form
from mbs_ref.kernels.spatial import dynamics as spatial
from mbs_ref.kernels.spatial import grips as spatial_grips
from mbs_ref.kernels.spatial.dynamics import SpatialModel, SpatialWork


@jit
def _no_forces(model, work, t, y, out):
    pass


MOTION = "motion"  # what every run asks
EVENTS, UNEVENTFUL = "events", "uneventful"  # of contacts, one-sided springs and declared events; of scenes without
LOOPS, OPEN = "loops", "open"  # of closed loops, rows of contacts among them; of trees
FORM = "form"  # of methods on the DAE itself
REPORT = "report"  # afterwards
_RIGID: dict[str, dict[str, Callable[..., Any]]] = {  # of bodies and joints, in the plane and in space
    MOTION: {
        "compliance": dynamics.rigid_compliance,
        "project": dynamics.rigid_project,
        "regularity": dynamics.rigid_regularity,
        "accelerate": dynamics.rigid_accelerate,
        "fill_rows": joints.rigid_fill_rows,
        "apply_loads": loads.rigid_apply_loads,
    },
    EVENTS: {
        "position_count": position_count,
        "root_count": events.rigid_root_count,
        "roots": events.rigid_roots,
        "transition": events.rigid_transition,
        "start_modes": events.rigid_start_modes,
        "contact_mobility": contact_events.rigid_contact_mobility,
        "settle_grips": grips.rigid_settle_grips,
        "slip_velocities": grips.rigid_slip_velocities,
        "apply_contacts": contact_forces.rigid_apply_contacts,
        "fill_contact_rows": contact_forces.rigid_fill_contact_rows,
    },
    LOOPS: {"factor": dynamics.rigid_factor, "solve": dynamics.rigid_solve},
    OPEN: {"factor": dynamics.rigid_factor_open, "solve": dynamics.rigid_solve_open},
    FORM: {
        "multipliers": dynamics.rigid_multipliers,
        "position_count": position_count,
        "force_balance": descriptor.rigid_force_balance,
        "answer": descriptor.rigid_answer,
        "row_times": descriptor.rigid_row_times,
        "add_row": descriptor.rigid_add_row,
        "defect_of": descriptor.rigid_defect_of,
        "gamma_of": descriptor.rigid_gamma_of,
    },
    REPORT: {"contact_forces": contact_events.rigid_contact_forces},
}
HANDLES: dict[str, tuple[type, type]] = {  # core -> what its own code takes a model and a scratch for
    "planar": (PlanarModel, PlanarWork),
    "spatial": (SpatialModel, SpatialWork),
    "relative_planar": (TreeModel, TreeWork),
    "relative_spatial": (TreeModel, TreeWork),
    "particles": (ParticleModel, ParticleWork),
}
# core -> group -> question -> answer; UNEVENTFUL is answered alike everywhere
ANSWERS: dict[str, dict[str, dict[str, Callable[..., Any]]]] = {
    "planar": {
        **_RIGID,
        MOTION: {**_RIGID[MOTION], "derivative": planar.planar_derivative, "tangent": planar.planar_tangent},
        EVENTS: {
            **_RIGID[EVENTS],
            "position_rate": planar.planar_position_rate,
            "rate_from": planar.planar_position_rate,
        },
        FORM: {
            **_RIGID[FORM],
            "times_mass": planar.planar_times_mass,
            "displace": planar.planar_displace,
            "position_rate": planar.planar_position_rate,
        },
    },
    "spatial": {
        **_RIGID,
        MOTION: {**_RIGID[MOTION], "derivative": spatial.spatial_derivative, "tangent": spatial.spatial_tangent},
        EVENTS: {
            **_RIGID[EVENTS],
            "position_rate": spatial_form.spatial_position_rate,
            "rate_from": spatial_form.spatial_rate_from,
            "fill_deflection_rates": spatial_grips.spatial_fill_deflection_rates,
        },
        FORM: {
            **_RIGID[FORM],
            "times_mass": spatial_form.spatial_times_mass,
            "displace": spatial_form.spatial_displace,
            "position_rate": spatial_form.spatial_position_rate,
        },
    },
    "relative_planar": {
        MOTION: {
            **NO_ROWS,
            "derivative": relative_planar.relative_planar_derivative,
            "expand": relative_planar.expand_planar,
            "take_velocities": relative_planar.take_planar_velocities,
        },
        EVENTS: {
            **PASSED_ON,
            "position_rate": relative_planar.relative_planar_position_rate,
            "rate_from": relative_planar.relative_planar_position_rate,
        },
    },
    "relative_spatial": {
        MOTION: {
            **NO_ROWS,
            "derivative": relative_spatial.relative_spatial_derivative,
            "expand": relative_spatial.expand_spatial,
            "take_velocities": relative_spatial.take_spatial_velocities,
            "compliance": relative_spatial.relative_spatial_compliance,
            "project": relative_spatial.relative_spatial_project,
        },
        EVENTS: {
            **PASSED_ON,
            "position_rate": relative_spatial.relative_spatial_position_rate,
            "rate_from": relative_spatial.relative_spatial_rate_from,
        },
    },
    "particles": {
        MOTION: {**NO_ROWS, "derivative": particles.particle_derivative},
        FORM: {"multipliers": particles.particle_multipliers},
        REPORT: {"contact_forces": _no_forces},
    },
}


@cache
def _addresses(core: str, group: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the places in a handle and the addresses of a group's answers, which are compiled if they never were."""
    return addresses(({UNEVENTFUL: NO_EVENTS} | ANSWERS[core]).get(group, {}), *HANDLES[core])


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
def call_roots(model, work, t, y, duration, table):
    """Entry point from Python."""
    return ask.roots(model, work, t, y, duration, table)


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
