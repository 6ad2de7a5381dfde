"""Who answers which question (mbs_ref.kernels.border.questions): the table of the cores, and what Python itself asks.

Answers come in groups, and a system is prepared for a group when it is needed, so that nothing else is compiled. An
answer is named after its question and those whose answer it is: `spatial_tangent`, or `rigid_project` of both cores.
"""

import pkgutil
from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from mbs_ref.kernels import rigid
from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.border.calls import addresses, unanswered
from mbs_ref.kernels.border.handles import QUESTIONS
from mbs_ref.kernels.jit import entry, jit
from mbs_ref.kernels.particles import dynamics as particles
from mbs_ref.kernels.particles.model import ParticleModel, ParticleWork
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.relative import events as relative
from mbs_ref.kernels.relative import planar as relative_planar
from mbs_ref.kernels.relative import spatial as relative_spatial
from mbs_ref.kernels.relative.model import TreeModel, TreeModelInLanes, TreeWork, TreeWorkInLanes
from mbs_ref.kernels.spatial import contacts as spatial_contacts
from mbs_ref.kernels.spatial import dynamics as spatial

MOTION = "motion"  # what every run asks
EVENTS, UNEVENTFUL = "events", "uneventful"  # of contacts, one-sided springs and declared events; of scenes without
LOOPS, OPEN = "loops", "open"  # of closed loops, rows of contacts among them; of trees
NO = "no "  # before a feature, of scenes without it
LOADS, ROWS, GRIPS, HELD = "loads", "rows", "grips", "held"
SWITCHES, PRUNED, GRANULES, REFINED = "switches", "pruned", "granules", "refined"
FEATURES = {  # each with its questions
    LOADS: "apply_given_loads",  # but gravity, contacts and granules
    ROWS: "fill_further_rows",  # of joints, but those of shared points and rods
    GRIPS: "settle_grips slip_velocities",  # of contacts that can stick
    HELD: "settle_held fill_contact_rows",  # of contacts that are constraints
    SWITCHES: "switch_roots switch_transition start_switches",  # of tension-only springs and declared events
    PRUNED: "find_near",  # of pairs of shapes, of which the near ones alone are examined
    GRANULES: "apply_granules",  # of many bodies that may all touch
    REFINED: "refine",  # of solutions that elimination alone may spoil: with loops or contacts
}
TANGENT = "tangent"  # of directions along the constraints; loops need it on the way
FORM = "form"  # of methods on the DAE itself
REPORT = "report"  # afterwards
BESIDE = "beside"  # of the system of a lane
LANES = "lanes"  # of runs side by side
LANES_LOADS, LANES_ROWS = "loads in lanes", "rows in lanes"  # that depend neither on the time nor on modes
LOADS_ALONE, ROWS_ALONE = "loads alone", "rows alone"  # any, with the system of each lane
GROUPS = {
    MOTION: "derivative compliance project regularity accelerate fill_rows apply_loads expand take_velocities",
    EVENTS: "position_count root_count roots transition start_modes contact_mobility apply_contacts "
    "fill_deflection_rates position_rate rate_from",
    UNEVENTFUL: "root_count roots transition start_modes contact_mobility apply_contacts fill_deflection_rates",
    **FEATURES,
    **{NO + name: questions for name, questions in FEATURES.items()},
    LOOPS: "factor solve tangent",
    TANGENT: "tangent",
    OPEN: "factor solve",
    FORM: "multipliers position_count force_balance times_mass answer row_times add_row displace position_rate "
    "defect_of gamma_of",
    REPORT: "contact_forces",
    BESIDE: "apply_further_loads",
    LANES: "derivative project regularity accelerate fill_deflection_rates refine",
    **dict.fromkeys((LANES_LOADS, LOADS_ALONE), "apply_loads"),
    **dict.fromkeys((LANES_ROWS, ROWS_ALONE), "fill_rows"),
}
IN_LANES = " in lanes"  # behind the name of a core
HANDLES: dict[str, tuple[type, type]] = {  # core -> what its own code takes a model and a scratch for
    "planar": (planar.PlanarModel, planar.PlanarWork),
    "spatial": (spatial.SpatialModel, spatial.SpatialWork),
    "relative_planar": (TreeModel, TreeWork),
    "relative_spatial": (TreeModel, TreeWork),
    "particles": (ParticleModel, ParticleWork),
    "planar in lanes": (planar.PlanarModelInLanes, planar.PlanarWorkInLanes),
    "spatial in lanes": (spatial.SpatialModelInLanes, spatial.SpatialWorkInLanes),
    "relative_planar in lanes": (TreeModelInLanes, TreeWorkInLanes),
    "relative_spatial in lanes": (TreeModelInLanes, TreeWorkInLanes),
}
_ENDINGS = {OPEN: "_open", LOADS_ALONE: "_alone", ROWS_ALONE: "_alone"}  # of answers' names
_RIGID = [import_module(f"{rigid.__name__}.{module.name}") for module in pkgutil.iter_modules(rigid.__path__)]
_OWN = {  # core -> the first words of its answers' names, and their modules
    "planar": (("planar", "rigid"), (planar, *_RIGID)),
    "spatial": (("spatial", "rigid"), (spatial, spatial_contacts, *_RIGID)),
    "relative_planar": (("relative_planar", "relative"), (relative_planar, relative)),
    "relative_spatial": (("relative_spatial", "relative"), (relative_spatial, relative)),
    "particles": (("particle",), (particles,)),
}
# The answers about what a scene does not have: constraint rows, events, contacts, features.
_ABSENT: dict[str, Callable[..., Any]] = {
    "compliance": jit(lambda model, work, t, y: (0.0, 0.0)),
    "project": jit(lambda model, work, t, y, tolerance, most: 0.0),
    "tangent": jit(lambda model, work, x: None),
    "regularity": jit(lambda work: 1.0),
    "root_count": jit(lambda model: 0),
    "roots": jit(lambda model, work, t, y, duration, table: False),
    "transition": jit(lambda model, work, t, span, y, g, dy: (0, 0)),
    "start_modes": jit(lambda model, work, t, y, located: None),
    "contact_mobility": jit(lambda model, work, t, y, k: 0.0),
    "apply_contacts": jit(lambda model, work: None),
    "apply_given_loads": jit(lambda model, work, t: None),
    "fill_further_rows": jit(lambda model, work, t: None),
    "settle_grips": jit(lambda model, work, t, y, dy: None),
    "slip_velocities": jit(lambda model, work, y, slips: None),
    "settle_held": jit(lambda model, work, t, y, g: None),
    "switch_roots": jit(lambda model, work, table: None),
    "switch_transition": jit(lambda model, g: False),
    "start_switches": jit(lambda model, work, located: None),
    "find_near": jit(lambda model, work, duration: False),
    "apply_granules": jit(lambda model, work: None),
    "refine": jit(lambda model, work, forces, factor: None),
    "fill_contact_rows": jit(lambda model, work: None),
    "fill_deflection_rates": jit(lambda model, work, dy: None),
    "contact_forces": jit(lambda model, work, t, y, forces: None),
}


