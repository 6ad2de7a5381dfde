"""Orbits, planets and satellites: eccentricity up to a collision, long steps and spans, and close approaches.

Errors of planets and satellites are shares of how far they go in the span, as a run's own estimate counts them.
"""

import math

import numpy as np

from cross_checks.extremes import Case, by_truth, grid, invariants, unjudged
from cross_checks.truths.made_by.sky.particles import converge
from cross_checks.truths.of import sky
from mbs_ref import scenes
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton

TURN = 2.0 * math.pi  # s, of a = 1 m about 1 m^3/s^2
STILL = (0.0, 0.0, 0.0)
RTOL = 1e-10
MEETING = 3e6  # s, of the visitor's fall past Jupiter
KNOWN = 3e9  # m aside, down to which a truth converges in a second; it then passes 1.4e8 m from Jupiter's centre
FAR, SLOW = 1e10, 2e3  # m and m/s: where it is released, and how fast


def _eccentric(gap: float) -> Case:
    """1 - e = gap, two orbits in 1000 steps; at 0 the bodies start in one place."""
    step = TURN / 500.0
    scene = scenes.builder_of("kepler")(eccentricity=1.0 - gap, orbits=2.0) if gap else _pair("coincident", STILL, 0.0)
    measure = by_truth(sky.kepler) if gap else unjudged
    return Case(scene, grid(1000.0 * step, step, 9), measure, step, 1e-10, must_stop=not gap)


def _pair(name: str, place: tuple[float, float, float], sideways: float) -> Scene:
    """Return a particle at a place (m) with a speed along y (m/s), and the centre that attracts it."""
    starts = {"center": (STILL, STILL), "planet": (place, (0.0, sideways, 0.0))}
    bodies = tuple(PointMass(name=name, mass=1.0, position=x, velocity=v) for name, (x, v) in starts.items())
    return Scene(name=name, gravity=STILL, bodies=bodies, loads=(Newton(name="newton", gm=(1.0, 0.0)),))


def _visited(aside: float) -> Case:
    """Pluto is released beside Jupiter, past which it falls at a distance that shrinks with `aside` (m)."""
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
    measure = by_truth(converge, None) if aside >= KNOWN else invariants
    return Case(scene, grid(MEETING, step, 9), measure, step=step, rtol=RTOL)


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
    return Case(scene, grid(10_000.0, 10.0, 6), by_truth(converge, None), step=10.0, rtol=RTOL)


CASES = {
    "eccentricity": _eccentric,
    # released at 1 m with hardly any sideways speed v: e = 1 - v^2, and with none the fall ends in collision
    "plunge": lambda v: Case(_pair("plunge", (1.0, 0.0, 0.0), v), grid(1.5), invariants, rtol=1e-10, must_stop=not v),
    "planets-approach": _visited,
    "satellite-dive": _diving,
}
