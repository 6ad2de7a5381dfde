"""The two crash occupants, run once for a full report."""

from __future__ import annotations

from mbs_ref import scenes
from mbs_ref.crash_results import CrashResults, crash_results
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

NAMES = ("android_simplified", "android_vertebral")
Crash = tuple[Scene, Trajectory, CrashResults]


def crashes() -> tuple[Crash, ...]:
    """Return both androids in the default impact, with the forces and measures of the paper."""
    return tuple(_run(name) for name in NAMES)


def _run(name: str) -> Crash:
    scene = scenes.make(name)
    path = simulate(scene, Settings(rtol=1e-8, samples=401))
    return scene, path, crash_results(scene, path)
