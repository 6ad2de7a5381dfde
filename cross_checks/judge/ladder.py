"""The ladder of settings of a method: steps or tolerances from coarse to fine."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.engine import Method
from mbs_ref.scene import Scene
from mbs_ref.scene.units import free_fall_time, tolerance_unit
from mbs_ref.self_checks.stiffness import may_be_stiff, stiffness_at_start
from mbs_ref.settings import Settings

SAMPLES = 41  # output times of a judged run
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)  # s, where a method names none
FINER, SHARE = 3, 0.7  # steps added below what a stiff motion bears, the first at this share of it
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def grid(scene: Scene) -> np.ndarray:
    """Return the output times of a judged run (SAMPLES,), s."""
    return np.linspace(0.0, scene.duration, SAMPLES)


def rungs(method: Method, scene: Scene) -> list[Settings]:
    """Return the settings to try, coarse to fine; steps are shortened to divide the output interval.

    Those too coarse are kept, and not run a second time: truths judge them. Where a stiff motion bears none of an
    explicit method's steps, finer ones follow.
    Steps and absolute tolerances are in seconds and metres in the laboratory; among attracting bodies they
    count in the shortest free-fall time at the start, and in the distance or speed that goes with it.
    """
    if method.kind == "adaptive":
        unit = tolerance_unit(scene)
        tolerances = method.ladder or TOLERANCES
        return [Settings(method=method.name, rtol=r, atol=r * unit, estimate="off") for r in tolerances]
    interval = scene.duration / (SAMPLES - 1)
    unit = free_fall_time(scene)
    asked = (*(step * unit for step in method.ladder or STEPS), *_bearable(method, scene))
    steps = dict.fromkeys(fitted(step, interval) for step in asked)
    return [Settings(method=method.name, step=step, estimate="off") for step in steps]


def _bearable(method: Method, scene: Scene) -> tuple[float, ...]:
    """Return steps (s) that the linearised motion bears, where the method's own ladder ends before."""
    if not method.stability or not may_be_stiff(scene):
        return ()
    limit = stiffness_at_start(scene).step_limit(method.stability)
    if limit >= min(method.ladder or STEPS):
        return ()
    return tuple(SHARE * limit / 2.0**k for k in range(FINER))


def fitted(step: float, interval: float) -> float:
    """Return the largest step up to `step` that divides the interval (s)."""
    return interval / math.ceil(interval / step * (1.0 - 1e-9))


def label(settings: Settings) -> str:
    """Return the setting as a reader would type it."""
    return f"step={settings.step:.6g}" if settings.step is not None else f"rtol={settings.rtol:.1g}"
