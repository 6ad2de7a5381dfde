"""The two crash occupants from the front and from the rear, run once for a full report."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from mbs_ref import scenes
from mbs_ref.crash.results import CrashResults, crash_results
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.studies.androids.measure import IMPACTS, NAMES


@dataclass(frozen=True)
class Crash:
    """One android in one impact, with the forces and measures of the paper."""

    scene: Scene
    path: Trajectory
    results: CrashResults

    @property
    def label(self) -> str:
        return f"{self.scene.name}, {self.scene.parameters['impact']}"


def crashes() -> tuple[Crash, ...]:
    """Return both androids in both impacts."""
    return tuple(_run(name, impact) for impact, name in product(IMPACTS, NAMES))


def _run(name: str, impact: str) -> Crash:
    scene = scenes.make(name, impact=impact)
    path = simulate(scene, Settings(rtol=1e-8, samples=401))
    return Crash(scene, path, crash_results(scene, path))
