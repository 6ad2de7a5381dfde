"""Tolerances from an everyday one down to far below roundoff, and up to a hundredth."""

from __future__ import annotations

import math

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.truths.of import loops, pendulums, sky
from mbs_ref import scenes

FAMILY = "tolerances"
TIGHT = Axis("rtol", "", decades(1e-6, 1e-20, 2.0))
LOOSE = Axis("rtol", "", decades(1e-6, 1e-2))


def _pendulum(rtol: float) -> Case:
    return Case(scenes.make("pendulum"), grid(5.0), measures.truth(pendulums.pendulum), rtol=rtol)


def _orbit(rtol: float) -> Case:
    return Case(scenes.make("kepler", orbits=3.0), grid(6.0 * math.pi), measures.truth(sky.kepler), rtol=rtol)


def _loop(rtol: float) -> Case:
    return Case(scenes.make("n_four_bar", loops=1), grid(3.0), measures.truth(loops.n_four_bar), rtol=rtol)


EXTREMES = (
    Extreme("tolerance-pendulum", FAMILY, "Five seconds of a pendulum at tolerances nobody can meet.",
            TIGHT, _pendulum),
    Extreme("tolerance-orbit", FAMILY, "Three orbits of eccentricity 0.6.", TIGHT, _orbit),
    Extreme(
        "tolerance-singular", FAMILY,
        "A four-bar through its flat pose: near it roundoff grows, and a tight tolerance asks for what is not there.",
        TIGHT, _loop,
    ),
    Extreme("loose-pendulum", FAMILY, "Five seconds of a pendulum at tolerances that promise ever less.",
            LOOSE, _pendulum),
    Extreme("loose-orbit", FAMILY, "Three orbits whose close passes a loose tolerance may step over.", LOOSE, _orbit),
    Extreme("loose-singular", FAMILY, "A four-bar through its flat pose, where a loose step may change the branch.",
            LOOSE, _loop),
)  # fmt: skip
