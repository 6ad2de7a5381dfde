"""Contact parts -> the arrays of the planar contact groups."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from mbs_ref.cores.contact_arrays import contact_modes
from mbs_ref.cores.near_pairs import Ball, near_pairs
from mbs_ref.kernels.contact import laws as shared
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.scene import Scene, SpringDamper
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, PinOnSprocket
from mbs_ref.scene.events import CoordinateEvent, DistanceEvent

_COMPONENTS = {"x": 0, "y": 1, "angle": 2}
_CROSSINGS = {"either": 0, "rising": 1, "falling": -1}
_ENDS = {"line": shared.ENDS_NONE, "segment": shared.ENDS_OPEN, "capped": shared.ENDS_CAPPED}


class Places(Protocol):
    """What the builder knows of bodies."""

    def body(self, name: str) -> int: ...

    def local(self, name: str, point: tuple[float, ...]) -> np.ndarray: ...


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
        kind=arrays.PAIR_LINE,
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
        arrays.PAIR_CIRCLE, part.center_a, part.radius_a, part.center_b, (1.0, 0.0), part.radius_b
    )  # fmt: skip


def _sprocket(part: PinOnSprocket) -> _Shape:
    return _Shape(
        kind=arrays.PAIR_SPROCKET,
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
        return places.local(name, vector) - places.local(name, (0.0, 0.0))

    def points(rows: list[np.ndarray]) -> np.ndarray:
        return np.array(rows, dtype=float).reshape(len(rows), 2)

    return arrays.ContactPairs(
        kind=np.array([s.kind for s in shapes], dtype=np.int64),
        a=np.array([places.body(p.body_a) for p in parts], dtype=np.int64),
        b=np.array([places.body(p.body_b) for p in parts], dtype=np.int64),
        center=points([places.local(p.body_a, s.center) for p, s in zip(parts, shapes, strict=True)]),
        radius=np.array([s.radius for s in shapes], dtype=float),
        origin=points([places.local(p.body_b, s.origin) for p, s in zip(parts, shapes, strict=True)]),
        direction=points([turned(p.body_b, s.direction) for p, s in zip(parts, shapes, strict=True)]),
        half=np.array([s.half for s in shapes], dtype=float),
        ends=np.array([s.ends for s in shapes], dtype=np.int64),
        thickness=np.array([s.thickness for s in shapes], dtype=float),
        flank=points([np.array(s.flank) for s in shapes]),
    )


def event_sources(scene: Scene) -> list[str]:
    """Return what may have events, in the order of the modes: contacts, tension-only springs, declared events."""
    return [part.name for part in (*scene.contacts, *tension_only(scene), *scene.events)]


def tension_only(scene: Scene) -> list[SpringDamper]:
    """Return the springs that only pull, in the order of their modes."""
    return [load for load in scene.loads if isinstance(load, SpringDamper) and load.tension_only]


def watches(scene: Scene, places: Places) -> arrays.Watches:
    """Return the declared events."""
    pairs = [(e.body_a, e.body_b, e.point_a, e.point_b) if isinstance(e, DistanceEvent)
             else (e.body, "ground", None, None) for e in scene.events]  # fmt: skip

    def local(body: str, point: tuple[float, ...] | None) -> np.ndarray:
        return np.zeros(2) if point is None else places.local(body, point)

    return arrays.Watches(
        a=np.array([places.body(a) for a, _, _, _ in pairs], dtype=np.int64),
        b=np.array([places.body(b) for _, b, _, _ in pairs], dtype=np.int64),
        point_a=np.array([local(a, mark) for a, _, mark, _ in pairs], dtype=float).reshape(-1, 2),
        point_b=np.array([local(b, mark) for _, b, _, mark in pairs], dtype=float).reshape(-1, 2),
        quantity=np.array([_quantity(e) for e in scene.events], dtype=np.int64),
        component=np.array([_COMPONENTS[getattr(e, "coordinate", "x")] for e in scene.events], dtype=np.int64),
        value=np.array([e.value for e in scene.events], dtype=float),
        direction=np.array([_CROSSINGS[e.crossing] for e in scene.events], dtype=np.int64),
        stops=np.array([e.action == "stop" for e in scene.events], dtype=np.int64),
    )


def _quantity(event: DistanceEvent | CoordinateEvent) -> int:
    if isinstance(event, DistanceEvent):
        return arrays.WATCH_DISTANCE
    return arrays.WATCH_RATE if event.rate else arrays.WATCH_COORDINATE


def planar_modes(scene: Scene) -> shared.ContactModes:
    """Return the modes before a run has settled them: springs answer by the state until then."""
    modes = contact_modes(scene, len(event_sources(scene)))
    modes.mode[len(scene.contacts) : len(scene.contacts) + len(tension_only(scene))] = shared.MODE_PLAIN
    return modes


def contact_balls(pairs: arrays.ContactPairs) -> NearPairs:
    """Return what every pair's shapes lie in, and the list of near pairs."""
    return near_pairs([(_ball(pairs, k), _other_ball(pairs, k)) for k in range(len(pairs.kind))], 2)


def _ball(pairs: arrays.ContactPairs, k: int) -> Ball:
    radius = 0.0 if pairs.kind[k] == arrays.PAIR_SPROCKET else float(pairs.radius[k])  # a pin's is in its clearance
    return Ball(int(pairs.a[k]), tuple(pairs.center[k]), radius)


def _other_ball(pairs: arrays.ContactPairs, k: int) -> Ball | None:
    """Return None for a surface without ends or without a back, which reaches far below itself."""
    endless = pairs.ends[k] == shared.ENDS_NONE or math.isinf(pairs.thickness[k])
    if pairs.kind[k] == arrays.PAIR_LINE and endless:
        return None
    reach = float(pairs.half[k])
    if pairs.kind[k] == arrays.PAIR_SPROCKET:
        reach = (reach + float(pairs.thickness[k])) / math.cos(math.pi / pairs.ends[k])
    return Ball(int(pairs.b[k]), tuple(pairs.origin[k]), reach)
