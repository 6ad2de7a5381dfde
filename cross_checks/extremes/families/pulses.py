"""A short, strong pulse in a long quiet run: adaptive codes step over what nobody declares."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.exact import half_sine_push
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from mbs_ref.scene import Force, PlanarBody, Scene
from mbs_ref.scene.signals import HalfSine

PEAK, MASS = 15e3, 75.0  # N, kg
AT, TIME = 5.00031, 10.0  # s; at no round time


def _pulse(duration: float) -> Case:
    scene = Scene(
        name="crash_pulse",
        duration=TIME,
        bodies=(PlanarBody(name="sled", mass=MASS, inertia=1.0),),
        loads=(Force(name="pulse", body="sled", point=(0.0, 0.0), vector=(PEAK, 0.0),
                     factor=HalfSine(peak=1.0, duration=duration, start=AT)),),
    )  # fmt: skip

    def exact(times: np.ndarray) -> np.ndarray:
        x = half_sine_push(times - AT, duration, PEAK / MASS)
        return np.stack([x, 0.0 * x], axis=1)[:, None]

    size = 2.0 * PEAK / MASS * duration / math.pi * (TIME - AT)
    return Case(scene, grid(TIME, 1e-3), measures.positions(exact, size), step=1e-3, rtol=1e-8)


EXTREMES = (
    Extreme("crash-pulse", "pulses", "A 15 kN half-sine hits a free sled of 75 kg in the middle of 10 quiet seconds.",
            Axis("duration of the pulse", "s", (1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)), _pulse, good=1e-2),
)  # fmt: skip
