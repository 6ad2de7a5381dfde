"""The simplified android of the papers, 13 planar bodies, in a crash."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.android import Crash, android
from mbs_ref.part import NonNegative
from mbs_ref.scene import Scene

DESCRIPTION = (
    "13 bodies: 11 parts of a person joined by 10 revolutes, seat base and seat back; "
    "no friction and no joint stops."
)


def build(
    *,
    peak_force: Annotated[float, Field(ge=500.0, le=100_000.0)] = 15_000.0,
    speed_change_km_h: Annotated[float, Field(gt=0.0, le=200.0)] = 50.0,
    impact: Literal["front", "rear"] = "front",
    mass: Annotated[float, Field(ge=50.0, le=100.0)] = 75.0,
    belts: bool = True,
    belt_stiffness: NonNegative = 1.0,
    law: Literal["progressive", "spring_damper"] = "progressive",
    seat: Literal["fixed", "driven"] = "fixed",
    pulse: Literal["half_sine", "table"] = "half_sine",
    lift: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0,
) -> Scene:
    """The simplified android of the papers, 13 planar bodies, in a crash.

    peak_force (N) and speed_change_km_h fix a half sine (or its breakpoint table) with impulse m dv; front
    or rear impact; mass (kg) scales masses and inertias; belts, and their stiffness and damping times
    belt_stiffness; contact law; seat fixed with mass-proportional forces, or driven; lift (m) off the seat.
    """
    crash = Crash(peak_force, speed_change_km_h, impact, mass, belts, belt_stiffness, law, seat, pulse, lift)
    return android("android_simplified", DESCRIPTION, crash)
