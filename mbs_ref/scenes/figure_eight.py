"""Three equal masses that chase each other along a figure of eight."""

from __future__ import annotations

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import Newton

PERIOD = 6.32591398  # s, for gm = 1 m^3/s^2; Chenciner and Montgomery 2000, sec. 1
PLACE = (0.97000436, -0.24308753)  # m, of the first; the second is opposite, the third at the origin
RATE = (0.93240737, 0.86473146)  # m/s, of the third; the others have minus half of it


def build(*, periods: Positive = 1.0) -> Scene:
    """Let three equal masses chase each other along one figure of eight (Moore; Chenciner, Montgomery).

    periods (revolutions of 6.32591398 s).
    """
    (x, y), (u, v) = PLACE, RATE
    starts = (((x, y), (-u / 2, -v / 2)), ((-x, -y), (-u / 2, -v / 2)), ((0.0, 0.0), (u, v)))
    return Scene(
        name="figure_eight",
        description="Three particles of 1 m^3/s^2 on one closed curve; stable, and known to eight digits.",
        source="A. Chenciner, R. Montgomery, Annals of Mathematics 152 (2000) 881",
        duration=PERIOD * periods,
        gravity=(0.0, 0.0, 0.0),
        bodies=tuple(
            PointMass(name=f"body{k + 1}", mass=1.0, position=(*p, 0.0), velocity=(*w, 0.0))
            for k, (p, w) in enumerate(starts)
        ),
        loads=(Newton(name="newton", gm=(1.0, 1.0, 1.0)),),
    )
