"""The base of every part of a scene: frozen, validated, SI, unknown fields refused."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Part(BaseModel):
    """Frozen data. Unknown fields, NaN and infinities are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=False)


Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z][A-Za-z0-9_.\-]*$")]
Vector = Annotated[tuple[float, ...], Field(min_length=2, max_length=3)]  # 2 components in the plane, 3 in space
Vector3 = tuple[float, float, float]
SixNonNegative = tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative]
