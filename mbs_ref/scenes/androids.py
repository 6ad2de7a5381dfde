"""The androids of the papers in a crash: simplified and vertebral in the plane, and the simplified one in space."""

import math
from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.crash.android import Crash, Restraint, scene_builder
from mbs_ref.crash.in_space import in_space
from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import BELIEVABLE_ONLY, NonNegative

android_simplified = scene_builder(
    __name__,
    "android_simplified",
    "The simplified android of the papers, 13 planar bodies, in a crash.",
    "13 bodies: 11 parts of a person joined by 10 revolutes, seat base and seat back.",
)
android_vertebral = scene_builder(
    __name__,
    "android_vertebral",
    "The vertebral android of the papers, 48 planar bodies, in a crash: stiff.",
    "48 bodies: every vertebra, the ribs and the shoulder of a person, joined by 45 revolutes, "
    "seat base and seat back.",
)
BREADTH = 0.5  # m, of cushions and of the pair of limbs that a part stands for: an estimate


def android_spatial(
    *,
    model: Literal["believable", "paper"] = "believable",
    oblique: Annotated[float, Field(ge=-45.0, le=45.0)] = 15.0,
    peak_force: Annotated[float, Field(ge=500.0, le=100_000.0)] = 15_000.0,
    speed_change_km_h: Annotated[float, Field(gt=0.0, le=200.0)] = 50.0,
    impact: Literal["front", "rear"] = "front",
    mass: Annotated[float, Field(ge=50.0, le=100.0)] = 75.0,
    belts: bool = True,
    law: Literal["progressive", "spring_damper"] = "progressive",
    slack: Annotated[float, Field(ge=0.0, le=0.2), BELIEVABLE_ONLY] = Crash.slack,
    retractor: Annotated[float, Field(ge=0.0, le=0.2), BELIEVABLE_ONLY] = Crash.retractor,
    belt_limit: Annotated[NonNegative, BELIEVABLE_ONLY] = Crash.belt_limit,
    stops: Annotated[bool, BELIEVABLE_ONLY] = Crash.stops,
    body_contacts: Annotated[bool, BELIEVABLE_ONLY] = Crash.body_contacts,
    toe_board: Annotated[bool, BELIEVABLE_ONLY] = Crash.toe_board,
    head_restraint: Annotated[Restraint, BELIEVABLE_ONLY] = Crash.head_restraint,
) -> Scene:
    """Crash the simplified android in space, with ball joints, the pulse coming from straight ahead or obliquely.

    oblique (deg, of the pulse, towards the right); peak_force (N) and speed_change_km_h fix a half sine with impulse
    m dv; front or rear impact; mass (kg) scales masses and inertias; belts; contact law; model, slack, retractor,
    belt_limit, stops, body_contacts, toe_board and head_restraint as in the plane, stops about the plane's axis alone.
    At oblique = 0 it moves as the planar android does. Left and right limbs are one body each; inertias about x and y
    and the breadth of limbs and cushions are estimates. From the rear with stops alone: without them the arms turn by
    more than the 3 rad that a spring in space can measure. A frontal crash that turns a joint so far, such as one of
    100 kN and 200 km/h, stops there.
    """
    if impact == "rear" and (model == "paper" or not stops):
        raise ValueError("impact = 'rear' needs stops = true: without them the arms turn by more than 3 rad")
    planar = android_simplified(
        model=model, peak_force=peak_force, speed_change_km_h=speed_change_km_h, impact=impact, mass=mass, belts=belts,
        law=law, slack=slack, retractor=retractor, belt_limit=belt_limit, stops=stops, body_contacts=body_contacts,
        toe_board=toe_board, head_restraint=head_restraint,
    )  # fmt: skip
    ahead = "straight ahead" if impact == "front" else "straight from behind"
    described = f"13 bodies with ball joints, the pulse {oblique:g} degrees off {ahead}. It has no friction."
    return in_space(planar, "android_spatial", described, math.radians(oblique), BREADTH)
