"""Steps from below roundoff to seconds, clocks that stand still, short pulses, and tolerances nobody can meet."""

import math

import numpy as np

from cross_checks.extremes import Case, Measure, by_positions, by_rates, by_truth, grid, in_plane
from cross_checks.extremes.parts import GRAVITY, half_sine_push, sled
from cross_checks.truths.of import pendulums
from mbs_ref import scenes
from mbs_ref.scene.signals import HalfSine

SWING_TIME = 2.0  # s


def _fixed(step: float, t_end: float, measure: Measure) -> Case:
    return Case(scenes.make("pendulum"), grid(t_end, step), measure, step, None)


def _tiny(step: float) -> Case:
    falling = by_rates(lambda times: in_plane(0.0, -GRAVITY * times), GRAVITY * 20.0 * step)
    return _fixed(step, 20.0 * step, falling)


def _pulse(name: str, acceleration: float, duration: float, at: float, after: float) -> tuple:
    """Return a sled of 75 kg under a half-sine from `at` (s) on and `after` (s) it, and the measure of its place."""
    scene = sled(name, 75.0 * acceleration, 75.0, HalfSine(peak=1.0, duration=duration, start=at), at + after)
    size = 2.0 * acceleration * duration / math.pi * after  # m
    pushed = by_positions(lambda times: in_plane(half_sine_push(times - at, duration, acceleration), 0.0), size)
    return scene, pushed


def _crash(duration: float) -> Case:
    scene, pushed = _pulse("crash_pulse", 200.0, duration, 5.00031, 4.99969)  # s; at no round time
    return Case(scene, grid(10.0), pushed)


def _late(start: float) -> Case:
    scene, pushed = _pulse("late_pulse", 1e3, 1e-3, start, 1.0)
    return Case(scene, np.array([0.0, 0.5 * start, start + 1.0]), pushed, step=None)


CASES = {
    "crash-pulse": _crash,
    "large-steps": lambda step: _fixed(step, max(SWING_TIME, 4.0 * step), by_truth(pendulums.pendulum)),
    "tiny-steps": _tiny,
    "late-clock": _late,
}
