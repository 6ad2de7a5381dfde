"""The one number that a method's accuracy depends on, its step or its tolerance, and the grid of a judged run."""

import math

import numpy as np

from cross_checks.engine import RTOLS, STEPS, Method
from mbs_ref import Scene, Settings
from mbs_ref.scene.scales import free_fall_time, scales_of

SAMPLES = 41  # output times of a judged run
TIGHTEST = 1e-14  # a relative tolerance below is roundoff
LOOSEST = 1e-2
DIGITS = 2  # of a tolerance, so that a reader can type it


def grid(scene: Scene) -> np.ndarray:
    """Return the output times of a judged run (SAMPLES,), s."""
    return np.linspace(0.0, scene.duration, SAMPLES)


def coarsest(method: Method, scene: Scene) -> float:
    """Return the coarsest setting that is tried: a step (s) of one output interval, or the loosest tolerance."""
    return LOOSEST if method.kind == "adaptive" else scene.duration / (SAMPLES - 1)


def settings_at(method: Method, scene: Scene, knob: float) -> Settings:
    """Return the settings of a step (s), shortened to divide the output interval, or of a relative tolerance.

    Absolute tolerances are in the scene's own length, or speed where that is less. Truths judge these runs, which
    therefore make no estimate of their own.
    """
    if method.kind == "adaptive":
        rtol = float(f"{max(TIGHTEST, knob):.{DIGITS - 1}e}")
        scales = scales_of(scene)
        return Settings(method=method.name, rtol=rtol, atol=rtol * min(scales.length, scales.speed), estimate="off")
    return Settings(method=method.name, step=fitted(knob, scene.duration / (SAMPLES - 1)), estimate="off")


def knob_of(settings: Settings) -> float:
    """Return the step (s) or the relative tolerance; NaN where neither is given."""
    return settings.step or settings.rtol or math.nan


def rungs(method: Method, scene: Scene) -> list[Settings]:
    """Return the method's whole ladder, coarse to fine, for sweeps."""
    if method.kind == "adaptive":
        return [settings_at(method, scene, rtol) for rtol in method.ladder or RTOLS]
    steps = (step * free_fall_time(scene) for step in method.ladder or STEPS)
    every = [settings_at(method, scene, step) for step in steps]
    return list({settings.step: settings for settings in every}.values())


def fitted(step: float, interval: float) -> float:
    """Return the largest step up to `step` that divides the interval (s)."""
    return interval / math.ceil(interval / step * (1.0 - 1e-9))


def label(settings: Settings) -> str:
    """Return the setting as a reader would type it."""
    return f"step={settings.step:.6g}" if settings.step is not None else f"rtol={settings.rtol:.{DIGITS}g}"
