"""An engine in an environment of its own, called through a child process with that environment's Python."""

import math
import os
import time
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.engine import Engine, Method, Refusal, stopped
from cross_checks.isolation.environments import python_of, surroundings
from cross_checks.isolation.parent import Isolated, Lost
from mbs_ref import Scene, Settings, Status, Trajectory
from mbs_ref.kernels.jit import source_digest
from mbs_ref.scene.traits import python_parts

Get = Callable[[str], Engine]  # the registry's, which here and there finds the engine

STATED = ("package", "part_types", "as_shipped", "default_method", "checks_start")  # what an adapter declares of itself


class Elsewhere(Engine):
    """Answers as the engine does in its own environment. A Python function of the user's cannot travel there."""

    spent_s = 0.0  # of processor time, by the runs of all such engines

    def __init__(self, name: str, home: Path, get: Get) -> None:
        self.get = get
        self.name, self.home = name, home  # type: ignore[misc]
        self._call: Isolated | None = None
        self._process = 0
        stated, self._methods, self._version, self.made_of = self.ask(_about, name)
        vars(self).update(stated)

    def methods(self) -> tuple[Method, ...]:
        return self._methods

    def version(self) -> str:
        return self._version

    def refusals(self, scene: Scene) -> list[Refusal]:
        return _stay(self.name, scene) or self.ask(_answer, self.name, "refusals", scene)[0]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        return _stay(self.name, scene) or self.ask(_answer, self.name, "method_refusals", scene, method)[0]

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        if _stay(self.name, scene):
            return super().run(scene, settings, times)  # says why not
        try:
            path, cpu_s = self.ask(_answer, self.name, "run", scene, settings, times)
            Elsewhere.spent_s += cpu_s
            return path
        except Lost as lost:
            return stopped(scene, Status.ENGINE_ERROR, f"{self.name} did not come back: {lost}")

    def ask(self, function: Any, *arguments: Any) -> Any:
        """Return function(get, *arguments), called in the engine's environment.

        A copy of this process has a child of its own: a pipe has two ends.
        """
        if self._call is None or self._process != os.getpid():
            around = tuple(surroundings(self.name).items())
            self._call = Isolated(timeout=math.inf, python=str(python_of(self.home)), variables=around)
            self._process = os.getpid()
            weakref.finalize(self, self._call.close)
        return self._call(function, self.get, *arguments)


def processor_time() -> float:
    """Return the processor time (s) of this process and of its runs in other environments."""
    return time.process_time() + Elsewhere.spent_s


def _stay(name: str, scene: Scene) -> list[Refusal]:
    parts = python_parts(scene)
    why = f"holds a Python function, and {name} lives in an environment of its own"
    return [Refusal(f"{place} {part!r} {why}", permanent=True) for place, part in parts]


def _about(get: Get, name: str) -> tuple[dict[str, Any], tuple[Method, ...], str, str]:
    engine = get(name)
    stated = {attribute: getattr(engine, attribute) for attribute in STATED}
    return stated, engine.methods(), engine.version(), source_digest(type(engine).__module__)


def _answer(get: Get, name: str, method: str, *arguments: Any) -> tuple[Any, float]:
    began = time.process_time()
    return getattr(get(name), method)(*arguments), time.process_time() - began
