"""An engine that lives in an environment of its own, asked through a child process with that environment's Python."""

import math
import os
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.engine.outcome import stopped
from cross_checks.isolation.environments import python_of, surroundings
from cross_checks.isolation.parent import Isolated, Lost
from mbs_ref.kernels.jit import source_digest
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import python_parts
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Trajectory

Get = Callable[[str], Engine]  # the registry's, which here and there finds the engine


@dataclass(frozen=True)
class Facts:
    """What the adapter says of itself over there."""

    package: str
    part_types: frozenset[str]
    methods: tuple[Method, ...]
    version: str
    as_shipped: Settings | None
    unasked: str | None
    checks_start: bool
    made_of: str


class Elsewhere(Engine):
    """Answers as the engine does in its own environment. A Python function of the user's cannot travel there."""

    def __init__(self, name: str, home: Path, get: Get) -> None:
        self.get = get
        self.name, self.home = name, home  # type: ignore[misc]
        self._call: Isolated | None = None
        self._process = 0
        facts: Facts = self._ask(_facts, name)
        self._methods, self._version, self.made_of = facts.methods, facts.version, facts.made_of
        self.package, self.part_types = facts.package, facts.part_types  # type: ignore[misc]
        self.as_shipped, self.unasked = facts.as_shipped, facts.unasked  # type: ignore[misc]
        self.checks_start = facts.checks_start  # type: ignore[misc]

    def methods(self) -> tuple[Method, ...]:
        return self._methods

    def version(self) -> str:
        return self._version

    def refusals(self, scene: Scene) -> list[Refusal]:
        return _stay(self.name, scene) or self._ask(_refusals, self.name, scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        return _stay(self.name, scene) or self._ask(_method_refusals, self.name, scene, method)

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        if _stay(self.name, scene):
            return super().run(scene, settings, times)  # says why not
        try:
            return self._ask(_run, self.name, scene, settings, times)
        except Lost as lost:
            return stopped(scene, Status.ENGINE_ERROR, f"{self.name} did not come back: {lost}")

    def _ask(self, function: Any, *arguments: Any) -> Any:
        """Call in the engine's environment. A copy of this process has a child of its own: a pipe has two ends."""
        if self._call is None or self._process != os.getpid():
            around = tuple(surroundings(self.name).items())
            self._call = Isolated(timeout=math.inf, python=str(python_of(self.home)), variables=around)
            self._process = os.getpid()
            weakref.finalize(self, self._call.close)
        return self._call(function, self.get, *arguments)


def _stay(name: str, scene: Scene) -> list[Refusal]:
    parts = python_parts(scene)
    why = f"holds a Python function, and {name} lives in an environment of its own"
    return [Refusal(f"{place} {part!r} {why}", permanent=True) for place, part in parts]


def _facts(get: Get, name: str) -> Facts:
    engine = get(name)
    return Facts(
        engine.package, engine.part_types, engine.methods(), engine.version(), engine.as_shipped, engine.unasked,
        engine.checks_start, source_digest(type(engine).__module__),
    )  # fmt: skip


def _refusals(get: Get, name: str, scene: Scene) -> list[Refusal]:
    return get(name).refusals(scene)


def _method_refusals(get: Get, name: str, scene: Scene, method: Method) -> list[Refusal]:
    return get(name).method_refusals(scene, method)


def _run(get: Get, name: str, scene: Scene, settings: Settings, times: np.ndarray | None) -> Trajectory:
    return get(name).run(scene, settings, times)
