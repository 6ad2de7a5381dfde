"""The Sun and the five outer planets of the classical test problem."""

from __future__ import annotations

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import AU_M, DAY_S, G_SI, Newton

G_AU3_DAY2 = 2.95912208286e-4  # au^3/(day^2 solar masses), as the source has it
# name: mass (solar masses), position (au), velocity (au/day), heliocentric, 1994-09-05 0 h
DATA = {
    "sun": (1.00000597682, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    "jupiter": (0.000954786104043, (-3.5023653, -3.8169847, -1.5507963), (0.00565429, -0.00412490, -0.00190589)),
    "saturn": (0.000285583733151, (9.0755314, -3.0458353, -1.6483708), (0.00168318, 0.00483525, 0.00192462)),
    "uranus": (0.0000437273164546, (8.3101420, -16.2901086, -7.2521278), (0.00354178, 0.00137102, 0.00055029)),
    "neptune": (0.0000517759138449, (11.4707666, -25.7294829, -10.8169456), (0.00288930, 0.00114527, 0.00039677)),
    "pluto": (1.0 / 1.3e8, (-15.5387357, -25.2225594, -3.1902382), (0.00276725, -0.00170702, -0.00136504)),
}


def build(*, days: Positive = 200_000.0) -> Scene:
    """Follow the Sun (with the inner planets' mass) and five outer planets (Hairer, Lubich, Wanner).

    days (200 000 are 548 years).
    """
    gm = {name: mass * G_AU3_DAY2 * AU_M**3 / DAY_S**2 for name, (mass, _, _) in DATA.items()}  # m^3/s^2
    return Scene(
        name="outer_solar_system",
        description="The Sun, Jupiter, Saturn, Uranus, Neptune and Pluto from 1994-09-05 0 h, Newton's gravity.",
        source="Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, sec. I.2.4",
        duration=days * DAY_S,
        gravity=(0.0, 0.0, 0.0),
        bodies=tuple(
            PointMass(
                name=name, mass=gm[name] / G_SI,
                position=tuple(x * AU_M for x in place), velocity=tuple(u * AU_M / DAY_S for u in rate),
            )
            for name, (_, place, rate) in DATA.items()
        ),
        loads=(Newton(name="newton", gm=tuple(gm.values())),),
    )  # fmt: skip
