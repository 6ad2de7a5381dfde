"""The crash android under harder pulses, with stiffer belts or none, and with heavier or lighter occupants."""

from typing import Any

import numpy as np

from cross_checks.extremes import Case, Measured, grid
from cross_checks.truths.made_by import Formulation
from cross_checks.truths.made_by.mechanisms.hinged_tree import formulations
from cross_checks.truths.made_by.numerics.solvers import runge_kutta
from mbs_ref import Trajectory, scenes
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import PlanarBody, Scene

END, STEP = 0.06, 1e-4  # s: the papers' step
LOOSE, TIGHT = 1e-8, 1e-10  # relative tolerances of the truth, which is known as well as the two agree
SIZE = 0.1  # m, about how far the head moves


def _android(**parameters: Any) -> Case:
    return _case(scenes.make("android_simplified", model="paper", **parameters))


def _case(scene: Scene) -> Case:
    return Case(scene, grid(END, STEP, 7), _lagrange, step=STEP, max_steps=200_000)


def _lagrange(scene: Scene, path: Trajectory) -> Measured:
    """Judge centres by Lagrange's equations in body angles with forces of their own."""
    equations = formulations(scene)[0]
    loose, tight = (Partial(_places(equations, path.times, tolerance)) for tolerance in (LOOSE, TIGHT))
    return Measured(*(farthest(scene, x, tight)[0] / SIZE for x in (path, loose)))


def _places(equations: Formulation, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the centres (n_t, n_bodies, 2), m; every breakpoint of the loads ends a step."""
    every = np.union1d(times, [t for t in equations.breakpoints if 0.0 < t < times[-1]])
    states = runge_kutta(equations.derivative, equations.start, every, tolerance)
    return np.array([equations.poses(t, y)[0] for t, y in zip(every, states, strict=True) if t in times])


def _scaled(body: PlanarBody, factor: float) -> PlanarBody:
    return body.model_copy(update={"mass": factor * body.mass, "inertia": factor * body.inertia})


def _massive(factor: float) -> Case:
    """The occupant's masses and inertias times a factor; belts, seat and pulse as they are."""
    scene = scenes.make("android_simplified", model="paper")
    planar = [body for body in scene.bodies if isinstance(body, PlanarBody)]
    bodies = tuple(body if body.name.startswith("seat") else _scaled(body, factor) for body in planar)
    return _case(scene.model_copy(update={"name": "android_scaled", "parameters": {}, "bodies": bodies}))


CASES = {
    "android-pulse": lambda force: _android(peak_force=force),
    "android-belts": lambda factor: _android(belt_stiffness=factor),
    "android-loose": lambda kind: _android(belts=kind == 0, impact="rear" if kind == 2 else "front"),
    "android-mass": _massive,
}
