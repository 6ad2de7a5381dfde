"""Particles under Newton's attraction: Kepler's orbit and classical test problems."""

from typing import Any

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import AU_M, DAY_S, G_SI, Newton
from mbs_ref.scenes import read_data

EIGHT_PERIOD = 6.32591398  # s, for gm = 1 m^3/s^2; Chenciner and Montgomery 2000, sec. 1
EIGHT_PLACE = (0.97000436, -0.24308753)  # m, of the first; the second is opposite, the third at the origin
EIGHT_RATE = (0.93240737, 0.86473146)  # m/s, of the third; the others have minus half of it


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
