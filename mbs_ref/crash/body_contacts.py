"""Contacts that keep an android's parts out of one another and out of its seat: circles on limbs, edges and cushions.

Arms are beside the trunk and the thighs, and touch the seat alone.
"""

from collections.abc import Iterator
from typing import Any

from mbs_ref.crash.places import Places, Point
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, Contact, ProgressiveLaw

THICK = 0.15  # m, deeper is behind a limb or a cushion


def body_contacts(entries: list[dict[str, Any]], places: Places) -> Iterator[Contact]:
    """Yield the contacts whose bodies this android has."""
    for entry in entries:
        circle, surface = entry["circle"], entry["surface"]
        if {circle["body"], surface["body"]} <= places.body.keys():
            yield _contact(entry, circle, surface, places)


def contact_name(entry: dict[str, Any]) -> str:
    """Return the name of a contact in the scene."""
    circle, surface = entry["circle"], entry["surface"]
    return f"{circle['body']}.{circle.get('label') or circle['point']}.{surface['body']}"


def _contact(entry: dict[str, Any], circle: dict[str, Any], surface: dict[str, Any], places: Places) -> Contact:
    law = ProgressiveLaw(stiffness=entry["k"], damping=entry["c_progressive"])
    ends = {"name": contact_name(entry), "body_a": circle["body"], "body_b": surface["body"], "law": law}
    center = _center(circle, places)
    if "circle" in surface:
        other = places.point(surface["body"], surface["circle"])
        return CircleOnCircle(
            **ends, center_a=center, radius_a=circle["radius"], center_b=other, radius_b=surface["radius"]
        )
    first, second = _surface(surface, places)
    return CircleOnLine(
        **ends, center=center, radius=circle["radius"], point_1=first, point_2=second, extent="capped", thickness=THICK
    )


def _center(circle: dict[str, Any], places: Places) -> Point:
    body = circle["body"]
    if "front_edge" in circle:  # rounded, just beneath the end of the seat's surface
        seat = places.body[body]
        return places.world(body, (seat["half_length"] - circle["radius"], seat["surface_y"] - circle["radius"]))
    return places.world(body, tuple(circle["at"])) if "at" in circle else places.point(body, circle["point"])


def _surface(surface: dict[str, Any], places: Places) -> tuple[Point, Point]:
    """Return a seat's cushion, or the line between two points of a body moved `offset` m to the left of the way."""
    body = surface["body"]
    if surface.get("seat"):
        return places.seat_surface(body)
    points = places.body[body].get("points", {})
    first, second = (surface[f"{end}_at"] if f"{end}_at" in surface else points[surface[end]] for end in ("from", "to"))
    across, along = second[0] - first[0], second[1] - first[1]
    length = (across**2 + along**2) ** 0.5
    left = (-along / length * surface["offset"], across / length * surface["offset"])
    return tuple(places.world(body, (p[0] + left[0], p[1] + left[1])) for p in (first, second))  # type: ignore[return-value]
