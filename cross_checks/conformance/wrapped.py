"""An engine around another: what is not overridden is asked of the inner one."""

from __future__ import annotations

import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory


class Wrapped(Engine):
    """Another engine under its own name."""

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
