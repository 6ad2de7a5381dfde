"""The Pleiades problem: seven stars in a plane with close encounters."""

from __future__ import annotations

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton

X = (3.0, 3.0, -1.0, -3.0, 2.0, -2.0, 2.0)  # m
Y = (3.0, -3.0, 2.0, 0.0, 0.0, -4.0, 4.0)  # m
U = (0.0, 0.0, 0.0, 0.0, 0.0, 1.75, -1.5)  # m/s
V = (0.0, 0.0, 0.0, -1.25, 1.0, 0.0, 0.0)  # m/s


def build() -> Scene:
    """Let seven stars pass each other closely for three time units (Hairer, Norsett, Wanner)."""
    stars = zip(X, Y, U, V, strict=True)
    return Scene(
        name="pleiades",
        description="Seven stars in a plane, of gm 1 to 7 m^3/s^2, with close encounters.",
        source="Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., sec. II.10",
        duration=3.0,
        gravity=(0.0, 0.0, 0.0),
        bodies=tuple(
            PointMass(name=f"star{k + 1}", mass=k + 1.0, position=(x, y, 0.0), velocity=(u, v, 0.0))
            for k, (x, y, u, v) in enumerate(stars)
        ),
        loads=(Newton(name="newton", gm=tuple(float(k + 1) for k in range(7))),),
    )
