"""Particles under Newton's attraction: Kepler's orbit and classical test problems."""

import math
from typing import Annotated, Any

from pydantic import Field

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import AU_M, DAY_S, G_SI, Newton
from mbs_ref.scenes import read_data


def kepler(*, eccentricity: Annotated[float, Field(ge=0.0, le=0.999)] = 0.6, orbits: Positive = 10.0) -> Scene:
    """Follow a test particle around a unit attractor, from the nearest point of an ellipse (Kepler).

    eccentricity (0 to 0.999), orbits (revolutions; the semi-major axis is 1 m and gm 1 m^3/s^2).
    """
    e = eccentricity
    return Scene(
        name="kepler",
        description="A test particle on an ellipse with semi-major axis 1 m about a fixed attractor of 1 m^3/s^2.",
        source="J. Kepler, Astronomia Nova, 1609",
        duration=2.0 * math.pi * orbits,
        bodies=(
            PointMass(name="center", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            PointMass(
                name="planet", mass=1.0, position=(1.0 - e, 0.0, 0.0),
                velocity=(0.0, math.sqrt((1.0 + e) / (1.0 - e)), 0.0),
            ),
        ),
        loads=(Newton(name="newton", gm=(1.0, 0.0)),),
    )  # fmt: skip


EIGHT_PERIOD = 6.32591398  # s, for gm = 1 m^3/s^2; Chenciner and Montgomery 2000, sec. 1
EIGHT_PLACE = (0.97000436, -0.24308753)  # m, of the first; the second is opposite, the third at the origin
EIGHT_RATE = (0.93240737, 0.86473146)  # m/s, of the third; the others have minus half of it


def figure_eight(*, periods: Positive = 1.0) -> Scene:
    """Let three equal masses chase each other along one figure of eight (Moore; Chenciner, Montgomery).

    periods (revolutions of 6.32591398 s).
    """
    (x, y), (u, v) = EIGHT_PLACE, EIGHT_RATE
    starts = (((x, y), (-u / 2, -v / 2)), ((-x, -y), (-u / 2, -v / 2)), ((0.0, 0.0), (u, v)))
    return Scene(
        name="figure_eight",
        description="Three particles of 1 m^3/s^2 on one closed curve; stable, and known to eight digits.",
        source="A. Chenciner, R. Montgomery, Annals of Mathematics 152 (2000) 881",
        duration=EIGHT_PERIOD * periods,
        bodies=tuple(
            PointMass(name=f"body{k + 1}", mass=1.0, position=(*p, 0.0), velocity=(*w, 0.0))
            for k, (p, w) in enumerate(starts)
        ),
        loads=(Newton(name="newton", gm=(1.0, 1.0, 1.0)),),
    )


G_AU3_DAY2 = 2.95912208286e-4  # au^3/(day^2 solar masses), as the source has it
OUTER_PLANETS: dict[str, Any] = read_data("outer_planets")["bodies"]


def outer_solar_system(*, days: Positive = 200_000.0) -> Scene:
    """Follow the Sun (with the inner planets' mass) and five outer planets (Hairer, Lubich, Wanner).

    days (200 000 are 548 years).
    """
    gm = {name: mass * G_AU3_DAY2 * AU_M**3 / DAY_S**2 for name, (mass, _, _) in OUTER_PLANETS.items()}  # m^3/s^2
    return Scene(
        name="outer_solar_system",
        description="The Sun, Jupiter, Saturn, Uranus, Neptune and Pluto from 1994-09-05 0 h, Newton's gravity.",
        source="Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, sec. I.2.4",
        duration=days * DAY_S,
        bodies=tuple(
            PointMass(
                name=name, mass=gm[name] / G_SI,
                position=tuple(x * AU_M for x in place), velocity=tuple(u * AU_M / DAY_S for u in rate),
            )
            for name, (_, place, rate) in OUTER_PLANETS.items()
        ),
        loads=(Newton(name="newton", gm=tuple(gm.values())),),
    )  # fmt: skip
