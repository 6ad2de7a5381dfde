"""Starts that break their own joints: a wrong place, a wrong speed, Euler parameters that are no rotation."""

from __future__ import annotations

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import rod_chain
from cross_checks.truths import torque_free_top
from mbs_ref import scenes
from mbs_ref.scene import Scene

FAMILY = "inconsistent starts"
STEP, RTOL = 1e-3, 1e-8
TOLERABLE = 1e-8  # m, m/s: a smaller gap changes nothing that anybody could measure here
GAPS = Axis("gap", "m", decades(1e-14, 1.0, 2.0))
SPEEDS = Axis("gap", "m/s", decades(1e-14, 1.0, 2.0))


def _broken(gap: float, **change) -> Case:
    sound = rod_chain("broken_chain", (0.0, 0.5), (1.0, 1.0))
    first, second = sound.bodies
    moved = {name: tuple(np.add(getattr(second, name), shift).tolist()) for name, shift in change.items()}
    scene = sound.model_copy(update={"bodies": (first, second.model_copy(update=moved))})
    return Case(
        scene, grid(0.5, STEP, 11), measures.invariants(), step=STEP, rtol=RTOL, must_stop=gap > TOLERABLE,
        unchecked=True,
    )  # fmt: skip


def _place(gap: float) -> Case:
    return _broken(gap, position=(0.6 * gap, 0.8 * gap))


def _speed(gap: float) -> Case:
    return _broken(gap, velocity=(0.6 * gap, 0.8 * gap))


def _norm(gap: float) -> Case:
    sound = scenes.make("torque_free_top", turns=1.0, axis=3)
    top = sound.bodies[0]
    stretched = tuple((np.array(top.orientation) * (1.0 + gap)).tolist())
    scene: Scene = sound.model_copy(update={"bodies": (top.model_copy(update={"orientation": stretched}),)})
    solve = torque_free_top.solve
    exact = measures.truth(lambda _, times: solve(sound, times))
    return Case(scene, grid(0.6, STEP, 11), exact, step=STEP, rtol=RTOL, must_stop=gap > TOLERABLE)


EXTREMES = (
    Extreme("wrong-place", FAMILY, "The second rod of a chain starts apart from its hinge.", GAPS, _place),
    Extreme("wrong-speed", FAMILY, "The second rod of a chain starts with a speed its hinge forbids.", SPEEDS, _speed),
    Extreme("wrong-norm", FAMILY, "Euler parameters whose norm is not 1, past the checks of scenes.",
            Axis("norm - 1", "", decades(1e-14, 1.0, 2.0)), _norm),
)  # fmt: skip
