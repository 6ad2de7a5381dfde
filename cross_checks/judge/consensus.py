"""Compute a consensus truth from two independent engines where no certified truth exists.

Every engine that runs the scene contributes its best methods. While the scene is not known well enough, the two runs
follow that are expected to lead there at the least cost; a method that is far off yet, or slow, or of low order on this
scene waits until no others do. A method's limit comes from two tolerances, or from three steps that halve: the last two
are extrapolated, and the first two show how well that works. The closest pair of methods is the truth; it is agreed and
not certified. The two belong to different packages. The distance includes each member's own last refinement and is the
uncertainty; while runs are under way, that of the member which moved more is left out. A method with a documented
weakness on the scene counts as dearer, and its partner in a pair must have none.

Runs that look for events at the same times are one witness. Each run therefore has output times of its own between
those of the judges, and each method steps of its own. Where one package runs the scene alone, two unlike methods of it
are the pair. Such a truth is of the kind "one-package": it confirms no method and classifies none as wrong.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple
from zlib import crc32

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import BRIEF, FIRST, TIMEOUT, Late, Over, Pool
from cross_checks.judge.bounds import AGREEMENT, TARGETS
from cross_checks.judge.convergence.prediction import extrapolated
from cross_checks.judge.ladder import knob_of, label, settings_at
from cross_checks.judge.runs import Runs, gap
from cross_checks.judge.tried import documented_order
from cross_checks.truths.truth import ONE_FIGURE, NoTruth, Truth
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.observables.distance import largest, relative
from mbs_ref.scene.scales import scales_of

LEVELS: tuple[dict[str, tuple[float, ...]], ...] = (
    {"adaptive": (1e-6, 1e-8), "fixed": (6.4e-4, 3.2e-4, 1.6e-4)},
    {"adaptive": (1e-8, 1e-10), "fixed": (1.6e-4, 8e-5, 4e-5)},
    {"adaptive": (1e-10, 1e-12), "fixed": (4e-5, 2e-5, 1e-5)},
    {"adaptive": (1e-12, 1e-14)},
)  # tolerances, and steps over the duration, by the kind of a method; each level begins where the one before ends
FINER = {"adaptive": 100.0, "fixed": 4.0}  # ratio of the tolerances, or of the steps, of a level to the one before
GUESS = 1.0  # s of a level of which nothing is known
TWO = 2  # levels that are sought at a time: of both members of a pair
DEARER = 4.0  # by which a documented weakness makes a method dearer, and a run that came late than BRIEF
WORST = TARGETS[0]  # of the scene: engines further apart agree on nothing
ENOUGH = AGREEMENT / ONE_FIGURE  # of the scene: a truth that is known so well shows agreement
PER_ENGINE = 2  # methods of each
BETWEEN = 4  # output times of a run between two of the judges'
UNKNOWN = NoTruth("engines have not agreed on one yet")
SPREAD = 0.25  # by which the steps of two methods at the same level differ at most


class Witness(NamedTuple):
    """The best that a method gives, and how far it moved from the next coarser."""

    engine: str
    library: str  # that it stands on
    method: str
    setting: str
    path: Trajectory
    moved: float  # over the scene's scales
    is_sound: bool = True  # whether no weakness on the scene is documented
    coarser: Trajectory | None = None  # that it moved from

    @property
    def name(self) -> str:
        return f"{self.engine} {self.method} {self.setting}"


class Pair(NamedTuple):
    """The two that agree best, and what they are believed to."""

    known_to: float  # over the scene's scales
    first: Witness
    second: Witness
    hoped: float = math.inf  # likewise, if the second has approached the first for no other reason than the truth

    @property
    def packages(self) -> int:
        return len({self.first.library, self.second.library})


class Request(NamedTuple):
    """A level of a method that a consensus waits for."""

    consensus: Consensus
    engine: str
    method: Method
    level: int

    @property
    def scene(self) -> Scene:
        return self.consensus.scene

    @property
    def library(self) -> str:
        """The package that its engine stands on."""
        return engines.get(self.engine).library

    def __str__(self) -> str:
        return f"{self.scene.name} {self.engine} {self.method.name} for the truth, level {self.level + 1}"


class Wanted(NamedTuple):
    """A level that may be requested, and the seconds that it is expected to take."""

    request: Request
    seconds: float = 0.0  # unknown before any run; more than BRIEF of what came late


class Consensus:
    """What engines agree on so far: `truth`, which is final when `is_settled`.

    Runs are requested from the pool, whose user hands every result of a Request to `receive`. A scene is settled when
    it is known to `enough` of its scales, or when no run remains. A run that computes for long is awaited only where
    the others agree on nothing, or where its method is one of the closest pair.
    """

    def __init__(self, pool: Pool, runs: Runs, scene: Scene, reason: str = "", enough: float = ENOUGH) -> None:
        self.scene = scene
        self._pool, self._runs, self._reason, self._enough = pool, runs, reason, enough
        self._witnesses: dict[tuple[str, str], Witness] = {}
        self._closest: dict[int, Pair] = {}  # by the number of packages, of all pairs so far
        able = [(engine.name, method) for engine in engines.installed() for method in best_methods(engine, scene)]
        self._packages = len({engines.get(name).library for name, _ in able})
        self._open: list[Request] = []
        self._waiting = [Wanted(Request(self, name, method, 0)) for name, method in able]
        self._request()

    @property
    def is_settled(self) -> bool:
        """Whether no run is under way."""
        return not self._open

    @property
    def pair(self) -> Pair | None:
        """The closest pair of two packages, else of one; as long as runs are under way, known to what is hoped."""
        closest = self._closest.get(2) or self._closest.get(1)
        return closest and (closest if self.is_settled else closest._replace(known_to=closest.hoped))

    @property
    def truth(self) -> Truth | NoTruth:
        """What the pair agrees on; NoTruth with its distance where that is nothing."""
        if self.pair is not None and self.pair.known_to <= WORST:
            return _agreed(self.scene, self.pair, self._advice(self.pair))
        why = "fewer than two methods run the scene to its end"
        if self.pair is not None:
            known_to, first, second, _ = self.pair
            apart = f"the closest, {first.name} and {second.name}, are {known_to:.1e} of the scene apart"
            who = "one package runs the scene, and its methods" if self.pair.packages == 1 else "engines"
            why = f"{who} agree on nothing: {apart}{self._advice(self.pair)}"
        kind = "one-package" if len({one.library for one in self._witnesses.values()}) == 1 else "none"
        return NoTruth(f"{self._reason}; {why}".lstrip("; "), kind)

    def _advice(self, pair: Pair) -> str:
        """Return until when a pair that is not known well enough agrees so well; empty where it is, or never does."""
        if pair.known_to <= self._enough:
            return ""
        runs = [(pair.first.path, pair.second.path)]
        runs += [(one.path, one.coarser) for one in (pair.first, pair.second) if one.coarser is not None]
        curves = [relative(self.scene, *both) for both in runs]
        off = largest(np.concatenate(curves, axis=1), 1)
        within = int(np.argmin(np.append(off <= self._enough, False)))  # samples from the start
        if not 1 < within < len(off):
            return ""
        until = f"up to t = {pair.first.path.times[within - 1]:.3g} s they agree within {self._enough:.0e} of it"
        return f"; {until}: a duration no longer than that has a better truth"

    def _is_known(self, distance: float) -> bool:
        """Whether the scene is known to a distance by two packages, or by one where no other can run it."""
        pair = self._closest.get(min(2, self._packages))
        return pair is not None and pair.known_to <= distance

    def receive(self, request: Request, result: tuple[Witness | None, float] | Late) -> None:
        """Take in what came of a request, and request what is needed next."""
        self._open.remove(request)
        if isinstance(result, Late):
            self._waiting += [] if isinstance(result, Over) else [Wanted(request, DEARER * BRIEF)]
        else:
            witness, seconds = result
            self._compare(witness)
            finer = request._replace(level=request.level + 1)
            if finer.level < len(LEVELS) and request.method.kind in LEVELS[finer.level]:
                self._waiting.append(Wanted(finer, _growth(request.method) * seconds))
        if self._is_known(self._enough):
            self._pool.drop(lambda name: name in self._open)
            self._open = []
        else:
            self._request()

    def _request(self) -> None:
        """Request the levels that are expected to lead to what is enough at the least cost: of TWO packages, if any."""
        costs = {wanted: self._cost(wanted) for wanted in self._waiting}
        costs = {wanted: cost for wanted, cost in costs.items() if self._decides(wanted, *cost)}
        cheap = {wanted.request.library for wanted, (_, cost) in costs.items() if cost <= TIMEOUT}
        for wanted in sorted(costs, key=lambda one: costs[one]):
            busy, library = {one.library for one in self._open}, wanted.request.library
            is_next = (library not in busy or self._packages == 1) and len(self._open) < TWO
            if is_next and (costs[wanted][1] <= TIMEOUT or len(busy | cheap) < TWO):
                self._waiting.remove(wanted)
                self._open.append(wanted.request)
                work, tries = partial(_timed, self._runs, wanted.request), FIRST if wanted.seconds > BRIEF else 0
                self._pool.add(wanted.request, work, tries=tries)  # before what waits for the truth

    def _decides(self, wanted: Wanted, package_is_known: bool, cost: float) -> bool:
        """Whether a level may matter: the scene is not known, its method is one of the closest pair, or it is cheap."""
        if not self._is_known(WORST):
            return True
        request, pair = wanted.request, self._closest[min(2, self._packages)]
        if any((one.engine, one.method) == (request.engine, request.method.name) for one in (pair.first, pair.second)):
            return True
        return not package_is_known and wanted.seconds <= BRIEF and cost <= TIMEOUT

    def _cost(self, wanted: Wanted) -> tuple[bool, float]:
        """Return whether the package is known, and the seconds until the method's own last refinement is enough.

        A method that was not run yet, or gave nothing, is off by the scene's scales.
        """
        engine, method, library = wanted.request.engine, wanted.request.method, wanted.request.library
        witness = self._witnesses.get((engine, method.name))
        off = max(self._enough, 1.0 if witness is None else min(1.0, witness.moved))
        falls = documented_order(method, self.scene) * math.log(FINER[method.kind])
        seconds = (wanted.seconds or GUESS) * (DEARER if method.exemption(self.scene) else 1.0)
        known = any(one.library == library and one.moved <= self._enough for one in self._witnesses.values())
        return known, seconds * _growth(method) ** (math.log(off / self._enough) / falls)

    def _compare(self, witness: Witness | None) -> None:
        if witness is None:
            return
        self._witnesses[witness.engine, witness.method] = witness
        for other in self._witnesses.values():
            if other is not witness and (witness.is_sound or other.is_sound):
                apart = _distance(self.scene, witness.path, other.path)
                best, second = sorted((witness, other), key=lambda one: one.moved)
                pair = Pair(max(apart, second.moved), best, second, max(apart, best.moved))
                self._closest[pair.packages] = min(self._closest.get(pair.packages, pair), pair, key=lambda p: p[0])


def working_truth(runs: Runs, scene: Scene, reason: str = "", enough: float = ENOUGH) -> Truth | NoTruth:
    """Return what engines agree on; NoTruth with `reason` and the distance where they do not."""
    with Pool(runs.call, brief=BRIEF) as pool:
        consensus = Consensus(pool, runs, scene, reason, enough)
        for request, result in pool:
            consensus.receive(request, result)
    return consensus.truth


def _agreed(scene: Scene, pair: Pair, advice: str = "") -> Truth:
    known_to, best, other, _ = pair
    scales = scales_of(scene)
    alone, how = pair.packages == 1, f"{best.name} and {other.name} are {known_to:.1e} of the scene apart{advice}"
    how = f"{how}, and both stand on {best.library}: one package, not certified" if alone else f"not certified: {how}"
    return Truth(
        best.path.position, best.path.orientation, known_to * scales.length, "one-package" if alone else "agreed", how,
        known_to * scales.length, velocity=best.path.velocity, angular_velocity=best.path.angular_velocity,
        rate_uncertainty=np.full(len(best.path.times), known_to * max(scales.speed, 1.0 / scales.time)),
        turn_uncertainty=known_to,
    )  # fmt: skip


def _distance(scene: Scene, first: Trajectory, second: Trajectory) -> float:
    """Return how far two runs are apart in all components, over the scene's scales; infinite where unknown."""
    apart = gap(scene, UNKNOWN, first, second)
    return math.inf if math.isnan(apart) else apart


