"""Springs from 1e2 to 1e14 N/m: quiet, where only stability is at stake, and ringing, where the motion is fast."""

import math

import numpy as np

from cross_checks.extremes import Case, by_positions, grid, in_plane
from cross_checks.extremes.parts import made

SOFT = 2.0 * (2.0 * math.pi) ** 2  # N/m: two masses of 1 kg swing at 1 Hz
SHIFT = 0.1  # m


def _quiet(stiffness: float) -> Case:
    """Start in the slow mode alone: x = rest + shape cos(w t), w^2 the small root of the 2 x 2 problem."""
    large = 0.5 * (SOFT + 2.0 * stiffness + math.hypot(SOFT, 2.0 * stiffness))
    slow = SOFT * stiffness / large  # the product of the roots is known, their difference would cancel
    shape = SHIFT * np.array([1.0 - slow / stiffness, 1.0])
    rest = np.array([1.0, 2.0])
    x = rest + shape
    scene = made("stiff_coupling", stiffness=stiffness, a=float(x[0]), b=float(x[1]))

    def exact(times: np.ndarray) -> np.ndarray:
        places = rest + shape * np.cos(math.sqrt(slow) * times)[:, None]
        return np.stack([places, np.zeros_like(places)], axis=2)

    return Case(scene, grid(2.0), by_positions(exact, SHIFT), max_steps=200_000)


def _ringing(stiffness: float) -> Case:
    scene = made("stiff_oscillator", stiffness=stiffness, x=1.0 + SHIFT)
    exact = by_positions(lambda times: in_plane(1.0 + SHIFT * np.cos(math.sqrt(stiffness) * times), 0.0), SHIFT)
    return Case(scene, grid(1.0), exact, max_steps=200_000)


CASES = {"stiff-spring-quiet": _quiet, "stiff-spring-ringing": _ringing}
