"""The ground under a tracked vehicle: flat, and what stands on it, as shapes that touch a link's round feet.

Every shape's contact is continuous: a bump is the top of a buried circle, a slope a second half-plane, a step a
surface with a solid end. So they may touch one foot at once, as ground and kerb do.
"""

from typing import Literal

from mbs_ref.scene import GROUND
from mbs_ref.scene.contact import BekkerLaw, CircleOnCircle, CircleOnLine, Contact
from mbs_ref.scenes.tracked_vehicle.running_gear import DATA, HEIGHT, contact_law, friction

Kind = Literal["flat", "bump", "slope", "step"]
RADIUS = 0.5 * HEIGHT  # m, of a foot
AHEAD = 0.5  # m, between the front of the track at t = 0 and the obstacle
FAR = 1e3  # m, length of a step's top
BUMP_HALF_WIDTH = 0.3  # m, where its circle leaves the ground
SLOPE_RUN = 1.0  # m, in which a slope gains its height


def foot(
    name: str, link: str, center: tuple[float, float], law: str, soil: str, ground: Kind, height: float, front: float
):
    """Yield the contacts of one foot with the ground: flat, and the obstacle of `height` m beyond `front` (m)."""
    rub = friction(DATA["contact"]["link_ground"]["mu"])
    press = contact_law("link_ground", law) if soil == "hard" else _sinking(soil)
    body = {"body_a": link, "law": press, "friction": rub}
    yield CircleOnLine(
        name=name, center=center, radius=RADIUS, body_b=GROUND, point_1=(0.0, 0.0), point_2=(1.0, 0.0), **body
    )
    if ground != "flat":
        yield _obstacle(f"{name}.{ground}", center, ground, height, front + AHEAD, body)


def _sinking(soil: str) -> BekkerLaw:
    """Return the law of half a link's sole on a soil."""
    own, sole = DATA["soils"][soil], DATA["soils"]["sole"]
    return BekkerLaw(
        cohesive=own["k_c"], frictional=own["k_phi"], exponent=own["n"], width=sole["width"], length=sole["length"],
        damping=sole["c_progressive"],
    )  # fmt: skip


def _obstacle(name: str, center: tuple[float, float], ground: Kind, height: float, start: float, body: dict) -> Contact:
    if ground == "bump":
        radius = (BUMP_HALF_WIDTH**2 + height**2) / (2.0 * height)
        below = (start + BUMP_HALF_WIDTH, height - radius)
        return CircleOnCircle(
            name=name, center_a=center, radius_a=RADIUS, body_b=GROUND, center_b=below, radius_b=radius, **body
        )
    ends = ((start, height), (start + FAR, height)) if ground == "step" else ((start, 0.0), (start + SLOPE_RUN, height))
    extent = "capped" if ground == "step" else "line"
    return CircleOnLine(
        name=name, center=center, radius=RADIUS, body_b=GROUND, point_1=ends[0], point_2=ends[1], extent=extent, **body
    )
