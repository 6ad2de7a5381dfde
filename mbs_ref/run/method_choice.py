"""method = "auto": the method of a run, chosen by what the scene contains, and why.

A method that is made for one core alone knows more of its scenes than the others, so it is chosen there. Everything
else begins with the default; whether a stiff method is better is told by the first steps (self_checks/first_steps.py).
Loops, trees and many outputs change nothing: over the scenes of the library no other method is the cheapest at equal
error because of them (`python -m benchmarks.method_table`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref.cores.choice import core_name
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.run.plan import DEFAULT_TOLERANCE, Plan, make_plan
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

AUTO = "auto"


def choose_plan(scene: Scene, settings: Settings, times: np.ndarray | None) -> Plan:
    """Return the plan of a run whose method may be left to us."""
    if settings.method != AUTO:
        return make_plan(scene, settings, times)
    plain = _default(scene, settings, times, "the default")
    core = core_name(scene, settings.coordinates)
    special = [entry for entry in integrators().values() if entry.cores == (core,)]
    if plain.options.step:
        return replace(plain, reason="the default, for a step was given")
    if not special:
        return plain
    try:
        return plan_by(scene, settings, times, special[0], f"made for {core} alone")
    except ValueError as error:  # the settings ask for what it lacks
        return replace(plain, reason=f"the default, for {error}")


def plan_by(scene: Scene, settings: Settings, times: np.ndarray | None, integrator: Integrator, reason: str) -> Plan:
    """Return the plan by a method that was chosen, which keeps the tolerance that was asked for.

    Where a step may err more than its tolerance and be accepted, the method is given one tighter by as much.
    """
    rtol = (settings.rtol or DEFAULT_TOLERANCE) / integrator.slack
    atol = settings.atol and settings.atol / integrator.slack
    own = settings.model_copy(update={"method": integrator.name, "rtol": rtol, "atol": atol})
    return replace(make_plan(scene, own, times), settings=settings, reason=reason)


def without(scene: Scene, plan: Plan, why: str) -> Plan:
    """Return the default's plan of a run in which the method that was chosen broke down."""
    reason = f"the default, for {plan.integrator.name} broke down: {why}"
    return _default(scene, plan.settings, plan.times, reason)


def _default(scene: Scene, settings: Settings, times: np.ndarray | None, reason: str) -> Plan:
    plain = make_plan(scene, settings.model_copy(update={"method": DEFAULT}), times)
    return replace(plain, settings=settings, reason=reason)
