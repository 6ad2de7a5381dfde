"""Orbits: ever more eccentric up to a collision, and ever more of them."""

from __future__ import annotations

import math

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, decades, grid
from cross_checks.truths.of import sky
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton
from mbs_ref.scenes.orbits import kepler as kepler

FAMILY = "orbits"
TURN = 2.0 * math.pi  # s, of a = 1 m about 1 m^3/s^2
STILL = (0.0, 0.0, 0.0)


def _eccentric(gap: float) -> Case:
    """1 - e = gap, two orbits in 1000 steps; at 0 the bodies start in one place."""
    step = TURN / 500.0
    scene = kepler(eccentricity=1.0 - gap, orbits=2.0) if gap else _coincident()
    measure = measures.truth(sky.kepler) if gap else measures.unjudged
    return Case(scene, grid(1000.0 * step, step, 9), measure, step=step, rtol=1e-10, must_stop=not gap)


def _coincident() -> Scene:
    bodies = tuple(PointMass(name=n, mass=1.0, position=STILL, velocity=STILL) for n in ("center", "planet"))
    return Scene(name="coincident", gravity=STILL, bodies=bodies, loads=(Newton(name="newton", gm=(1.0, 0.0)),))


def _plunge(sideways: float) -> Case:
    """Let go at 1 m with hardly any sideways speed: e = 1 - v^2, and with none the fall ends in collision."""
    bodies = (
        PointMass(name="center", mass=1.0, position=STILL, velocity=STILL),
        PointMass(name="planet", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, sideways, 0.0)),
    )
    loads = (Newton(name="newton", gm=(1.0, 0.0)),)
    scene = Scene(name="plunge", gravity=STILL, bodies=bodies, loads=loads)
    step = 1e-3
    return Case(scene, grid(1.5, step), measures.invariants(), step=step, rtol=1e-10, must_stop=not sideways)


def _many(orbits: float) -> Case:
    step = TURN / 200.0
    return Case(
        kepler(eccentricity=0.2, orbits=orbits), grid(200.0 * orbits * step, step, 5), measures.truth(sky.kepler),
        step=step, rtol=1e-12, max_steps=300_000_000,
    )  # fmt: skip


EXTREMES = (
    Extreme("eccentricity", FAMILY, "Two orbits of ever higher eccentricity, up to two bodies in one place.",
            Axis("1 - e", "", (0.4, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 0.0)), _eccentric, good=1e-2),
    Extreme("plunge", FAMILY, "A particle let go with ever less sideways speed passes ever closer, and collides at 0.",
            Axis("sideways speed", "m/s", (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 0.0)), _plunge, good=1e-2),
    Extreme("orbit-count", FAMILY, "Ever more orbits of eccentricity 0.2, 200 steps each where steps are fixed.",
            Axis("orbits", "", decades(1.0, 1e3), full=(1e4, 1e5, 1e6)), _many, good=1e-2),
)  # fmt: skip
