"""Starts that break their own joints: a wrong place, a wrong speed, Euler parameters that are no rotation."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import rod_chain
from cross_checks.truths import torque_free_top
from mbs_ref import scenes
from mbs_ref.scene import GROUND, Distance, PointMass, Scene

FAMILY = "inconsistent starts"
TINY = 1e-11  # m, m/s: a smaller gap is roundoff, and nobody should stop
TOLERABLE = 1e-8  # m, m/s: a smaller gap changes nothing that anybody could measure here
GAPS = Axis("gap", "m", decades(1e-14, 1.0, 2.0))
SPEEDS = Axis("gap", "m/s", decades(1e-14, 1.0, 2.0))


def _place(gap: float) -> Case:
    """A bob that hangs `gap` beyond the end of its rod."""
    start = (-1.0 - gap, 0.0)
    bob = PointMass(name="bob", mass=1.0, position=start, velocity=(0.0, 0.0))
    rod = Distance(name="rod", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=start, length=1.0)
    return _case(Scene(name="broken_pendulum", gravity=(0.0, -9.81), bodies=(bob,), joints=(rod,)), gap)


def _speed(gap: float) -> Case:
    """A second rod that moves away from its hinge."""
    sound = rod_chain("broken_chain", (0.0, 0.5), (1.0, 1.0))
    first, second = sound.bodies
    moved = second.model_copy(update={"velocity": (0.6 * gap, 0.8 * gap)})
    return _case(sound.model_copy(update={"bodies": (first, moved)}), gap)


def _case(scene: Scene, gap: float) -> Case:
    stops = {"must_stop": gap > TOLERABLE, "may_stop": gap > TINY}
    return Case(scene, grid(0.5, samples=11), measures.invariants, unchecked=True, **stops)


def _norm(gap: float) -> Case:
    """Refusing is right, and so is the motion of the rotation that normalising leaves."""
    sound = scenes.make("torque_free_top", turns=1.0, axis=3)
    top: Any = sound.bodies[0]
    stretched = tuple((np.array(top.orientation) * (1.0 + gap)).tolist())
    scene: Scene = sound.model_copy(update={"bodies": (top.model_copy(update={"orientation": stretched}),)})
    solve = torque_free_top.solve
    exact = measures.truth(lambda _, times: solve(sound, times))
    return Case(scene, grid(0.6, samples=11), exact, may_stop=gap > TINY)


EXTREMES = (
    Extreme("wrong-place", FAMILY, "A pendulum bob starts away from the end of its rod.", GAPS, _place),
    Extreme("wrong-speed", FAMILY, "The second rod of a chain starts with a speed its hinge forbids.", SPEEDS, _speed),
    Extreme("wrong-norm", FAMILY, "Euler parameters whose norm is not 1, past the checks of scenes.",
            Axis("norm - 1", "", decades(1e-14, 1.0, 2.0)), _norm),
)  # fmt: skip
