"""method = "auto": the method of a run, chosen from the scene's parts, with the reason.

A method that runs on one core alone exploits its structure and is chosen there. All other runs start with the default,
and their first steps decide whether a stiff method is cheaper (simulate/method/first_steps.py). Loops, trees and many
outputs have no effect on the choice: for no scene of the library do they make another method the cheapest at equal
error (`python -m benchmarks.method_table`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref.cores.choice import core_name
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.plan import DEFAULT_TOLERANCE, Plan, make_plan

AUTO = "auto"


def choose_plan(scene: Scene, settings: Settings, times: np.ndarray | None) -> Plan:
    """Return the plan of a run whose method may be "auto"."""
    if settings.method != AUTO:
        return make_plan(scene, settings, times)
    plain = _default(scene, settings, times, "the default")
    core = core_name(scene, settings.coordinates)
    special = [entry for entry in integrators().values() if entry.cores == (core,)]
    if plain.options.step:
        return replace(plain, reason="the default, because a step is given")
    if not special:
        return plain
    try:
        return plan_by(scene, settings, times, special[0], f"specific to {core}")
    except ValueError as error:  # the settings request a feature that it lacks
        return replace(plain, reason=f"the default, because {error}")


def plan_by(scene: Scene, settings: Settings, times: np.ndarray | None, integrator: Integrator, reason: str) -> Plan:
    """Return the plan of a chosen method at the requested tolerance.

    A method that accepts steps with an error of `slack` times the tolerance receives a tolerance tighter by as much.
    """
    rtol = (settings.rtol or DEFAULT_TOLERANCE) / integrator.slack
    atol = settings.atol and settings.atol / integrator.slack
    own = settings.model_copy(update={"method": integrator.name, "rtol": rtol, "atol": atol})
    return replace(make_plan(scene, own, times), settings=settings, reason=reason)


def without(scene: Scene, plan: Plan, why: str) -> Plan:
    """Return the default method's plan for a run in which the chosen method failed."""
    reason = f"the default, because {plan.integrator.name} failed: {why}"
    return _default(scene, plan.settings, plan.times, reason)


def _default(scene: Scene, settings: Settings, times: np.ndarray | None, reason: str) -> Plan:
    plain = make_plan(scene, settings.model_copy(update={"method": DEFAULT}), times)
    return replace(plain, settings=settings, reason=reason)
