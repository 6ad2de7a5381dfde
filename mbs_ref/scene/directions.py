"""Directions that a part is given: neither zero nor askew."""

from __future__ import annotations

import math

from mbs_ref.scene.part import Vector3


def require_direction(field: str, value: tuple[float, ...]) -> None:
    if not math.hypot(*value) > 0.0:  # neither overflows nor underflows
        raise ValueError(f"{field} = {value} has no direction; give any vector but zero")


def require_perpendicular(name: str, first: Vector3, other_name: str, second: Vector3) -> None:
    require_direction(name, first)
    require_direction(other_name, second)
    cosine = math.sumprod(first, second) / math.hypot(*first) / math.hypot(*second)
    if not abs(cosine) <= 1e-9:
        pair = f"{name} = {first} and {other_name} = {second}"
        raise ValueError(f"{pair} must be perpendicular; their cosine is {cosine:.3g}")
