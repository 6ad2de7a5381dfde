"""Steps from below roundoff to seconds, more of them than anybody can wait for, and clocks that stand still."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import half_sine_push
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.truths.of import pendulums
from mbs_ref import scenes
from mbs_ref.scene import Force, PlanarBody, Scene
from mbs_ref.scene.signals import HalfSine

FAMILY = "steps"
SWING_TIME = 2.0  # s
GRAVITY = 9.81  # m/s^2


def _large(step: float) -> Case:
    times = grid(max(SWING_TIME, 4.0 * step), step)
    return Case(scenes.make("pendulum"), times, measures.truth(pendulums.pendulum), step=step)


def _tiny(step: float) -> Case:
    def falling(times: np.ndarray) -> np.ndarray:
        return np.stack([np.zeros_like(times), -GRAVITY * times], axis=1)[:, None]

    times = grid(20.0 * step, step)
    return Case(scenes.make("pendulum"), times, measures.rates(falling, GRAVITY * float(times[-1])), step=step)


def _many(step: float) -> Case:
    return Case(scenes.make("pendulum"), grid(1.0, step, 3), measures.truth(pendulums.pendulum), step=step)


PULSE, PUSH = 1e-3, 1e3  # s, m/s^2


def _late(start: float) -> Case:
    scene = Scene(
        name="late_pulse",
        duration=start + 1.0,
        bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),),
        loads=(Force(name="push", body="sled", point=(0.0, 0.0), vector=(PUSH, 0.0),
                     factor=HalfSine(peak=1.0, duration=PULSE, start=start)),),
    )  # fmt: skip
    speed = 2.0 * PUSH * PULSE / math.pi

    def pushed(times: np.ndarray) -> np.ndarray:
        return np.stack([half_sine_push(times - start, PULSE, PUSH), 0.0 * times], axis=1)[:, None]

    times = np.array([0.0, 0.5 * start, start + 1.0])
    return Case(scene, times, measures.positions(pushed, speed), rtol=1e-8)


EXTREMES = (
    Extreme(
        "large-steps", FAMILY, "A pendulum swings 2 s in ever longer steps; its period is 2.4 s.",
        Axis("step", "s", (1e-3, 1e-2, 5e-2, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)), _large,
    ),
    Extreme(
        "tiny-steps", FAMILY, "Twenty steps of a pendulum let go, down to where h and h^2 underflow; v = -g t.",
        Axis("step", "s", (1e-4, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-30, 1e-100, 1e-300)), _tiny,
    ),
    Extreme(
        "countless-steps", FAMILY, "One second of a pendulum in more steps than can be waited for.",
        Axis("step", "s", (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15)), _many, good=1e-2,
    ),
    Extreme(
        "late-clock", FAMILY, "A 1 ms push after ever longer rest: at 1e13 s the clock ticks in 2 ms.",
        Axis("time of the push", "s", decades(1.0, 1e16, 2.0)), _late,
    ),
)  # fmt: skip
