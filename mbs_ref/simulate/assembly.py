"""A Trajectory of a run: poses, reactions, counts, notes and the estimate of its error; without samples if refused."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.run.legs import Run
from mbs_ref.run.many import stopped
from mbs_ref.run.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.self_checks.consistent_start import InconsistentScene
from mbs_ref.self_checks.error_estimate import ENDED, Beside, estimated
from mbs_ref.self_checks.rank_watch import singular_passage
from mbs_ref.self_checks.soundness import UnsoundScene
from mbs_ref.trajectory import Status, Timing, Trajectory


class Samples(NamedTuple):
    """What the states of a run say."""

    poses: Poses
    reactions: dict[str, np.ndarray]


def sampled(system: System, plan: Plan, runs: list[Run]) -> list[Samples]:
    """Return what the states of each run say, asked of all of them at once: of scenes without events."""
    if not runs:
        return []
    times, states = np.concatenate([run.times for run in runs]), np.concatenate([run.states for run in runs])
    poses, reactions = system.poses(states), _reactions(system, plan, times, states)
    ends = np.cumsum([0, *(len(run.times) for run in runs)]).tolist()
    own = [slice(*pair) for pair in itertools.pairwise(ends)]
    return [Samples(Poses(*(part[at] for part in poses)), {n: part[at] for n, part in reactions.items()}) for at in own]


def trajectory(system: System, plan: Plan, run: Run, notes: list[str], timing: Timing, samples: Samples) -> Trajectory:
    times, states, counts = run.times, run.states, run.counts
    contacts = system.contact_forces(times, states) if system.scene.contacts and plan.settings.reactions else {}
    return Trajectory(
        times=times,
        **samples.poses._asdict(),
        status=run.status,
        message=run.message,
        steps=counts.steps,
        rejected_steps=counts.rejected_steps,
        cut_steps=counts.cut_steps,
        rhs_calls=counts.rhs_calls,
        events=counts.events,
        method_switches=counts.switches if plan.integrator.switches else None,
        timing=timing,
        step_compliance=np.column_stack((times, run.compliance)),
        notes=(*_chosen(plan), *notes, *_other_ways(plan, run), *singular_passage(system, times, states)),
        method=plan.integrator.name,
        reason=plan.reason,
        used=_used(plan, run),
        contacts=contacts,
        event_times=system.contact_events() if system.event_sources else None,
        event_names=system.event_sources,
        reactions=samples.reactions,
    )


def with_estimate(
    system: System, plan: Plan, run: Run, path: Trajectory, companion: Beside | None = None
) -> Trajectory:
    """Add the estimate of its error to a run that ended well, and say what it is worth."""
    if run.status not in ENDED or plan.settings.estimate == "off":
        return path
    estimate = estimated(system, plan, run, Poses.of(path), companion)
    if estimate is None:
        reason = "interrupted while a second run estimated the error of this one, which is complete"
        return replace(path, status=Status.INTERRUPTED, message=reason)
    remark = estimate.remark()
    if estimate.is_void:
        return replace(path, estimate=estimate, status=Status.UNRESOLVED, message=f"no output has a digit: {remark}")
    return replace(path, estimate=estimate, notes=(*path.notes, remark) if remark else path.notes)


def _chosen(plan: Plan) -> tuple[str, ...]:
    """Say which method ran and why, where that was left to us."""
    return (f"method auto is {plan.integrator.name}: {plan.reason}",) if plan.reason else ()


def _other_ways(plan: Plan, run: Run) -> tuple[str, ...]:
    """Say how often the method changed its family, and for what share of the time another went on in its place."""
    name, families, share = plan.integrator.name, plan.integrator.switches, run.carried_share
    changed = (f"{name} changed {run.counts.switches} times between {families}",) if families else ()
    carried = (f"DOP853 carried {name} past singular poses, for {share:.2g} of the time",) if share else ()
    return changed + carried


def _used(plan: Plan, run: Run) -> dict[str, float]:
    """Return the settings that the run had, defaults included, and what share of the time another method made."""
    options = plan.options
    accuracy = {"step": options.step} if options.step else {"rtol": options.rtol, "atol": float(options.atol[0])}
    restored = {"projection_tolerance": options.projection_tolerance} if options.project else {}
    damped = {"baumgarte_gain": plan.baumgarte_gain} if plan.baumgarte_gain else {}
    carried = {"carried_share": run.carried_share} if run.carried_share else {}
    return accuracy | restored | damped | carried | {"samples": len(plan.times)}


def _reactions(system: System, plan: Plan, times: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
    """Evaluate joint reactions at the output times."""
    if not plan.settings.reactions:
        return {}
    system.set_baumgarte(0.0)
    return system.reactions_over(times, states)


def or_stopped[T](scene: Scene, make: Callable[[], T], refusal: type[ValueError] = UnsoundScene) -> T | Trajectory:
    """Return what is made, or a trajectory that ended before it began.

    It is `inconsistent` where the start breaks a constraint, and `refused` by such errors; others are raised.
    """
    try:
        return make()
    except InconsistentScene as error:
        return stopped(scene, Status.INCONSISTENT, str(error))
    except refusal as error:
        return stopped(scene, Status.REFUSED, str(error))
