"""Chains: many links, mass ratios from 1 to 1e14, a tip that draws a chain taut, and chaos for long."""

import math
from functools import lru_cache

import numpy as np

from cross_checks.extremes import Case, Measured, by_positions, grid, invariants, worst
from cross_checks.extremes.parts import GRAVITY, rod_chain
from cross_checks.truths.made_by.mechanisms.rod_chain import Rods, lagrange
from cross_checks.truths.made_by.numerics.solvers import runge_kutta
from mbs_ref import Scene, Trajectory
from mbs_ref.observables.distance import Partial, farthest

HEAVIEST = 1e6  # times the lightest rod: with a heavier tip absolute angles do not converge, nor in extended precision
FOLDED = (0.0, math.pi - 0.4, 0.3, -0.6)  # rad, from the x axis: a slack heap that falls and is drawn taut
FALL = 1.2  # s
TUMBLING = (0.9, 0.4, 0.0)  # rad, from the x axis: energy enough to turn over
HORIZON = 3.0  # s: beyond, an error of 1e-10 m grows past what a run of 1e-8 can be held to


@lru_cache(maxsize=32)
def _exact(angles: tuple[float, ...], masses: tuple[float, ...], times: tuple[float, ...], tolerance: float = 1e-12):
    """Return centres (n_t, n, 2) by Lagrange's equations in absolute angles, DOP853."""
    mass = np.array(masses)
    formulation = lagrange(Rods(np.ones(len(masses)), mass, mass / 12.0, GRAVITY, np.array(angles)))
    states = runge_kutta(formulation.derivative, formulation.start, np.array(times), tolerance)
    return np.array([formulation.poses(t, y)[0] for t, y in zip(times, states, strict=True)])


def _folded(name: str, masses: tuple[float, ...]) -> Case:
    measure = by_positions(lambda times: _exact(FOLDED, masses, tuple(times.tolist())))
    is_known = max(masses) <= HEAVIEST
    return Case(rod_chain(name, FOLDED, masses), grid(FALL), measure if is_known else invariants)


def _within_horizon(scene: Scene, path: Trajectory) -> Measured:
    exact = _exact(TUMBLING, (1.0, 1.0, 1.0), tuple(path.times[path.times <= HORIZON].tolist()), 1e-13)
    return Measured(farthest(scene, path, Partial(exact))[0])


def _tumbling(duration: float) -> Case:
    scene, step = rod_chain("chaotic_chain", TUMBLING, (1.0, 1.0, 1.0)), 5e-4
    return Case(scene, grid(duration, step), worst(_within_horizon, invariants), step, 1e-10)


CASES = {
    "chain-going-taut": lambda ratio: _folded("chain_taut", (1.0, 1.0, 1.0, ratio)),
    "light-link": lambda ratio: _folded("light_link", (1.0, 1.0, 1.0 / ratio, 1.0)),
    "chaotic-chain": _tumbling,
}
