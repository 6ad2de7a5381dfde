"""The data of an android and its seat, and the places of their parts at t = 0."""

import json
import math
from importlib.resources import files
from typing import Any

Point = tuple[float, float]


def read_data(name: str) -> dict[str, Any]:
    """Return mbs_ref/crash/data/<name>.json."""
    return json.loads((files("mbs_ref.crash") / "data" / f"{name}.json").read_text(encoding="utf-8"))


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
