"""What limits an android's motion: joint stops, and contacts of its parts with one another and with the seat.

Like the ligaments that keep joints within a person's range of motion, a stop is a pair of strings across the joint that
are slack within the range and pull beyond it. Each is tied to levers that stand at a right angle, or wider where the
range asks it, as it becomes taut. Contacts are circles on limbs, edges and cushions; arms are beside the trunk and the
thighs, and touch the seat alone.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.crash.outlines import Places, Point
from mbs_ref.observables.attachment import Motion, length_of, pull_of
from mbs_ref.scene import SpringDamper
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


STOP = "stop."
MARGIN = math.radians(10.0)  # of the taut levers' angle over half the range: the other end of it stays slack


def joint_stops(joints: list[dict[str, Any]], stops: dict[str, Any], places: Places) -> Iterator[SpringDamper]:
    """Yield two strings for each of an android's joints whose range is known."""
    ranges = {entry["joint"]: entry for entry in (*stops["ranges"], *stops["spine"])}
    for joint in joints:
        entry = ranges.get(f"{joint['body_i']}-{joint['body_j']}")
        if entry is not None:
            yield from _strings(joint, bounds(joint, entry, places), stops, places)


def bounds(joint: dict[str, Any], entry: dict[str, Any], places: Places) -> tuple[float, float]:
    """Return how far (rad) theta_j - theta_i may fall and rise from its value at t = 0."""
    now = places.pose(joint["body_j"])[1] - places.pose(joint["body_i"])[1]
    if "from_posture" in entry:
        low, high = (math.radians(x) for x in entry["from_posture"])
    else:
        low, high = (math.radians(x) - now for x in entry["range"])
    if not low <= 0.0 <= high:
        raise ValueError(f"joint {entry['joint']} is at {math.degrees(now):.1f} deg, beyond its range {entry}")
    return low, high


def _strings(joint: dict[str, Any], limits: tuple[float, float], stops: dict[str, Any], places: Places):
    low, high = limits
    long, short = stops["lever"], stops["lever"] * stops["lever_ratio"]
    taut = max(0.5 * math.pi, 0.5 * (high - low) + MARGIN)
    rest = math.sqrt(long**2 + short**2 - 2.0 * long * short * math.cos(taut))
    arm = long * short * math.sin(taut) / rest  # m, of the pull about the joint as it sets in
    i, j = joint["body_i"], joint["body_j"]
    hinge = places.point(i, joint["point_i"])
    for side, angle in (("most", taut - high), ("least", -taut - low)):
        yield SpringDamper(
            name=f"{STOP}{i}-{j}.{side}", body_a=i, body_b=j, point_a=_at(hinge, long, 0.0),
            point_b=_at(hinge, short, angle), stiffness=stops["stiffness_factor"] * joint["torsion_k"] / arm**2,
            damping=joint["torsion_c"] / arm**2, rest_length=rest, tension_only=True,
        )  # fmt: skip


def _at(hinge: Point, lever: float, angle: float) -> Point:
    return hinge[0] + lever * math.cos(angle), hinge[1] + lever * math.sin(angle)


def tension(motion: Motion, string: SpringDamper) -> np.ndarray:
    """Return the pull (n_t,), N, of a spring."""
    return pull_of(string, *length_of(motion, string)[1:])[0]


def stop_load(motion: Motion, hinge: tuple[float, ...], upper: str, lower: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the force (n_t, 2), N, of a joint's stops on its upper body, and the moment (n_t,), N m, about `hinge`."""
    force, moment = np.zeros((len(motion.times), 2)), np.zeros(len(motion.times))
    at, _ = motion.point(upper, hinge)
    for string in motion.scene.loads:
        if not (isinstance(string, SpringDamper) and string.name.startswith(STOP)):
            continue
        marks = {string.body_a: string.point_a, string.body_b: string.point_b}
        if marks.keys() != {upper, lower}:
            continue
        here, there = (motion.point(body, marks[body])[0] for body in (upper, lower))
        along = (there - here) / np.linalg.norm(there - here, axis=1)[:, None]
        pull = tension(motion, string)[:, None] * along
        force += pull
        moment += (here - at)[:, 0] * pull[:, 1] - (here - at)[:, 1] * pull[:, 0]
    return force, moment