def best_methods(engine: Engine, scene: Scene) -> list[Method]:
    """Return the methods of highest order that run the scene; those with a documented weakness on it come last."""
    able = engine.able(scene)
    return sorted(able, key=lambda m: (bool(m.exemption(scene)), m.kind != "adaptive", -(m.order or 4)))[:PER_ENGINE]


def _growth(method: Method) -> float:
    """Return what a level costs over the one before: the ratio of its steps."""
    return FINER[method.kind] ** (1.0 / method.local_order if method.kind == "adaptive" else 1.0)


def _timed(runs: Runs, request: Request, call: Caller) -> tuple[Witness | None, float]:
    """Return the witness, and the seconds that it took."""
    start, knobs = time.monotonic(), LEVELS[request.level][request.method.kind]
    witness = witness_of(replace(runs, call=call), request.scene, request.engine, request.method, knobs)
    return witness, time.monotonic() - start


def witness_of(runs: Runs, scene: Scene, engine: str, method: Method, knobs: tuple[float, ...]) -> Witness | None:
    """Return the finest run, or where the runs lead if they do so more surely; None where one of them fails."""
    own = np.random.default_rng(crc32(f"{engine} {method.name}".encode()))
    unit = scene.duration * (1.0 - SPREAD * own.random()) if method.kind == "fixed" else 1.0
    paths, settings = [], [settings_at(method, scene, unit * knob) for knob in knobs]
    for one in settings:
        path = _at_own_times(runs, scene, engine, one)
        if path is None:
            return None
        paths.append(path)
    moved = _distance(scene, *paths[-2:])
    library, is_sound = engines.get(engine).library, not method.exemption(scene)
    plain = Witness(engine, library, method.name, label(settings[-1]), paths[-1], moved, is_sound, paths[-2])
    if len(paths) < 3 or method.order is None:
        return plain
    steps = [knob_of(one) for one in settings]
    limits = [
        extrapolated(coarse, fine, wide / narrow, method.order)
        for (coarse, wide), (fine, narrow) in pairwise(zip(paths, steps, strict=True))
    ]
    settled = _distance(scene, *limits[-2:])
    if settled >= moved:
        return plain
    return plain._replace(setting=f"{plain.setting}, extrapolated,", path=limits[-1], moved=settled, coarser=limits[-2])


def _at_own_times(runs: Runs, scene: Scene, engine: str, settings: Settings) -> Trajectory | None:
    """Return a run at the judges' times, with further outputs between them; None where it fails."""
    common = runs.grid(scene)
    seed = crc32(f"{engine} {settings.method} {label(settings)}".encode())
    times = np.union1d(common, between(common, settings.step, np.random.default_rng(seed)))
    run = replace(runs, times=times).run(scene, engine, settings)
    if run.record.status != "success" or run.path is None or len(run.path.times) != len(times):
        return None
    return replace(run.path.at(np.isin(times, common)), reactions={}, contacts={})


def between(times: np.ndarray, step: float | None, random: np.random.Generator) -> np.ndarray:
    """Return BETWEEN random times (s) in each interval; where there is a step, multiples of it that are none of them.

    Fewer where the multiples coincide.
    """
    inner = (times[:-1, None] + np.diff(times)[:, None] * random.random((len(times) - 1, BETWEEN))).ravel()
    if step is None:
        return inner
    return step * np.setdiff1d(np.rint(inner / step), np.rint(times / step))
