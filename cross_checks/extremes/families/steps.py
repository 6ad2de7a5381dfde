"""Steps from below roundoff to seconds, clocks that stand still, short pulses, and tolerances nobody can meet."""

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import STEP, Axis, Case, Extreme, Measure, decades, grid
from cross_checks.extremes.parts import GRAVITY, half_sine_push, sled
from cross_checks.truths.of import linkages, pendulums, sky
from mbs_ref import scenes
from mbs_ref.scene.signals import HalfSine

SWING_TIME = 2.0  # s
PENDULUM = measures.truth(pendulums.pendulum)
TIGHT, LOOSE = Axis("rtol", "", decades(1e-6, 1e-20, 2.0)), Axis("rtol", "", decades(1e-6, 1e-2))
TOLERANCES = {  # what runs at a tolerance alone: a scene with its parameters, its end (s) and its truth
    "pendulum": ({}, 5.0, PENDULUM),
    "kepler": ({"orbits": 3.0}, 6.0 * math.pi, measures.truth(sky.kepler)),
    "n_four_bar": ({"loops": 1}, 3.0, measures.truth(linkages.n_four_bar)),
}


def _fixed(step: float, t_end: float, samples: int = 21, measure: Measure = PENDULUM) -> Case:
    return Case(scenes.make("pendulum"), grid(t_end, step, samples), measure, step, None)


def _tiny(step: float) -> Case:
    falling = measures.rates(lambda times: measures.in_plane(0.0, -GRAVITY * times), GRAVITY * 20.0 * step)
    return _fixed(step, 20.0 * step, measure=falling)


def _pulse(name: str, acceleration: float, duration: float, at: float, after: float) -> tuple:
    """Return a sled of 75 kg under a half-sine from `at` (s) on and `after` (s) it, and the measure of its place."""
    scene = sled(name, 75.0 * acceleration, 75.0, HalfSine(peak=1.0, duration=duration, start=at), at + after)
    size = 2.0 * acceleration * duration / math.pi * after  # m
    pushed = measures.positions(
        lambda times: measures.in_plane(half_sine_push(times - at, duration, acceleration), 0.0), size
    )
    return scene, pushed


def _crash(duration: float) -> Case:
    scene, pushed = _pulse("crash_pulse", 200.0, duration, 5.00031, 4.99969)  # s; at no round time
    return Case(scene, grid(10.0), pushed)


def _late(start: float) -> Case:
    scene, pushed = _pulse("late_pulse", 1e3, 1e-3, start, 1.0)
    return Case(scene, np.array([0.0, 0.5 * start, start + 1.0]), pushed, step=None)


def _tolerance(name: str, scene: str, title: str, axis: Axis) -> Extreme:
    parameters, t_end, truth = TOLERANCES[scene]

    def case(rtol: float) -> Case:
        return Case(scenes.make(scene, **parameters), grid(t_end, STEP), truth, None, rtol)

    return Extreme(name, "tolerances", title, axis, case)


EXTREMES = (
    Extreme("crash-pulse", "pulses", "A 15 kN half-sine hits a free sled of 75 kg in the middle of 10 quiet seconds.",
            Axis("duration of the pulse", "s", (1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)), _crash),
    Extreme("large-steps", "steps", "A pendulum swings 2 s in ever longer steps; its period is 2.4 s.",
            Axis("step", "s", (1e-3, 1e-2, 5e-2, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)),
            lambda step: _fixed(step, max(SWING_TIME, 4.0 * step))),
    Extreme("tiny-steps", "steps", "Twenty steps of a released pendulum, down to where h and h^2 underflow; v = -g t.",
            Axis("step", "s", (1e-4, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-30, 1e-100, 1e-300)), _tiny),
    Extreme("countless-steps", "steps", "One second of a pendulum in more steps than can be waited for.",
            Axis("step", "s", (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15)),
            lambda step: _fixed(step, 1.0, 3)),
    Extreme("late-clock", "steps", "A 1 ms push after ever longer rest: at 1e13 s the clock ticks in 2 ms.",
            Axis("time of the push", "s", decades(1.0, 1e16, 2.0)), _late),
    _tolerance("tolerance-pendulum", "pendulum", "Five seconds of a pendulum at tolerances nobody can meet.", TIGHT),
    _tolerance("tolerance-orbit", "kepler", "Three orbits of eccentricity 0.6.", TIGHT),
    _tolerance("tolerance-singular", "n_four_bar",
               "A four-bar through its flat pose, near which roundoff grows: a tight tolerance cannot be met.", TIGHT),
    _tolerance("loose-pendulum", "pendulum", "Five seconds of a pendulum at ever looser tolerances.", LOOSE),
    _tolerance("loose-orbit", "kepler", "Three orbits whose close passes a loose tolerance may step over.", LOOSE),
    _tolerance("loose-singular", "n_four_bar",
               "A four-bar through its flat pose, where a loose step may change the branch.", LOOSE),
)  # fmt: skip
