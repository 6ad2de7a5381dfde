"""Directions: whether two are perpendicular, unit vectors, and the normals of an axis."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np


def require_perpendicular(name: str, first: Sequence[float], other_name: str, second: Sequence[float]) -> None:
    cosine = math.sumprod(first, second) / math.hypot(*first) / math.hypot(*second)
    if not abs(cosine) <= 1e-9:
        pair = f"{name} = {first} and {other_name} = {second}"
        raise ValueError(f"{pair} must be perpendicular; their cosine is {cosine:.3g}")


def unit(vector: Any) -> np.ndarray:
    """Return the vector at length one."""
    vector = np.asarray(vector, dtype=float)
    return vector / math.hypot(*vector)


def normals(axis: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that make a right-handed frame with the axis (3,), axis last."""
    axis = unit(axis)
    first = unit(np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis))
    return first, np.cross(axis, first)
