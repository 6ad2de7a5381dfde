"""Was a fixed step short enough? The finished run judged by single steps and by a second run with half the step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref.cores import compile_scene
from mbs_ref.halved_step import disagreement
from mbs_ref.legs import Run, run_legs
from mbs_ref.plan import Plan
from mbs_ref.resolution import resolution
from mbs_ref.system import System
from mbs_ref.trajectory import Status

ADVICE = "take a shorter step or an adaptive method, or unresolved = 'keep'"


def judged(system: System, plan: Plan, run: Run) -> Run:
    """Return the finished run, `unresolved` where its fixed step is too long for the motion that was to be followed."""
    if not plan.options.step or plan.settings.unresolved == "keep":
        return run
    found = _damped(system, plan, run) or _against_half(system, plan, run)
    return run._replace(status=found[0], message=found[1]) if found else run


def _damped(system: System, plan: Plan, run: Run) -> tuple[Status, str] | None:
    """Judge single steps, where methods damp or alias fast motions; contact switches in the middle of a step."""
    if system.scene.contacts:
        return None
    found = resolution(system, plan.integrator, plan.options, run.times, run.states)
    if not found.lost:
        return None
    return Status.UNRESOLVED, (
        f"the step of {plan.options.step:g} s does not resolve the motion: steps of half its size move body "
        f"{found.body!r} elsewhere, most at t = {found.time:.6g} s, and over the run that adds up to "
        f"{found.share:.2g} of the whole motion; {ADVICE}"
    )


def _against_half(system: System, plan: Plan, run: Run) -> tuple[Status, str] | None:
    """Judge the run by a second one with half the step."""
    halved = _halved(system, plan, run.states[0])
    if halved.status is Status.INTERRUPTED:
        return halved.status, f"{halved.message} of the second run that judges the step; the first is complete"
    scene, count = system.scene, min(len(run.times), len(halved.times))
    order = 1 if scene.contacts or scene.events else plan.integrator.order
    found = disagreement(system.poses(run.states[:count]), system.poses(halved.states[:count]), order)
    if found.first is None and halved.status is Status.SUCCESS:
        return None
    good = count - 1 if found.first is None else max(found.first - 1, 0)
    why = (
        f"with half of it the run does not end: {halved.message}" if found.first is None else
        f"half of it takes body {scene.bodies[found.body].name!r} elsewhere, beyond the bound at "
        f"t = {run.times[found.first]:.6g} s and by an estimated {found.share:.2g} of the whole motion at worst"
    )  # fmt: skip
    return Status.UNRESOLVED, (
        f"the step of {plan.options.step:g} s does not resolve the motion: {why}; the last good output is at "
        f"t = {run.times[good]:.9g} s; {ADVICE}"
    )


def _halved(system: System, plan: Plan, start: np.ndarray) -> Run:
    """Repeat the run with half the step, on a system of its own."""
    other, y = compile_scene(system.scene), start.copy()
    other.set_mode_time(0.0)
    other.set_baumgarte(plan.baumgarte_gain)
    other.start_contacts(0.0, y, plan.settings.events != "none")
    options = plan.options._replace(max_steps=2 * plan.options.max_steps, stop_on_compliance=False)
    return run_legs(other, replace(plan, options=options), y, refine=2)
