"""Events that a scene declares: a quantity crosses a value, and the run records it or stops there."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene.base.attached import NO_ORIENTATION, Attached, AttachedPair, coordinate_complaints
from mbs_ref.scene.base.part import BodyName, Point

Crossing = Literal["either", "rising", "falling"]
Action = Literal["record", "stop"]


class CoordinateEvent(Attached):
    """A body's coordinate, or its rate, crosses a value; an angle is watched in the plane alone."""

    type: Literal["coordinate_event"] = "coordinate_event"
    body: BodyName
    coordinate: Literal["x", "y", "z", "angle"]  # of the centre of mass; the angle in the plane alone
    rate: bool = False  # watch the coordinate's rate instead
    value: float = 0.0  # m or rad; m/s or rad/s
    crossing: Crossing = "either"  # direction of the crossing
    action: Action = "record"  # what the run does

    def complaints(self, dimension: int) -> Iterator[str]:
        yield from coordinate_complaints(self.coordinate, dimension)

    def refuses_particle(self, end: str, dimension: int) -> str:
        return NO_ORIENTATION if self.coordinate == "angle" else ""


class DistanceEvent(AttachedPair):
    """The distance between two marks crosses a value."""

    type: Literal["distance_event"] = "distance_event"
    point_a: Point  # m, world, t = 0
    point_b: Point  # m, world, t = 0
    value: Annotated[float, Field(gt=0.0)]  # m
    crossing: Crossing = "either"  # direction of the crossing
    action: Action = "record"  # what the run does


Event = Annotated[CoordinateEvent | DistanceEvent, Field(discriminator="type")]
