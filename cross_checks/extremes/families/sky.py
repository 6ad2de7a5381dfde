"""Planets and satellites: ever longer steps and spans, and ever closer approaches.

Errors are shares of how far the bodies go in the span, as a run's own estimate counts them.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from cross_checks.truths.made_by.sky.particles import converge
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import DAY_S

FAMILY = "sky"
YEAR = 365.25 * DAY_S  # s
RTOL = 1e-10
MEETING = 3e6  # s, of the visitor's fall past Jupiter
KNOWN = 3e9  # m aside, down to which a truth converges in a second; it then passes 1.4e8 m from Jupiter's centre
FAR, SLOW = 1e10, 2e3  # m and m/s: where it is let go from, and how fast


def _converged(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    return _kept(scene.name, tuple(times.tolist()))


@lru_cache(maxsize=4)
def _kept(name: str, times: tuple[float, ...]) -> Truth | NoTruth:
    """Solve a scene of the library once where an axis asks the same at every step."""
    return converge(scenes.make(name), np.array(times))


def _planets(times: np.ndarray, step: float, rtol: float | None = None) -> Case:
    scene = scenes.make("outer_solar_system")
    return Case(scene, times, measures.truth(_converged, None), step=step, rtol=rtol)


def _visited(aside: float) -> Case:
    """Pluto is let go beside Jupiter, past which it falls at a distance that shrinks with `aside` (m)."""
    scene = scenes.make("outer_solar_system")
    jupiter = next(body for body in scene.bodies if body.name == "jupiter")
    assert isinstance(jupiter, PointMass)
    place = tuple((np.array(jupiter.position) + np.array([FAR, aside, 0.0])).tolist())
    rate = tuple((np.array(jupiter.velocity) - np.array([SLOW, 0.0, 0.0])).tolist())
    bodies = tuple(
        body.model_copy(update={"position": place, "velocity": rate}) if body.name == "pluto" else body
        for body in scene.bodies
    )
    scene = scene.model_copy(update={"name": "visited_jupiter", "parameters": {}, "bodies": bodies})
    step = MEETING / 1000.0
    measure = measures.truth(converge, None) if aside >= KNOWN else measures.invariants()
    return Case(scene, grid(MEETING, step, 9), measure, step=step, rtol=RTOL)


def _satellite(times: np.ndarray, step: float, rtol: float | None = None) -> Case:
    scene = scenes.make("satellite")
    return Case(scene, times, measures.truth(_converged, None), step=step, rtol=rtol)


def _diving(altitude: float) -> Case:
    """One dive from the apogee of a transfer orbit through air of scale height 60 km, with a perigee so high (km)."""
    scene = scenes.make("satellite", drag=True)
    earth = scene.body_index("earth")
    newton = next(load for load in scene.loads if load.type == "newton")
    high, low = 2e7, newton.radius[earth] + 1e3 * altitude
    speed = float(np.sqrt(2.0 * newton.gm[earth] * low / (high * (high + low))))
    start = {"position": (high, 0.0, 0.0), "velocity": (0.0, 0.6 * speed, 0.8 * speed)}
    bodies = tuple(body if k == earth else body.model_copy(update=start) for k, body in enumerate(scene.bodies))
    scene = scene.model_copy(update={"name": "diving_satellite", "parameters": {}, "bodies": bodies})
    return Case(scene, grid(10_000.0, 10.0, 6), measures.truth(converge, None), step=10.0, rtol=RTOL)


EXTREMES = (
    Extreme("planets-step", FAMILY, "Thirty years of the outer planets in ever longer steps; Jupiter's year is 12.",
            Axis("step", "s", (1e5, 1e6, 1e7, 3e7, 1e8)),
            lambda step: _planets(grid(1e9, 1e9), step), good=1e-2),
    Extreme("planets-span", FAMILY, "The outer planets for ever longer, in steps of two weeks where steps are fixed.",
            Axis("span", "s", (0.4 * YEAR, 4.0 * YEAR, 20.0 * YEAR)),
            lambda span: _planets(grid(span, YEAR / 25.0, 9), YEAR / 25.0, RTOL), good=1e-2),
    Extreme("planets-approach", FAMILY,
            "A small planet falls past Jupiter ever closer. Below 3e9 m its energy is judged.",
            Axis("set off aside by", "m", (1e10, 3e9, 1e8, 1e7, 1e6)), _visited, good=1e-2),
    Extreme("satellite-step", FAMILY, "Half of a low satellite's orbit of 97 minutes in ever longer steps.",
            Axis("step", "s", (1.0, 10.0, 60.0, 300.0, 1000.0)),
            lambda step: _satellite(grid(3000.0, 3000.0), step), good=1e-2),
    Extreme("satellite-span", FAMILY, "A low satellite about an oblate Earth for ever longer, 10 s a step.",
            Axis("span", "s", (600.0, 3000.0, 6000.0)),
            lambda span: _satellite(grid(span, 10.0, 9), 10.0, RTOL), good=1e-2),
    Extreme("satellite-dive", FAMILY, "A satellite dives into ever denser air, 10 s a step where steps are fixed.",
            Axis("altitude of the perigee", "km", (1000.0, 300.0, 100.0)), _diving, good=1e-2),
)  # fmt: skip
