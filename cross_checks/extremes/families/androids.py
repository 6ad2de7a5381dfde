"""The crash android: ever harder pulses, stiffer belts, none of them, and ever heavier or lighter occupants."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.extremes.extreme import Axis, Case, Extreme, Measure, grid
from cross_checks.truths.made_by.agreement import Formulation
from cross_checks.truths.made_by.mechanisms.hinged_tree import formulations
from cross_checks.truths.made_by.numerics.scipy_solvers import runge_kutta
from mbs_ref import scenes
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.trajectory import Trajectory

FAMILY = "androids"
END, STEP, RTOL = 0.06, 1e-4, 1e-8  # s, s: the papers' step
LOOSE, TIGHT = 1e-8, 1e-10  # relative tolerances of the truth, which is known as well as the two agree
SIZE = 0.1  # m, about how far the head moves
BELTS = ("both belts", "no belts", "no belts, seat reclined by a rear impact")


def _android(**parameters: Any) -> Case:
    return _case(scenes.make("android_simplified", **parameters))


def _case(scene: Scene) -> Case:
    return Case(scene, grid(END, STEP, 7), _lagrange(), step=STEP, rtol=RTOL, max_steps=200_000)


def _lagrange() -> Measure:
    """Judge centres by Lagrange's equations in body angles with forces of their own, less what these leave open."""

    def measure(scene: Scene, path: Trajectory) -> float:
        equations = formulations(scene)[0]
        loose, tight = (Partial(_places(equations, path.times, tolerance)) for tolerance in (LOOSE, TIGHT))
        error, doubt = (farthest(scene, x, tight)[0] for x in (path, loose))
        return max(error - doubt, 0.0) / SIZE

    return measure


def _places(equations: Formulation, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the centres (n_t, n_bodies, 2), m; every breakpoint of the loads ends a step."""
    every = np.union1d(times, [t for t in equations.breakpoints if 0.0 < t < times[-1]])
    states = runge_kutta(equations.derivative, equations.start, every, tolerance)
    asked = zip(every, states, strict=True)
    return np.array([equations.poses(t, y)[0] for t, y in asked if t in times])


def _restrained(kind: float) -> Case:
    if kind == 2:
        return _android(belts=False, impact="rear")
    return _android(belts=kind == 0)


def _scaled(body: PlanarBody, factor: float) -> PlanarBody:
    return body.model_copy(update={"mass": factor * body.mass, "inertia": factor * body.inertia})


def _massive(factor: float) -> Case:
    """The occupant's masses and inertias times a factor; belts, seat and pulse as they are."""
    scene = scenes.make("android_simplified")
    planar = [body for body in scene.bodies if isinstance(body, PlanarBody)]
    bodies = tuple(body if body.name.startswith("seat") else _scaled(body, factor) for body in planar)
    return _case(scene.model_copy(update={"name": "android_scaled", "parameters": {}, "bodies": bodies}))


EXTREMES = (
    Extreme("android-pulse", FAMILY, "The occupant of 13 bodies in ever harder frontal crashes.",
            Axis("peak force", "N", (5e3, 2e4, 1e5)), lambda force: _android(peak_force=force), good=1e-2),
    Extreme("android-belts", FAMILY, "The same crash with belts ever stiffer than webbing.",
            Axis("belt stiffness over webbing's", "", (1.0, 10.0, 1e2)),
            lambda factor: _android(belt_stiffness=factor), good=1e-2),
    Extreme("android-loose", FAMILY, "The same crash without belts: seat and floor alone hold the occupant.",
            Axis("restraint", "", (0.0, 1.0, 2.0), BELTS), _restrained, good=1e-2),
    Extreme("android-mass", FAMILY, "Ever lighter occupants under the same pulse: accelerations grow without limit.",
            Axis("mass over 75 kg", "", (1.0, 0.3, 0.1)), _massive, good=1e-2),
)  # fmt: skip
