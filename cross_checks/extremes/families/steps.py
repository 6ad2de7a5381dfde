"""Steps from below roundoff to seconds, clocks that stand still, short pulses, and tolerances nobody can meet;
springs from 1e2 to 1e14 N/m: quiet, where only stability is at stake, and ringing, where the motion is fast.
"""

import math

import numpy as np

from cross_checks.extremes import Case, Measure, by_positions, by_rates, by_truth, grid, in_plane
from cross_checks.extremes.parts import GRAVITY, half_sine_push, made, sled
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


SOFT = 2.0 * (2.0 * math.pi) ** 2  # N/m: two masses of 1 kg swing at 1 Hz
SHIFT = 0.1  # m


def _quiet(stiffness: float) -> Case:
    """Start in the slow mode alone: x = rest + shape cos(w t), w^2 the small root of the 2 x 2 problem."""
    large = 0.5 * (SOFT + 2.0 * stiffness + math.hypot(SOFT, 2.0 * stiffness))
    slow = SOFT * stiffness / large  # the product of the roots is known, their difference would cancel
    shape = SHIFT * np.array([1.0 - slow / stiffness, 1.0])
    rest = np.array([1.0, 2.0])
    x = rest + shape
    scene = made("stiff_coupling", stiffness=stiffness, a=float(x[0]), b=float(x[1]))

    def exact(times: np.ndarray) -> np.ndarray:
        places = rest + shape * np.cos(math.sqrt(slow) * times)[:, None]
        return np.stack([places, np.zeros_like(places)], axis=2)

    return Case(scene, grid(2.0), by_positions(exact, SHIFT), max_steps=200_000)


def _ringing(stiffness: float) -> Case:
    scene = made("stiff_oscillator", stiffness=stiffness, x=1.0 + SHIFT)
    exact = by_positions(lambda times: in_plane(1.0 + SHIFT * np.cos(math.sqrt(stiffness) * times), 0.0), SHIFT)
    return Case(scene, grid(1.0), exact, max_steps=200_000)


CASES = {
    "crash-pulse": _crash,
    "large-steps": lambda step: _fixed(step, max(SWING_TIME, 4.0 * step), by_truth(pendulums.pendulum)),
    "tiny-steps": _tiny,
    "late-clock": _late,
    "stiff-spring-quiet": _quiet,
    "stiff-spring-ringing": _ringing,
}
