"""Runs of one scene side by side in vector lanes: which scenes and settings can, and how the runs are made."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.relative.system import RelativePlanarSystem
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.lanes import Runs, advance_in_lanes, propose_all, runs_from, side_by_side
from mbs_ref.integrators.loop.leg import DONE
from mbs_ref.integrators.stages.dop853_tableau import TABLEAU
from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.run.legs import Counts, Run, planned_legs, reached, run_legs
from mbs_ref.run.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status

NOTE = f"made in {WIDTH} lanes, in relative coordinates"
MOST_AT_ONCE = 4_000_000  # numbers of states that a piece of work may hold: 32 MB
PIECES = 4  # of the work for each thread, so that none waits long for the others
ROUNDS = 8  # runs a lane makes at least in a piece: at its end lanes are idle


def why_not_in_lanes(scene: Scene, settings: Settings) -> str:
    """Return why runs cannot be made in lanes, or nothing.

    They can for planar trees of revolute, prismatic and weld joints and free bodies under gravity alone, by DOP853 with
    tolerances.
    """
    reasons = list(_reasons(scene, settings))
    if not reasons:
        try:
            if not isinstance(compile_scene(scene, "relative"), RelativePlanarSystem):
                reasons.append("bodies of the sky are particles")
        except ValueError as error:
            reasons.append(str(error))
    return "; ".join(reasons)


def _reasons(scene: Scene, settings: Settings) -> Iterator[str]:
    if scene.dimension != 2:
        yield f"scene {scene.name!r} is spatial; lanes take planar ones"
    loads = [load.name for load in (*scene.loads, *scene.contacts, *scene.events)]
    if loads:
        yield f"{', '.join(loads[:4])}: lanes know gravity alone"
    if settings.method not in (None, DEFAULT) or settings.step is not None:
        yield f"lanes are for {DEFAULT} with tolerances"
    if settings.stabilization == "baumgarte":
        yield "stabilization = 'baumgarte' has nothing to act on in relative coordinates"


def pieces(count: int, threads: int, plan: Plan, n_state: int) -> list[slice]:
    """Divide so many runs into pieces of work for threads."""
    even = max(ROUNDS * WIDTH, -(-count // (PIECES * threads)))
    most = max(WIDTH, MOST_AT_ONCE // (2 * len(plan.times) * n_state))
    size = min(even, most)
    return [slice(k, min(k + size, count)) for k in range(0, count, size)]


def runs_in_lanes(system: RelativePlanarSystem, plan: Plan, starts: np.ndarray, refine: int = 1) -> list[Run]:
    """Return the runs from starts (n, n_state), as `run_legs` makes each.

    One that does not reach its end is made again alone, which tells why. `loop_s` is the mean over the runs.
    """
    leg = planned_legs(system, plan, refine)[0]
    began = time.perf_counter()
    made = _advanced(system, plan, leg.times, starts)
    loop_s = (time.perf_counter() - began) / max(1, len(starts))
    is_well = (made.code == DONE) & np.isfinite(made.states).all(axis=(1, 2))
    asked = np.concatenate(([0], leg.asked))
    return [
        _complete(plan, made, k, made.states[k, asked], loop_s) if is_well[k]
        else run_legs(system, plan, starts[k].copy(), refine)
        for k in range(len(starts))
    ]  # fmt: skip


def _advanced(system: RelativePlanarSystem, plan: Plan, times: np.ndarray, starts: np.ndarray) -> Runs:
    runs = runs_from(starts, len(times))
    side = side_by_side(starts.shape[1], len(TABLEAU.b))
    with np.errstate(all="ignore"):
        propose_all(system.model, system.work, plan.options, runs, times, TABLEAU.order)
        advance_in_lanes(system.in_lanes(), TABLEAU, plan.options, runs, side, times, 0, len(starts))
    return runs


def _complete(plan: Plan, runs: Runs, k: int, states: np.ndarray, loop_s: float) -> Run:
    """Return run k, which reached its end; no state breaks a constraint."""
    counts = Counts(int(runs.steps[k]), int(runs.rejected[k]), int(runs.rhs_calls[k]), 0, 0)
    return Run(plan.times, states, np.zeros(len(states)), counts, Status.SUCCESS, reached(plan), loop_s, 0.0)
