"""Events that a scene declares: a quantity crosses a value, and the run records it or stops there."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene.part import Name, Part, Vector

Crossing = Literal["either", "rising", "falling"]
Action = Literal["record", "stop"]


class CoordinateEvent(Part):
    """A body's coordinate, or its rate, crosses a value."""

    type: Literal["coordinate_event"] = "coordinate_event"
    name: Name
    body: Name
    coordinate: Literal["x", "y", "angle"]
    rate: bool = False  # watch the coordinate's rate instead
    value: float = 0.0  # m or rad; m/s or rad/s
    crossing: Crossing = "either"
    action: Action = "record"


class DistanceEvent(Part):
    """The distance between two marks crosses a value."""

    type: Literal["distance_event"] = "distance_event"
    name: Name
    body_a: Name
    body_b: Name
    point_a: Vector  # m, world, t = 0
    point_b: Vector  # m, world, t = 0
    value: Annotated[float, Field(gt=0.0)]  # m
    crossing: Crossing = "either"
    action: Action = "record"


Event = Annotated[CoordinateEvent | DistanceEvent, Field(discriminator="type")]
