"""An engine run in a process of its own: a run that hangs or dies is lost and named, and the others still answer."""

from dataclasses import dataclass, replace
from time import perf_counter, process_time

import numpy as np

from cross_checks import engines
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
