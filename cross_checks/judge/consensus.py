"""A working truth where no certified one exists: what engines agree on that share as little as possible.

Every engine that runs the scene gives its best methods at fine settings: at two tolerances, or at three steps that
halve, of which the last two tell where they lead, and the first two how well. The pair is chosen that is closest, its
members' own last refinements included, of engines that stand on different packages: the scene is known to that
distance, agreed and not certified. Where that is too far to tell agreement by, as where a motion amplifies errors, all
give a finer setting still. Where one package runs the scene alone, two unlike methods of its must do, and the sentence
says so.
"""

from __future__ import annotations

from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.judge.extrapolation import extrapolated
from cross_checks.judge.ladder import knob_of, label, settings_at
from cross_checks.judge.runs import Runs, gap
from cross_checks.judge.vocabulary import AGREEMENT
from cross_checks.truth import MARGIN, NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

type Settings = dict[str, tuple[float, ...]]  # by the kind of a method, coarse to fine
FINE: Settings = {"adaptive": (1e-10, 1e-12), "fixed": (2e-4, 1e-4, 5e-5)}  # tolerances; steps over the duration
FINEST: Settings = {"adaptive": (1e-12, 1e-14), "fixed": (4e-5, 2e-5, 1e-5)}
WORST = 1e-3  # of the scene: engines further apart agree on nothing
ENOUGH = AGREEMENT / MARGIN  # of the scene: a truth that is known so well tells agreement
PER_ENGINE = 2  # methods asked of each


class Witness(NamedTuple):
    """The best that a method gives, and how far it moved from the next coarser."""

    engine: str
    library: str  # that it stands on
    method: str
    setting: str
    path: Trajectory
    moved: float  # over the scene's scales

    @property
    def name(self) -> str:
        return f"{self.engine} {self.method} {self.setting}"


class Pair(NamedTuple):
    """The two that agree best, and what they are believed to."""

    known_to: float  # over the scene's scales
    first: Witness
    second: Witness


def working_truth(runs: Runs, scene: Scene, reason: str = "") -> Truth | NoTruth:
    """Return what engines agree on; NoTruth with `reason` and the distance where they do not."""
    pair = _closest(scene, _witnesses(runs, scene, FINE))
    if pair is None:
        return NoTruth(f"{reason}; fewer than two methods run the scene to its end".lstrip("; "))
    if ENOUGH < pair.known_to <= WORST:
        finer = _closest(scene, _witnesses(runs, scene, FINEST))
        pair = min(pair, finer or pair, key=lambda one: one.known_to)
    if not pair.known_to <= WORST:
        told = f"the closest, {pair.first.name} and {pair.second.name}, are {pair.known_to:.1e} of the scene apart"
        return NoTruth(f"{reason}; engines agree on nothing: {told}".lstrip("; "))
    return _agreed(scene, pair.known_to, *sorted(pair[1:], key=lambda witness: witness.moved))


def _closest(scene: Scene, witnesses: list[Witness]) -> Pair | None:
    alone = len({witness.library for witness in witnesses}) == 1
    unlike = [(a, b) for a, b in combinations(witnesses, 2) if alone or a.library != b.library]
    pairs = [Pair(max(_distance(scene, a, b), a.moved, b.moved), a, b) for a, b in unlike]
    return min(pairs, key=lambda pair: pair.known_to, default=None)


def _agreed(scene: Scene, known_to: float, best: Witness, other: Witness) -> Truth:
    scales = scales_of(scene)
    alone = f"; both stand on {best.library}" if best.library == other.library else ""
    how = f"agreed, not certified: {best.name} and {other.name} are {known_to:.1e} of the scene apart{alone}"
    return Truth(
        best.path.position, best.path.orientation, known_to * scales.length, "agreed", how, known_to * scales.length,
        velocity=best.path.velocity, angular_velocity=best.path.angular_velocity,
        rate_uncertainty=np.full(len(best.path.times), known_to * max(scales.speed, 1.0 / scales.time)),
        turn_uncertainty=known_to,
    )  # fmt: skip


def _distance(scene: Scene, first: Witness, second: Witness) -> float:
    apart = gap(scene, first.path, second.path)
    return float("inf") if apart is None else apart


def _witnesses(runs: Runs, scene: Scene, settings: Settings) -> list[Witness]:
    witnesses = []
    for name in engines.names():
        try:
            engine = engines.get(name)
        except engines.EngineMissing:
            continue
        heard = (_heard(runs, scene, name, method, settings) for method in _best_methods(engine, scene))
        witnesses += [witness for witness in heard if witness is not None]
    return witnesses


def _best_methods(engine: Engine, scene: Scene) -> list[Method]:
    """Return the methods of highest order that run the scene and are not known to go wrong on it, unlike ones first."""
    if engine.refusals(scene):
        return []
    able = [m for m in engine.methods() if not engine.method_refusals(scene, m) and not m.excused(scene)]
    ranked = sorted(able, key=lambda m: (m.kind != "adaptive", -(m.order or 4)))
    return ranked[:PER_ENGINE]


def _heard(runs: Runs, scene: Scene, engine: str, method: Method, knobs: Settings) -> Witness | None:
    """Return the finest run, or where the runs lead if they do so more surely; None where one of them fails."""
    unit = scene.duration if method.kind == "fixed" else 1.0
    paths, settings = [], [settings_at(method, scene, unit * knob) for knob in knobs[method.kind]]
    for asked in settings:
        run = runs.run(scene, engine, asked)
        if run.record.status != "success" or run.path is None:
            return None
        paths.append(run.path)
    moved = gap(scene, *paths[-2:])
    if moved is None:
        return None
    plain = Witness(engine, engines.get(engine).library, method.name, label(settings[-1]), paths[-1], moved)
    if len(paths) < 3 or method.order is None:
        return plain
    steps = [knob_of(asked) for asked in settings]
    limits = [
        extrapolated(coarse, fine, wide / narrow, method.order)
        for (coarse, wide), (fine, narrow) in pairwise(zip(paths, steps, strict=True))
    ]
    settled = gap(scene, *limits[-2:])
    if settled is None or settled >= moved:
        return plain
    return plain._replace(setting=f"{plain.setting}, extrapolated,", path=limits[-1], moved=settled)