def _answers(core: str, group: str) -> dict[str, Callable[..., Any]]:
    """Return the answers of a core to the questions of a group."""
    words, modules = _OWN[core.removesuffix(IN_LANES)]
    words = ("lanes", *words) if core.endswith(IN_LANES) else words
    modules = () if group == UNEVENTFUL or group.startswith(NO) else modules
    known = {name: item for one in modules for name, item in vars(one).items()}
    absent, end = {} if group in (EVENTS, *FEATURES) else _ABSENT, _ENDINGS.get(group, "")
    names = {question: [f"{word}_{question}{end}" for word in words] for question in GROUPS[group].split()}
    found = {q: next((known[name] for name in own if name in known), absent.get(q)) for q, own in names.items()}
    return {question: answer for question, answer in found.items() if answer is not None}


ANSWERS = {core: {group: _answers(core, group) for group in GROUPS} for core in HANDLES}


@cache
def _addresses(core: str, group: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the places in a handle and the addresses of a group's answers, which are compiled if they never were."""
    return addresses(ANSWERS[core][group], *HANDLES[core])


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


# Entry points from Python.
call_contact_mobility = entry(lambda model, work, t, y, k: ask.contact_mobility(model, work, t, y, k))
call_start_modes = entry(lambda model, work, t, y, located: ask.start_modes(model, work, t, y, located))
call_roots = entry(lambda model, work, t, y, duration, table: ask.roots(model, work, t, y, duration, table))
call_regularity = entry(lambda work: ask.regularity(work))
call_derivative = entry(lambda model, work, t, y, dy: ask.derivative(model, work, t, y, dy))
call_compliance = entry(lambda model, work, t, y: ask.compliance(model, work, t, y))
call_project = entry(lambda model, work, t, y, tolerance, most: ask.project(model, work, t, y, tolerance, most))
call_tangent = entry(lambda model, work, x: ask.tangent(model, work, x))
