"""A tiny engine that swings the simple pendulum, or fails as it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cross_checks import engines as registry
from cross_checks.engine import Engine, Method, output_times
from cross_checks.truths import truth_for
from mbs_ref.trajectory import Timing, Trajectory

BIAS = 0.25  # m, what the biased method is off at every step


class Swing(Engine):
    """The truth, shifted by an error that depends on the method."""

    name, package = "swing", "numpy"
    part_types = frozenset({"point_mass", "distance"})

    def __init__(self, trouble=None):
        self.trouble = trouble

    def methods(self):
        return (
            Method("second", "fixed", 2, "error h^2", (1e-1, 5e-2, 2.5e-2, 1e-2, 1e-3, 1e-4)),
            Method("biased", "fixed", 2, "error 0.25 + h^2", (1e-1, 5e-2, 2.5e-2, 1e-2)),
            Method("loops", "fixed", 2, "loops only", requires=frozenset({"closed-loop"})),
        )

    def version(self):
        return "1.0"

    def run(self, scene, settings, times=None):
        times = output_times(scene, settings, times)
        h = settings.step or 1e-3
        off = h**2 + (BIAS if settings.method == "biased" else 0.0)
        truth = truth_for(scene, times)
        place, timing = truth.position + np.array([off, 0.0]), Timing(loop_s=h)
        path = Trajectory(
            times, place, truth.orientation, truth.velocity, truth.angular_velocity, timing=timing,
            steps=round(times[-1] / h),
        )  # fmt: skip
        return self.trouble(path) if self.trouble else path


def register(current: Engine, patch: pytest.MonkeyPatch) -> None:
    """Let the engine, and one that is absent, be the only ones."""

    def get(name):
        if name == "swing":
            return current
        if name == "absent":
            raise registry.EngineMissing("engine 'absent' needs the package 'absent'")
        raise ValueError(f"engine = {name!r} is unknown")

    patch.setattr(registry, "get", get)
    patch.setattr(registry, "names", lambda: ["swing", "absent"])


@pytest.fixture
def swing(monkeypatch):
    """Register the engine; the returned function gives it a trouble to have after each run."""
    current = Swing()
    register(current, monkeypatch)

    def trouble(what):
        current.trouble = what

    return trouble


def raising(error):
    """A trouble: the engine raises."""

    def fail(path):
        raise error

    return fail


def spoiled(sample):
    """A trouble: NaN from a sample on, and success reported."""

    def spoil(path):
        position = path.position.copy()
        position[sample:] = np.nan
        return replace(path, position=position)

    return spoil
