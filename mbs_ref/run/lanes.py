"""Runs side by side in vector lanes: which scenes and settings can, and how the runs are made."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mbs_ref.cores.relative.layout import no_tree
from mbs_ref.cores.relative.system import RelativePlanarSystem
from mbs_ref.integrators import DEFAULT
from mbs_ref.integrators.loop.lanes import Runs, advance_in_lanes, propose_all, runs_from, side_by_side
from mbs_ref.integrators.loop.leg import DONE
from mbs_ref.integrators.stages.tableau import DOP853
from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.kernels.relative.lanes import build_of, figures_of
from mbs_ref.run.legs import Counts, Run, planned_legs, reached, run_legs
from mbs_ref.run.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.scene.units import is_celestial
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status

NOTE = f"made in {WIDTH} lanes, in relative coordinates"
MOST_AT_ONCE = 4_000_000  # numbers of states that a piece of work may hold: 32 MB
PIECES = 4  # of the work for each thread, so that none waits long for the others
ROUNDS = 8  # runs a lane makes at least in a piece: at its end lanes are idle


class Bunch(NamedTuple):
    """Runs of one scene from several states."""

    system: RelativePlanarSystem
    plan: Plan
    starts: np.ndarray  # (n, n_state)


def why_not_in_lanes(scene: Scene, settings: Settings) -> str:
    """Return why runs cannot be made in lanes, or nothing.

    They can for planar trees of revolute, prismatic and weld joints and free bodies under gravity alone, by DOP853 with
    tolerances.
    """
    return "; ".join(_reasons(scene, settings))


def _reasons(scene: Scene, settings: Settings) -> Iterator[str]:
    if scene.dimension != 2:
        yield f"scene {scene.name!r} is spatial; lanes take planar ones"
    loads = [load.name for load in (*scene.loads, *scene.contacts, *scene.events)]
    if loads:
        yield f"{', '.join(loads[:4])}: lanes know gravity alone"
    if settings.method not in (None, DEFAULT) or settings.step is not None:
        yield f"lanes are for {DEFAULT} with tolerances"
    if settings.outputs == "dense":
        yield "outputs = 'dense': lanes end steps at outputs"
    if settings.stabilization == "baumgarte":
        yield "stabilization = 'baumgarte' has nothing to act on in relative coordinates"
    if is_celestial(scene):
        yield "bodies of the sky are particles"
    else:
        yield from no_tree(scene)


def pieces(count: int, threads: int, numbers: int) -> list[slice]:
    """Divide so many runs, each with so many numbers of states, into pieces of work for threads."""
    even = max(ROUNDS * WIDTH, -(-count // (PIECES * threads)))
    most = max(WIDTH, MOST_AT_ONCE // (2 * numbers))
    size = min(even, most)
    return [slice(k, min(k + size, count)) for k in range(0, count, size)]


def alike(bunch: Bunch) -> bytes:
    """Return what bunches that go side by side have in common: the build of the tree, and the output times."""
    return build_of(bunch.system.figures) + bunch.plan.times.tobytes()


def runs_in_lanes(bunches: Sequence[Bunch], refine: int = 1) -> list[list[Run]]:
    """Return the runs of each of some bunches that are alike, as `run_legs` makes each.

    One that does not reach its end is made again alone, which tells why. `loop_s` is the mean over the runs.
    """
    leg = planned_legs(bunches[0].system, bunches[0].plan, refine)[0]
    began = time.perf_counter()
    made = _advanced(bunches, leg.times)
    loop_s = (time.perf_counter() - began) / max(1, len(made.t))
    is_well = (made.code == DONE) & np.isfinite(made.states).all(axis=(1, 2))
    asked = np.concatenate(([0], leg.asked))

    def run(k: int) -> Run:
        bunch = bunches[made.scene[k]]
        if is_well[k]:
            return _complete(bunch.plan, made, k, made.states[k, asked], loop_s)
        return run_legs(bunch.system, bunch.plan, made.states[k, 0].copy(), refine)

    return [[run(k) for k in range(first, last)] for first, last in _places(bunches)]


def _places(bunches: Sequence[Bunch]) -> list[tuple[int, int]]:
    """Return where the runs of each bunch begin and end among all."""
    ends = np.cumsum([0, *(len(bunch.starts) for bunch in bunches)]).tolist()
    return list(itertools.pairwise(ends))


def _advanced(bunches: Sequence[Bunch], times: np.ndarray) -> Runs:
    figures = np.stack([figures_of(bunch.system.figures) for bunch in bunches])
    atol = np.stack([bunch.plan.options.atol for bunch in bunches])
    scene = np.repeat(np.arange(len(bunches)), [len(bunch.starts) for bunch in bunches])
    runs = runs_from(figures, atol, scene, np.concatenate([bunch.starts for bunch in bunches]), len(times))
    side, tree = side_by_side(atol.shape[1], len(DOP853.b)), bunches[0].system.in_lanes()
    with np.errstate(all="ignore"):
        for (system, plan, _), (first, last) in zip(bunches, _places(bunches), strict=True):
            propose_all(system.model, system.work, plan.options, runs, first, last, times, DOP853.order)
        advance_in_lanes(tree, DOP853, bunches[0].plan.options, runs, side, times, 0, len(scene))
    return runs


def _complete(plan: Plan, runs: Runs, k: int, states: np.ndarray, loop_s: float) -> Run:
    """Return run k, which reached its end; no state breaks a constraint."""
    steps, rejected, cut, calls = (int(count[k]) for count in (runs.steps, runs.rejected, runs.cut, runs.rhs_calls))
    counts = Counts(steps, rejected, cut, calls, 0, 0)
    return Run(plan.times, states, np.zeros(len(states)), counts, Status.SUCCESS, reached(plan), loop_s, 0.0)
