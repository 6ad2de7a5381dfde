"""Assemble the Trajectory of a run: poses, reactions, counts, notes and the estimate of its error."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.scene import Scene
from mbs_ref.simulate.diagnosis import singular_passage, unseen_forces
from mbs_ref.simulate.error_estimate import ENDED, Companion, estimated
from mbs_ref.simulate.legs import Run
from mbs_ref.simulate.linearised import unstable_passage
from mbs_ref.simulate.plan import Plan
from mbs_ref.simulate.start.consistent import InconsistentScene
from mbs_ref.simulate.start.soundness import UnsoundScene
from mbs_ref.trajectory import Status, Timing, Trajectory


class Samples(NamedTuple):
    """Poses and reactions at the outputs of a run."""

    poses: Poses
    reactions: dict[str, np.ndarray]


def sampled(system: System, plan: Plan, runs: list[Run]) -> list[Samples]:
    """Return the samples of each run, evaluated for all runs at once; several runs need a scene without events."""
    if not runs:
        return []
    times, states = np.concatenate([run.times for run in runs]), np.concatenate([run.states for run in runs])
    poses, reactions = system.poses(states), {}
    if plan.settings.reactions:
        system.set_baumgarte(0.0)
        reactions = system.reactions_over(times, states)
    ends = np.cumsum([0, *(len(run.times) for run in runs)]).tolist()
    own = [slice(*pair) for pair in itertools.pairwise(ends)]
    return [Samples(Poses(*(part[at] for part in poses)), {n: part[at] for n, part in reactions.items()}) for at in own]


def trajectory(system: System, plan: Plan, run: Run, notes: list[str], timing: Timing, samples: Samples) -> Trajectory:
    """Return the trajectory of a run, without an estimate of its error."""
    times, states = run.times, run.states
    passages = singular_passage(system, times, states)
    if run.status in ENDED:
        passages += unstable_passage(system, plan, times, states)
    chosen = (f"method auto is {plan.integrator.name}: {plan.reason}",) if plan.reason else ()
    return Trajectory(
        times=times,
        **samples.poses._asdict(),
        status=run.status,
        message=run.message,
        **{name: count for name, count in run.counts._asdict().items() if name != "switches"},
        method_switches=run.counts.switches if plan.integrator.switches else None,
        timing=timing,
        step_compliance=np.column_stack((times, run.compliance)),
        notes=(*chosen, *notes, *_other_methods(plan, run), *passages),
        method=plan.integrator.name,
        reason=plan.reason,
        used=_used(plan, run),
        contacts=system.contact_forces(times, states) if system.scene.contacts and plan.settings.reactions else {},
        event_times=system.contact_events() if system.event_sources else None,
        event_names=system.event_sources,
        reactions=samples.reactions,
    )


def with_estimate(
    system: System, plan: Plan, run: Run, path: Trajectory, companion: Companion | None = None
) -> Trajectory:
    """Return the trajectory of a run that ended well with the estimate of its error, and a note if it is large."""
    if run.status not in ENDED or plan.settings.estimate == "off":
        return path
    estimate = estimated(system, plan, run, Poses.of(path), companion)
    if estimate is None:
        reason = "interrupted while a second run estimated the error of this one, which is complete"
        return replace(path, status=Status.INTERRUPTED, message=reason)
    remark = estimate.remark()
    path = replace(path, notes=(*path.notes, *unseen_forces(system, path)))
    if estimate.is_void:
        return replace(path, estimate=estimate, status=Status.UNRESOLVED, message=f"no output has a digit: {remark}")
    return replace(path, estimate=estimate, notes=(*path.notes, remark) if remark else path.notes)


def _other_methods(plan: Plan, run: Run) -> tuple[str, ...]:
    """Return notes on changes of the method's family, and on the share of the time that DOP853 integrated."""
    name, families, share = plan.integrator.name, plan.integrator.switches, run.carried_share
    changed = (f"{name} changed {run.counts.switches} times between {families}",) if families else ()
    carried = (f"DOP853 carried {name} past singular poses, for {share:.2g} of the time",) if share else ()
    return changed + carried


def _used(plan: Plan, run: Run) -> dict[str, float]:
    """Return the settings in use, defaults included, and the share of the time that another method integrated."""
    options = plan.options
    accuracy = {"step": options.step} if options.step else {"rtol": options.rtol, "atol": float(options.atol[0])}
    restored = {"projection_tolerance": options.projection_tolerance} if options.project else {}
    damped = {"baumgarte_gain": plan.baumgarte_gain} if plan.baumgarte_gain else {}
    carried = {"carried_share": run.carried_share} if run.carried_share else {}
    return accuracy | restored | damped | carried | {"samples": len(plan.times)}


def empty(scene: Scene, status: Status, message: str) -> Trajectory:
    """Return the trajectory of a run that did not start."""
    return Trajectory.empty(len(scene.bodies), scene.dimension, status, message)


def or_empty[T](scene: Scene, make: Callable[[], T], refusal: type[ValueError] = UnsoundScene) -> T | Trajectory:
    """Return make(), or a trajectory without samples: `inconsistent` for InconsistentScene, `refused` for `refusal`."""
    try:
        return make()
    except InconsistentScene as error:
        return empty(scene, Status.INCONSISTENT, str(error))
    except refusal as error:
        return empty(scene, Status.REFUSED, str(error))
