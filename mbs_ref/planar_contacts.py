"""Contact parts -> the arrays of the planar contact groups."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from mbs_ref.contact import (
    CircleOnCircle,
    CircleOnLine,
    ConstraintLaw,
    FloresLaw,
    HuntCrossleyLaw,
    LankaraniNikraveshLaw,
    PinOnSprocket,
    ProgressiveLaw,
    RegularisedCoulomb,
    RigidLaw,
    SpringDamperLaw,
    StickSlip,
)
from mbs_ref.kernels.planar import model as arrays
from mbs_ref.scene import Scene, SpringDamper
from mbs_ref.scene_events import CoordinateEvent, DistanceEvent

NOISE = 1e-13  # of the scene's size in metres (at least 1 m): above what roundoff and projection leave of a gap
MOST_LOGGED = 100_000  # events of one run whose modes are kept for output
_COMPONENTS = {"x": 0, "y": 1, "angle": 2}
_CROSSINGS = {"either": 0, "rising": 1, "falling": -1}
_ENDS = {"line": arrays.ENDS_NONE, "segment": arrays.ENDS_OPEN, "capped": arrays.ENDS_CAPPED}


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


@dataclass(frozen=True)
class _Law:
    """One row of ContactLaws without friction."""

    stiffness: float = 0.0
    damping: float = 0.0
    exponent: float = 1.0
    damping_exponent: float = 0.0
    impact_damping: float = 0.0
    slowest: float = 1.0
    release: int = arrays.RELEASE_GAP
    restitution: float = 0.0


def _spring_damper(law: SpringDamperLaw) -> _Law:
    release = arrays.RELEASE_FORCE if law.release == "force" else arrays.RELEASE_GAP
    return _Law(law.stiffness, law.damping, release=release)


def _by_impact_speed(law: Any, factor: float) -> _Law:
    return _Law(law.stiffness, 0.0, law.exponent, law.exponent, factor, law.slowest)


_LAWS: dict[type, Any] = {
    SpringDamperLaw: _spring_damper,
    ProgressiveLaw: lambda law: _Law(law.stiffness, law.damping, 1.0, 1.0),
    HuntCrossleyLaw: lambda law: _Law(law.stiffness, law.damping, law.exponent, law.exponent),
    LankaraniNikraveshLaw: lambda law: _by_impact_speed(law, 0.75 * (1.0 - law.restitution**2)),
    FloresLaw: lambda law: _by_impact_speed(law, 1.6 * (1.0 - law.restitution) / law.restitution),
    RigidLaw: lambda law: _Law(release=arrays.RELEASE_RIGID, restitution=law.restitution),
    ConstraintLaw: lambda law: _Law(release=arrays.RELEASE_CONSTRAINT),
}
_FRICTIONS: dict[type, int] = {
    type(None): arrays.FRICTION_NONE,
    RegularisedCoulomb: arrays.FRICTION_SMOOTH,
    StickSlip: arrays.FRICTION_STICK_SLIP,
}


def contact_laws(scene: Scene, slots: dict[int, int]) -> arrays.ContactLaws:
    """Return the laws and frictions; `slots` holds the row of each constraint contact, by its place."""
    laws: list[_Law] = [_LAWS[type(part.law)](part.law) for part in scene.contacts]
    frictions: list[Any] = [part.friction for part in scene.contacts]

    def of_law(field: str) -> np.ndarray:
        return np.array([getattr(law, field) for law in laws], dtype=np.int64 if field == "release" else float)

    def of_friction(field: str, default: float = 0.0) -> np.ndarray:
        values = [getattr(friction, field, default) for friction in frictions]
        return np.array([default if value is None else value for value in values], dtype=float)

    sticking = [isinstance(friction, StickSlip) for friction in frictions]
    static = [f.coefficient if s and f.static is None else getattr(f, "static", 0.0) for f, s in
              zip(frictions, sticking, strict=True)]  # fmt: skip
    return arrays.ContactLaws(
        **{name: of_law(name) for name in _Law.__dataclass_fields__},
        friction=np.array([_FRICTIONS[type(friction)] for friction in frictions], dtype=np.int64),
        coefficient=of_friction("coefficient"),
        static=np.array(static, dtype=float),
        creep=of_friction("speed", 1.0),
        grip_stiffness=of_friction("stiffness"),
        grip_damping=of_friction("damping"),
        slot=np.array([slots.get(k, -1) for k in range(len(laws))], dtype=np.int64),
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


def contact_modes(scene: Scene) -> arrays.ContactModes:
    """Return the modes before a run has settled them: springs answer by the state until then."""
    count, springs = len(event_sources(scene)), len(tension_only(scene))
    integers = [np.zeros(count, dtype=np.int64) for _ in range(3)]
    integers[0][len(scene.contacts) : len(scene.contacts) + springs] = arrays.MODE_PLAIN
    floats = [np.zeros(count) for _ in range(3)]
    return arrays.ContactModes(
        mode=integers[0],
        grip=integers[1],
        anchor=floats[0],
        dashpot=floats[1],
        stamp=floats[2],
        burst=integers[2],
        roots=np.zeros(1, dtype=np.int64),
        noise=np.array([NOISE * max([1.0, *(abs(x) for body in scene.bodies for x in body.position)])]),
        log=np.zeros((MOST_LOGGED if count else 0, 6)),
        logged=np.zeros(1, dtype=np.int64),
    )
