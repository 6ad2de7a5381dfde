"""Fast spin to 1e5 rad/s, and how Euler parameters drift over a million steps."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import LENGTH, rod
from cross_checks.truths.of import tops
from mbs_ref import scenes
from mbs_ref.scene import GROUND, Revolute, Scene

FAMILY = "spin"
STEP, RTOL = 1e-3, 1e-8
TIME = 0.1  # s


def _free(spin: float) -> Case:
    scene = scenes.make("torque_free_top", spin=spin, axis=3, tilt=0.1, turns=TIME * spin / (2.0 * math.pi))
    return Case(scene, grid(TIME, STEP), measures.truth(tops.torque_free_top), step=STEP, rtol=RTOL)


def _top(spin: float) -> Case:
    scene = scenes.make("heavy_top", motion="steady", spin=spin)
    return Case(scene, grid(TIME, STEP), measures.truth(tops.heavy_top, 0.3), step=STEP, rtol=RTOL)


def _rotor(spin: float) -> Case:
    """Without gravity a hinged rod turns evenly."""
    body = rod("rod", (0.0, 0.0), 0.0, velocity=(0.0, 0.5 * LENGTH * spin), angular_velocity=spin)
    hinge = Revolute(name="hinge", body_a=GROUND, body_b="rod", point=(0.0, 0.0))
    scene = Scene(name="rotor", bodies=(body,), joints=(hinge,))

    def exact(times: np.ndarray) -> np.ndarray:
        return 0.5 * LENGTH * np.stack([np.cos(spin * times), np.sin(spin * times)], axis=1)[:, None]

    # initial velocities are rounded: at 1e5 rad/s a joint's velocity is exact to 1e-11 m/s only
    return Case(scene, grid(TIME, STEP), measures.positions(exact), step=STEP, rtol=RTOL)


def _drift(turns: float) -> Case:
    spin = 10.0  # rad/s
    scene = scenes.make("torque_free_top", spin=spin, axis=3, tilt=0.1, turns=turns)
    step = 2.0 * math.pi / (100.0 * spin)
    return Case(
        scene, grid(100.0 * turns * step, step, 11), measures.truth(tops.torque_free_top), step=step, rtol=1e-10,
        max_steps=2_000_000,
    )  # fmt: skip


EXTREMES = (
    Extreme("free-spin", FAMILY, "A free body, ever faster about its third axis, for 0.1 s in steps of 1 ms.",
            Axis("spin", "rad/s", decades(1.0, 1e5)), _free),
    Extreme("heavy-top-spin", FAMILY, "A top in steady precession, ever faster.",
            Axis("spin", "rad/s", (60.0, 200.0, 1e3, 1e4, 1e5)), _top),
    Extreme("rotor-spin", FAMILY, "A hinged rod turns evenly: a straight line in the joint angle, a circle in x and y.",
            Axis("spin", "rad/s", decades(1.0, 1e5)), _rotor),
    Extreme("euler-parameter-drift", FAMILY, "A free top in 100 steps a turn, for up to a million steps.",
            Axis("turns", "", (10.0, 100.0, 1000.0), full=(10_000.0,)), _drift),
)  # fmt: skip
