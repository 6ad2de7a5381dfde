"""A chaotic chain for long: the truth within its horizon, the invariants beyond."""

from __future__ import annotations

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from cross_checks.extremes.parts import rod_chain
from cross_checks.truths.made_by.mechanisms.rod_chain import Rods, lagrange
from cross_checks.truths.made_by.numerics.scipy_solvers import runge_kutta
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

ANGLES = (0.9, 0.4, 0.0)  # rad, from the x axis: energy enough to turn over
HORIZON = 3.0  # s: beyond, an error of 1e-10 m grows past what a run of 1e-8 can be held to
STEP, RTOL = 5e-4, 1e-10


def _within_horizon(scene: Scene, path: Trajectory) -> float:
    near = path.times <= HORIZON
    rods = Rods(np.ones(3), np.ones(3), np.ones(3) / 12.0, 9.81, np.array(ANGLES))
    formulation = lagrange(rods)
    states = runge_kutta(formulation.derivative, formulation.start, path.times[near], 1e-13)
    exact = np.array([formulation.poses(t, y)[0] for t, y in zip(path.times[near], states, strict=True)])
    return farthest(scene, path, Partial(exact))[0]


def _chain(duration: float) -> Case:
    scene = rod_chain("chaotic_chain", ANGLES, (1.0, 1.0, 1.0))
    measure = measures.worst(_within_horizon, measures.invariants())
    return Case(scene, grid(duration, STEP), measure, step=STEP, rtol=RTOL)


EXTREMES = (
    Extreme(
        "chaotic-chain", "chaos",
        "Three rods tumble for long. Places are judged up to 3 s, where the motion is still predictable; beyond that "
        "no code can know them, and energy and joints are judged.",
        Axis("duration", "s", (1.0, 3.0), full=(10.0, 30.0, 100.0)), _chain, good=1e-2,
    ),
)  # fmt: skip
