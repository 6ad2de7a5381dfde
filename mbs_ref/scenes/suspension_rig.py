"""One suspension unit of the tracked vehicle on a shaker post: a linear oscillator driven at its base."""

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Prismatic, Scene, SpringDamper
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.signals import Constant, Harmonic
from mbs_ref.scenes.tracked_vehicle.running_gear import BAR, DATA

HEIGHTS = {"post": 0.0, "wheel": 0.5, "hull": 1.0}  # m
TIRE = 1e6  # N/m, of a road wheel's solid rubber tire: an estimate


def suspension_rig(
    *,
    amplitude: Positive = 0.02,
    frequency: Annotated[float, Field(gt=0.0, le=100.0)] = 3.0,
    sprung_mass: Positive = 500.0,
    wheel_mass: Positive = DATA["roller"]["mass"],
    stiffness: Positive = BAR["stiffness"] / BAR["arm_length"] ** 2,
    damping: NonNegative = BAR["damping"] / BAR["arm_length"] ** 2,
    tire_stiffness: Positive = TIRE,
    gravity: NonNegative = 9.81,
) -> Scene:
    """Shake one suspension unit of the tracked vehicle on a post, y = amplitude (cos(2 pi frequency t) - 1).

    amplitude (m) and frequency (Hz) of the post; sprung_mass (kg) of a third of the hull, wheel_mass (kg); stiffness
    (N/m) and damping (N s/m) of the torsion bar at the wheel; tire_stiffness (N/m); gravity (m/s^2). All slide along y
    and start at rest in static equilibrium, so that the motion is that of a linear oscillator.
    """
    masses = {"wheel": wheel_mass, "hull": sprung_mass}
    borne = {"tire": gravity * (wheel_mass + sprung_mass), "bar": gravity * sprung_mass}  # N
    rates = {"tire": (tire_stiffness, 0.0), "bar": (stiffness, damping)}
    ends = {"tire": ("post", "wheel"), "bar": ("wheel", "hull")}
    motion = {
        "y": Harmonic(amplitude=amplitude, omega=2.0 * math.pi * frequency, phase=0.5 * math.pi, offset=-amplitude),
        "x": Constant(value=0.0), "angle": Constant(value=0.0),
    }  # fmt: skip
    return Scene(
        name="suspension_rig",
        description="A third of the hull on a road wheel with a solid tire, shaken by a post under it.",
        source="Textbook oscillator; numbers of scenes/data/tracked_vehicle.json, tire_stiffness an estimate",
        duration=2.0,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(name="post", mass=10.0, inertia=1.0, position=(0.0, HEIGHTS["post"])),
            *(PlanarBody(name=n, mass=m, inertia=m, position=(0.0, HEIGHTS[n])) for n, m in masses.items()),
        ),
        joints=(
            *(
                CoordinateDrive(name=f"post.{axis}", body="post", coordinate=axis, motion=motion[axis])  # type: ignore[arg-type]
                for axis in ("x", "y", "angle")
            ),
            *(
                Prismatic(name=f"{n}.guide", body_a=GROUND, body_b=n, point=(0.0, HEIGHTS[n]), axis=(0.0, 1.0))
                for n in masses
            ),
        ),
        loads=tuple(
            SpringDamper(
                name=n, body_a=a, body_b=b, point_a=(0.0, HEIGHTS[a]), point_b=(0.0, HEIGHTS[b]), stiffness=rates[n][0],
                damping=rates[n][1], rest_length=HEIGHTS[b] - HEIGHTS[a] + borne[n] / rates[n][0],
            )
            for n, (a, b) in ends.items()
        ),
    )  # fmt: skip
