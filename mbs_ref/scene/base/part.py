"""The base of every part of a scene, frozen, validated, SI, unknown fields refused; and its directions."""

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo


class Part(BaseModel):
    """Frozen data. Unknown fields, NaN and infinities are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=False)


class Role(Enum):
    """What a field means to a scene as a whole."""

    WORLD_VECTOR = "as many components as the scene has dimensions"
    POINT = "a world point at t = 0, m"
    DIRECTION = "a world direction at t = 0, of any length but zero"
    BODY = "the name of a body"
    END = "the name of a body, or ground"


class OnlyWith(NamedTuple):
    """Marks a parameter of a scene's builder that only one value of another parameter has."""

    parameter: str
    value: str


BELIEVABLE_ONLY = OnlyWith("model", "believable")


def of_paper(paper: dict[str, Any], given: Mapping[str, Any], believable: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the papers' bare model; ValueError for one that is given and that it does not have."""
    for name, bare in paper.items():
        if given[name] not in (bare, believable[name]):
            raise ValueError(f"{name} = {given[name]!r} does not go with model = 'paper', which has {bare!r}")
    return paper


def _directed(value: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
    if not math.hypot(*value) > 0.0:  # neither overflows nor underflows
        raise ValueError(f"{info.field_name} = {value} has no direction; give any vector but zero")
    return value


def limited(value: float) -> float:
    """Return the value; ValueError where its square may overflow."""
    if value > LARGEST:
        raise ValueError(f"{value:g} is too large; allowed: up to {LARGEST:g}")
    return value


LARGEST = 1e150  # the square of a larger number may overflow
Positive = Annotated[float, Field(gt=0.0), AfterValidator(limited)]
NonNegative = Annotated[float, Field(ge=0.0), AfterValidator(limited)]
Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z][A-Za-z0-9_.\-]*$")]
BodyName = Annotated[Name, Role.BODY]
EndName = Annotated[Name, Role.END]
Vector = Annotated[tuple[float, ...], Field(min_length=2, max_length=3), Role.WORLD_VECTOR]
Vector3 = tuple[float, float, float]
Point = Annotated[Vector, Role.POINT]
Point3 = Annotated[Vector3, Role.POINT]
Direction = Annotated[Vector, AfterValidator(_directed), Role.DIRECTION]
Direction3 = Annotated[Vector3, AfterValidator(_directed), Role.DIRECTION]
SixNonNegative = tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative]


@cache
def fields_of(kind: type[Part], role: Role) -> tuple[str, ...]:
    """Return the fields of a kind of part that have a role, whether or not they may also be None."""
    return tuple(name for name, field in kind.model_fields.items() if role in _metadata(field))


def _metadata(field) -> list:
    alternatives = [entry for option in get_args(field.annotation) for entry in getattr(option, "__metadata__", ())]
    return [*field.metadata, *alternatives]


def is_place(kind: type[Part], name: str) -> bool:
    """Return whether a field of a kind of part holds a point or a direction, or a body's pose at the start."""
    known = _metadata(kind.model_fields[name])
    return Role.POINT in known or AfterValidator(_directed) in known or name in ("position", "angle", "orientation")


def require_perpendicular(name: str, first: Sequence[float], other_name: str, second: Sequence[float]) -> None:
    cosine = math.sumprod(first, second) / math.hypot(*first) / math.hypot(*second)
    if not abs(cosine) <= 1e-9:
        pair = f"{name} = {first} and {other_name} = {second}"
        raise ValueError(f"{pair} must be perpendicular; their cosine is {cosine:.3g}")


def unit(vector: Any) -> np.ndarray:
    """Return the vector at length one."""
    vector = np.asarray(vector, dtype=float)
    return vector / math.hypot(*vector)


def dot(first: Any, second: Any) -> Any:
    """Return the sum of products along the last axis: to the same bits on every processor, which BLAS does not give."""
    return np.sum(np.multiply(first, second), axis=-1)


def cross(first: Any, second: Any) -> np.ndarray:
    """Return the cross product of two vectors (3,), in a tenth of the time of NumPy's."""
    (a, b, c), (x, y, z) = first, second
    return np.array((b * z - c * y, c * x - a * z, a * y - b * x))


def normals(axis: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that make a right-handed frame with the axis (3,), axis last."""
    axis = unit(axis)
    first = unit(cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis))
    return first, cross(axis, first)
