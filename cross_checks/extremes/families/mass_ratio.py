"""Mass ratios from 1 to 1e8: a heavy tip that draws a chain taut, a light link between, a heavy piston."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.extremes.parts import rod_chain
from cross_checks.truths.made_by.mechanisms.rod_chain import Rods, lagrange
from cross_checks.truths.made_by.numerics.scipy_solvers import runge_kutta
from mbs_ref import scenes

FAMILY = "mass ratio"
STEP, RTOL = 1e-3, 1e-8
TRUTH_TOLERANCE = 1e-12
HEAVIEST = 1e6  # times the lightest rod: with a heavier tip absolute angles do not converge, nor in extended precision
FOLDED = (0.0, math.pi - 0.4, 0.3, -0.6)  # rad, from the x axis: a slack heap that falls and is drawn taut
FALL = 1.2  # s


@lru_cache(maxsize=32)
def _angles(angles: tuple[float, ...], masses: tuple[float, ...], times: tuple[float, ...]) -> np.ndarray:
    """Return centres (n_t, n, 2) by Lagrange's equations in absolute angles, DOP853."""
    mass = np.array(masses)
    rods = Rods(np.ones(len(masses)), mass, mass / 12.0, 9.81, np.array(angles))
    formulation = lagrange(rods)
    states = runge_kutta(formulation.derivative, formulation.start, np.array(times), TRUTH_TOLERANCE)
    return np.array([formulation.poses(t, y)[0] for t, y in zip(times, states, strict=True)])


def _chain(name: str, masses: tuple[float, ...]) -> Case:
    def exact(times: np.ndarray) -> np.ndarray:
        return _angles(FOLDED, masses, tuple(times.tolist()))

    scene = rod_chain(name, FOLDED, masses)
    measure = measures.positions(exact) if max(masses) <= HEAVIEST else measures.invariants()
    return Case(scene, grid(FALL, STEP), measure, step=STEP, rtol=RTOL)


def _heavy_tip(ratio: float) -> Case:
    return _chain("chain_taut", (1.0, 1.0, 1.0, ratio))


def _light_link(ratio: float) -> Case:
    return _chain("light_link", (1.0, 1.0, 1.0 / ratio, 1.0))


def _piston(ratio: float) -> Case:
    scene = scenes.make("slider_crank", slider_mass=2.0 * ratio)
    return Case(scene, grid(2.0, STEP, 41), measures.invariants(), step=STEP, rtol=RTOL)


EXTREMES = (
    Extreme("chain-going-taut", FAMILY, "A folded chain of four rods with an ever heavier tip falls and is drawn taut.",
            Axis("mass ratio", "", decades(1.0, 1e8)), _heavy_tip, good=1e-2),
    Extreme("light-link", FAMILY, "The same chain with one ever lighter rod.",
            Axis("mass ratio", "", decades(1.0, 1e14, 2.0)), _light_link, good=1e-2),
    Extreme("heavy-piston", FAMILY, "A slider-crank with an ever heavier slider; energy and constraints are judged.",
            Axis("mass ratio", "", decades(1.0, 1e8)), _piston, good=1e-2),
)  # fmt: skip
