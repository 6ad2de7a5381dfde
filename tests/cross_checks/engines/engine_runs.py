"""Every engine and method, and what the tests of all adapters share."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Engine
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory


def engine(name: str) -> Engine:
    """Return the engine, or skip where its package is not installed."""
    try:
        return engines.get(name)
    except engines.EngineMissing as missing:
        pytest.skip(str(missing))


def settings_of(name: str, method: str, step: float = 1e-3, rtol: float = 1e-10, **more) -> Settings:
    """Return settings in the terms the method takes."""
    chosen = engine(name).method(method)
    accuracy = {"step": step} if chosen.kind == "fixed" else {"rtol": rtol}
    return Settings.model_validate({"method": method, **accuracy, **more})


def run(name: str, method: str, scene: Scene, step: float = 1e-3, rtol: float = 1e-10, **more) -> Trajectory:
    """Run one engine's method on a scene."""
    return engine(name).run(scene, settings_of(name, method, step, rtol, **more))


def distance(a: Trajectory, b: Trajectory) -> float:
    """Return the largest distance (m) between two trajectories' body positions."""
    assert a.position.shape == b.position.shape
    return float(np.linalg.norm(a.position - b.position, axis=-1).max())


def observed_order(errors: list[float], ratio: float = 2.0) -> float:
    """Return the order that the last two errors show when the step shrinks by the ratio."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(ratio))
