"""An engine run in a process of its own, and whether its clock reports the work of its loop.

A run that hangs or dies is lost and named, and the others still answer.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from time import perf_counter, process_time

import numpy as np

from cross_checks import engines
from cross_checks.conformance.questions import Question
from cross_checks.engine import Engine, Method, Refusal
from cross_checks.engine.plan import stopped
from cross_checks.isolation.parent import Caller, Lost
from cross_checks.judge.ladder import label
from cross_checks.judge.one_run import ENGINE_FAILURES
from mbs_ref import Settings, Status, Trajectory
from mbs_ref.scene import Scene, UserForce

TIMEOUT = 60.0  # s that one run may compute or sleep


@dataclass(frozen=True)
class Called:
    """One run and the clocks of the call."""

    settings: Settings
    path: Trajectory
    wall_s: float = 0.0
    cpu_s: float = 0.0  # of all threads

    @property
    def setting(self) -> str:
        return label(self.settings)


class Wrapped(Engine):
    """Another engine under its own name; what is not overridden is the inner one's."""

    def __init__(self, inner: Engine) -> None:
        self.inner = inner
        self.name, self.package, self.part_types = inner.name, inner.package, inner.part_types  # type: ignore[misc]

    def methods(self) -> tuple[Method, ...]:
        return self.inner.methods()

    def version(self) -> str:
        return self.inner.version()

    def refusals(self, scene: Scene) -> list[Refusal]:
        return self.inner.refusals(scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        return self.inner.method_refusals(scene, method)

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        return self.inner.run(scene, settings, times)


class Apart(Wrapped):
    """An engine that is known by name, run through `ask`; after a loss its method is not tried on that scene again."""

    def __init__(self, engine: Engine, ask: Caller) -> None:
        super().__init__(engine)
        self.ask = ask
        self.lost: dict[tuple[str, str], str] = {}  # (method, scene) -> what became of the first run that was lost

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        return self.call(scene, settings, times).path

    def call(self, scene: Scene, settings: Settings, times: np.ndarray | None) -> Called:
        """Run in the other process; a scene with a Python force cannot travel there and runs in this one."""
        if any(isinstance(load, UserForce) for load in scene.loads):
            return _call(self.inner, scene, settings, times)
        place = (settings.method or "", scene.name)
        if place in self.lost:
            return _lost(scene, settings, f"not tried: before, {self.lost[place]}")
        try:
            return self.ask(_call_by_name, self.name, scene, settings, times)
        except Lost as loss:
            self.lost[place] = f"{label(settings)}: {loss}"
            return _lost(scene, settings, str(loss))


def called(engine: Engine, scene: Scene, settings: Settings, times: np.ndarray | None) -> Called:
    """Run once, where the engine is run, with the clocks of the call. An engine's exception is a run that failed."""
    return engine.call(scene, settings, times) if isinstance(engine, Apart) else _call(engine, scene, settings, times)


def _call_by_name(name: str, scene: Scene, settings: Settings, times: np.ndarray | None) -> Called:
    return _call(engines.get(name), scene, settings, times)


def _call(engine: Engine, scene: Scene, settings: Settings, times: np.ndarray | None) -> Called:
    wall, cpu = perf_counter(), process_time()
    try:
        path = engine.run(scene, settings, times)
    except ENGINE_FAILURES as error:
        path = stopped(scene, Status.ENGINE_ERROR, f"{type(error).__name__}: {error}")
    return Called(settings, path, perf_counter() - wall, process_time() - cpu)


def _lost(scene: Scene, settings: Settings, why: str) -> Called:
    return Called(settings, replace(stopped(scene, Status.ENGINE_ERROR, why), unreported=True))


FASTEST = 5e-9  # s: no processor evaluates a right-hand side, or takes a step, in less
WORK = 0.1  # s of processor time, by which a longer run must exceed a shorter one to be compared
LONGEST = 4.0**8  # times the span: a run that is quicker still is not compared
COUNTED = 0.6  # of the additional processor time, which a clock must report: scheduling disturbs by less


def impossible_time(runs: Iterable[Called]) -> str:
    """Return a sentence where a loop's time does not fit into its call, or is shorter than any processor takes."""
    for run in runs:
        clock, counted = run.path.timing, max(run.path.steps, run.path.rhs_calls)
        total = clock.build_s + clock.first_call_s + clock.loop_s
        if not clock.loop_s > 0.0:
            return f"{run.setting}: the loop is not timed"
        # the two clocks are read apart: a tenth of a millisecond may pass between
        if total > 1.01 * run.wall_s + 1e-4:
            return f"{run.setting}: {total:.2e} s are reported of a call of {run.wall_s:.2e} s"
        if clock.loop_s < counted * FASTEST:
            work = f"{counted} steps or right-hand sides in {clock.loop_s:.2e} s"
            return f"{run.setting}: {work} are beyond any processor"
    return ""


def uncounted_work(engine: Engine, question: Question, settings: Settings) -> str:
    """Return a sentence where longer runs cost more processor time than the loop's clock reports.

    What a call costs besides its loop does not grow with the span. A collector at work may cost as much, once: the
    failure must come again. Several threads use more processor time than passes: the shorter of both is compared.
    """

    def run(factor: float) -> Called:
        return called(engine, question.scene, settings, factor * question.times)

    short, factor = run(1.0), 4.0
    long = run(factor)
    while long.path.ok and _cost(short, long) < WORK and factor < LONGEST:
        factor *= 4.0
        long = run(factor)
    return uncounted(lambda: (run(1.0), run(factor)), short, long)


def uncounted(again: Callable[[], tuple[Called, Called]], short: Called, long: Called) -> str:
    """Return a sentence where the clocks of two runs, and of the same two again, leave out work."""
    if not _leaves_out(short, long):
        return ""
    short, long = again()
    if not _leaves_out(short, long):
        return ""
    reported = long.path.timing.loop_s - short.path.timing.loop_s
    return f"a longer run costs {_cost(short, long):.2e} s more, of which the loop's clock reports {reported:.2e} s"


def _leaves_out(short: Called, long: Called) -> bool:
    reported, cost = long.path.timing.loop_s - short.path.timing.loop_s, _cost(short, long)
    return long.path.ok and cost > WORK and reported < COUNTED * cost


def _cost(short: Called, long: Called) -> float:
    return min(long.cpu_s - short.cpu_s, long.wall_s - short.wall_s)
