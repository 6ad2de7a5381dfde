"""Contact parts -> the arrays of the planar contact groups."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.cores.event_arrays import Places
from mbs_ref.cores.near_pairs import Ball, near_pairs
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, PinOnSprocket

_ENDS = {"line": shared.ENDS_NONE, "segment": shared.ENDS_OPEN, "capped": shared.ENDS_CAPPED}


@dataclass(frozen=True)
class _Shape:
    """One row of ContactPairs, with the marks in world axes at t = 0."""

    kind: int
    center: tuple[float, ...]
    radius: float
    origin: tuple[float, ...]
    direction: tuple[float, ...]
    half: float
    ends: int = 0
    thickness: float = math.inf
    flank: tuple[float, float] = (1.0, 0.0)


def _line(part: CircleOnLine) -> _Shape:
    first, second = np.array(part.point_1), np.array(part.point_2)
    length = float(np.linalg.norm(second - first))
    return _Shape(
        kind=shared.PAIR_FLAT,
        center=part.center,
        radius=part.radius,
        origin=tuple(0.5 * (first + second)),
        direction=tuple((second - first) / length),
        half=0.5 * length,
        ends=_ENDS[part.extent],
        thickness=math.inf if part.thickness is None else part.thickness,
    )


def _circle(part: CircleOnCircle) -> _Shape:
    return _Shape(
        shared.PAIR_ROUND, part.center_a, part.radius_a, part.center_b, (1.0, 0.0), part.radius_b
    )  # fmt: skip


def _sprocket(part: PinOnSprocket) -> _Shape:
    return _Shape(
        kind=shared.PAIR_SPROCKET,
        center=part.center,
        radius=part.clearance,
        origin=part.axle,
        direction=(math.cos(part.first_seat), math.sin(part.first_seat)),
        half=part.pitch_radius,
        ends=part.teeth,
        thickness=part.addendum_radius - part.pitch_radius,
        flank=(math.cos(part.flank_angle), math.sin(part.flank_angle)),
    )


_SHAPES: dict[type, Any] = {CircleOnLine: _line, CircleOnCircle: _circle, PinOnSprocket: _sprocket}


def contact_pairs(scene: Scene, places: Places) -> arrays.ContactPairs:
    """Return the shapes in body axes."""
    parts = scene.contacts
    shapes: list[_Shape] = [_SHAPES[type(part)](part) for part in parts]

    def turned(name: str, vector: tuple[float, ...]) -> np.ndarray:
        return places.point(name, vector) - places.point(name, (0.0, 0.0))

    def points(rows: list[np.ndarray]) -> np.ndarray:
        return np.array(rows, dtype=float).reshape(len(rows), 2)

    return arrays.ContactPairs(
        kind=np.array([s.kind for s in shapes], dtype=np.int64),
        a=np.array([places.body(p.body_a) for p in parts], dtype=np.int64),
        b=np.array([places.body(p.body_b) for p in parts], dtype=np.int64),
        center=points([places.point(p.body_a, s.center) for p, s in zip(parts, shapes, strict=True)]),
        radius=np.array([s.radius for s in shapes], dtype=float),
        origin=points([places.point(p.body_b, s.origin) for p, s in zip(parts, shapes, strict=True)]),
        direction=points([turned(p.body_b, s.direction) for p, s in zip(parts, shapes, strict=True)]),
        half=np.array([s.half for s in shapes], dtype=float),
        ends=np.array([s.ends for s in shapes], dtype=np.int64),
        thickness=np.array([s.thickness for s in shapes], dtype=float),
        flank=points([np.array(s.flank) for s in shapes]),
    )


def contact_balls(pairs: arrays.ContactPairs) -> NearPairs:
    """Return what every pair's shapes lie in, and the list of near pairs."""
    return near_pairs([(_ball(pairs, k), _other_ball(pairs, k)) for k in range(len(pairs.kind))], 2)


def _ball(pairs: arrays.ContactPairs, k: int) -> Ball:
    radius = 0.0 if pairs.kind[k] == shared.PAIR_SPROCKET else float(pairs.radius[k])  # a pin's is in its clearance
    return Ball(int(pairs.a[k]), tuple(pairs.center[k]), radius)


def _other_ball(pairs: arrays.ContactPairs, k: int) -> Ball | None:
    """Return None for a surface without ends or without a back, which reaches far below itself."""
    endless = pairs.ends[k] == shared.ENDS_NONE or math.isinf(pairs.thickness[k])
    if pairs.kind[k] == shared.PAIR_FLAT and endless:
        return None
    reach = float(pairs.half[k])
    if pairs.kind[k] == shared.PAIR_SPROCKET:
        reach = (reach + float(pairs.thickness[k])) / math.cos(math.pi / pairs.ends[k])
    return Ball(int(pairs.b[k]), tuple(pairs.origin[k]), reach)
