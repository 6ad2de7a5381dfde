"""The data of an android and its seat: places of their parts at t = 0, and outlines of the parts.

Outlines tell how deep parts are in one another, in the seat and in the floor. They follow from the motion alone,
whatever contacts the scene has: a bare model passes through itself. Depths exclude the compression of cushions, soles
and flesh, which the data state.
"""

import math
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from mbs_ref.files import package_data
from mbs_ref.observables.attachment import Motion

Point = tuple[float, float]


def read_data(name: str) -> dict[str, Any]:
    """Return mbs_ref/crash/data/<name>.json."""
    return package_data(__name__, "data", f"{name}.json")


class Places:
    """The bodies of mbs_ref/crash/data/<android>.json, lifted off the seat by `lift` m."""

    def __init__(self, data: dict[str, Any], lift: float) -> None:
        self.seats = {b["name"] for b in data["seat_bodies"]}
        self.body: dict[str, dict[str, Any]] = {b["name"]: b for b in (*data["bodies"], *data["seat_bodies"])}
        self._lift = lift

    def pose(self, body: str) -> tuple[Point, float]:
        """Return the centre of mass (m) and the angle (rad)."""
        x, y, angle = self.body[body]["q0"]
        return (x, y + (0.0 if body in self.seats else self._lift)), angle

    def world(self, body: str, local: tuple[float, float]) -> Point:
        """Return the world point of one in body axes from the centre of mass."""
        (x, y), angle = self.pose(body)
        c, s = math.cos(angle), math.sin(angle)
        return x + c * local[0] - s * local[1], y + s * local[0] + c * local[1]

    def point(self, body: str, point: str) -> Point:
        """Return the world point of a named one."""
        return self.world(body, self.body[body]["points"][point])

    def seat_surface(self, seat: str) -> tuple[Point, Point]:
        """Return the ends of a seat's surface: its free side is on the left of the way from one to the other."""
        reach, height = self.body[seat]["half_length"], self.body[seat]["surface_y"]
        return self.world(seat, (-reach, height)), self.world(seat, (reach, height))


LEGS, ARMS = ("thigh", "lower_leg", "foot"), ("upper_arm", "lower_arm", "hand")
TRUNK = ("head", "thorax", *(f"rib{k}" for k in range(1, 13)))
IN_ONE_PLANE = {("foot", "thigh"), *product(TRUNK, LEGS)}  # arms are beside trunk and legs
SEATED = (*LEGS, *ARMS, "head")  # what may meet the seat where the paper has no contact of it


@dataclass(frozen=True)
class Capsule:
    """A part's outline: all within `radius` (m) of the line between two of its points, world at t = 0."""

    body: str
    ends: tuple[tuple[float, float], tuple[float, float]]
    radius: float


def outlines(android: str) -> list[Capsule]:
    """Return the outlines of android_simplified's or android_vertebral's parts; parts without one are thin."""
    places = Places(read_data(android), 0.0)
    return [_capsule(entry, places) for entry in read_data("believable")["outlines"] if entry["body"] in places.body]


def _capsule(entry: dict[str, Any], places: Places) -> Capsule:
    body = entry["body"]
    first, second = (
        places.world(body, tuple(entry[f"{end}_at"])) if f"{end}_at" in entry else places.point(body, entry[end])
        for end in ("from", "to")
    )
    return Capsule(body, (first, second), entry["radius"])


def excesses(motion: Motion) -> dict[str, np.ndarray]:
    """Return (n_t,) m for each pair that may meet: how much deeper it is than what is soft there may be pressed in."""
    shapes = {capsule.body: capsule for capsule in outlines(motion.scene.name)}
    soft = read_data("believable")["depths"]
    depths = {
        f"{one} in {other}": _overlap(motion, shapes[one], shapes[other]) - soft["flesh"]
        for one, other in IN_ONE_PLANE if {one, other} <= shapes.keys()
    }  # fmt: skip
    for part, seat in product(SEATED, ("seat_base", "seat_back")):
        depths[f"{part} in {seat}"] = _in_cushion(motion, shapes[part], seat, soft) - soft[seat]
    for part in (*LEGS, *ARMS):
        ends = [motion.point(part, end)[0][:, 1] for end in shapes[part].ends]
        depths[f"{part} in floor"] = shapes[part].radius - np.min(ends, axis=0) - soft["floor"]
    return depths


def _overlap(motion: Motion, one: Capsule, other: Capsule) -> np.ndarray:
    """Return radii less the distance of two lines, (n_t,) m; where they cross, as deep as both radii."""
    a, b = ([motion.point(shape.body, end)[0] for end in shape.ends] for shape in (one, other))
    apart = np.min([_distance(x, *b) for x in a] + [_distance(x, *a) for x in b], axis=0)
    crossing = (_side(a[0], *b) * _side(a[1], *b) < 0.0) & (_side(b[0], *a) * _side(b[1], *a) < 0.0)
    return one.radius + other.radius - np.where(crossing, 0.0, apart)


def _distance(x: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return how far points (n_t, 2) are from the lines between p and q."""
    along = q - p
    share = np.clip(np.sum((x - p) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(x - p - share[:, None] * along, axis=1)


def _side(x: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the signed area that says on which side of the line from p to q a point is; positive on the left."""
    return (q[:, 0] - p[:, 0]) * (x[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (x[:, 0] - p[:, 0])


def _in_cushion(motion: Motion, shape: Capsule, seat: str, soft: dict[str, float]) -> np.ndarray:
    """Return how deep an outline's ends and middle are in a seat, (n_t,) m; nothing is beyond the seat's own ends."""
    surface = Places(read_data(motion.scene.name), 0.0).seat_surface(seat)
    p, q = (motion.point(seat, end)[0] for end in surface)
    length = np.linalg.norm(q - p, axis=1)
    first, second = (motion.point(shape.body, end)[0] for end in shape.ends)
    deepest = np.full(len(motion.times), -np.inf)
    for x in (first, 0.5 * (first + second), second):
        along = np.sum((x - p) * (q - p), axis=1) / length
        deep = shape.radius - _side(x, p, q) / length
        deepest = np.maximum(deepest, np.where((along > 0.0) & (along < length), deep, -np.inf))
    return np.maximum(deepest, -soft[seat])
