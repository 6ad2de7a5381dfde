"""Rotation: fast spin to 1e5 rad/s, the drift of Euler parameters, inertia near zero, and needles."""

import math

import numpy as np

from cross_checks.extremes import Case, by_positions, by_truth, grid, invariants
from cross_checks.extremes.parts import GRAVITY, INERTIA, LENGTH, hanging, made, swing
from cross_checks.truths.of import tops
from mbs_ref import scenes

TIME = 0.1  # s
THINNEST = 5e-3  # moment ratio


def _needle(ratio: float) -> Case:
    scene = scenes.make(
        "torque_free_top", spin=10.0, axis=3, tilt=0.1, turns=2.0,
        inertia_1=ratio, inertia_2=1.0, inertia_3=1.0 + 0.5 * ratio,
    )  # fmt: skip
    # thinner needles turn so fast about themselves that the truth's quadrature has too many pieces for a quick look
    measure = by_truth(tops.torque_free_top) if ratio >= THINNEST else invariants
    return Case(scene, grid(1.256), measure)


def _wheel(inertia: float) -> Case:
    """A wheel hinged at its centre to the tip of a rod does not turn: it swings as a particle does."""
    start = 1.0  # rad from the lowest place
    rate = math.sqrt(GRAVITY * 1.5 * LENGTH / (INERTIA + 0.25 + LENGTH**2))

    def exact(times: np.ndarray) -> np.ndarray:
        reach = hanging(swing(times, rate, start))
        return np.concatenate([0.5 * reach, reach], axis=1)

    return Case(made("wheel_on_rod", inertia=inertia), grid(2.0), by_positions(exact))


def _rotor(spin: float) -> Case:
    """Without gravity a hinged rod turns evenly."""
    # initial velocities are rounded: at 1e5 rad/s a joint's velocity is exact to 1e-11 m/s only
    exact = by_positions(lambda times: hanging(spin * times + 0.5 * math.pi, 0.5 * LENGTH))
    return Case(made("rotor", spin=spin), grid(TIME), exact)


CASES = {"needle": _needle, "tiny-wheel": _wheel, "rotor-spin": _rotor}
