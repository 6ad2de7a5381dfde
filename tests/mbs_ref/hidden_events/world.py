"""What a scene of hidden events consists of, without units: its size and duration are about 1.

Vectors have three components; in the plane the third is 0 and bodies turn about the third axis. Rotational inertia is a
sphere's, so that every free body turns uniformly about a fixed axis.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

GROUND = "ground"
NOTHING = np.zeros(3)
THIRD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Body:
    """A body at t = 0, axes along the world's; a driven one has x = place + amplitude sin(omega t + phase) alone."""

    name: str
    mass: float
    inertia: float  # about the centre of mass, about every axis
    place: np.ndarray  # of the centre of mass of a free body, of a hinge's point
    velocity: np.ndarray = field(default_factory=lambda: NOTHING)
    spin: np.ndarray = field(default_factory=lambda: NOTHING)
    kind: Literal["free", "point", "hinged", "driven"] = "free"
    offset: np.ndarray = field(default_factory=lambda: NOTHING)  # of the centre of mass from `place`
    axis: np.ndarray = field(default_factory=lambda: THIRD)  # of a hinge


@dataclass(frozen=True)
class Mark:
    """A point of a body by its distance from the body's place, or a world point of ground."""

    body: str
    arm: np.ndarray


@dataclass(frozen=True)
class Contact:
    """Two spheres, or a sphere and a plane with its normal; without a restitution its force is below roundoff.

    A plate is a plane that extends by `half` from mark b along each of its edges.
    """

    name: str
    a: Mark
    b: Mark
    radius_a: float
    radius_b: float = 0.0
    normal: np.ndarray | None = None
    restitution: float | None = None
    law: str = "spring_damper_law"
    edges: tuple[np.ndarray, ...] = ()
    half: float = 0.0
    thickness: float | None = None
    hold: float = 0.0  # how long a stiff spring's contact lasts: half a period

    @property
    def impulsive(self) -> bool:
        """Whether it acts in an instant."""
        return self.restitution is not None

    @property
    def acts(self) -> bool:
        """Whether it changes the motion."""
        return self.impulsive or self.hold > 0.0


@dataclass(frozen=True)
class Length:
    """The distance of two marks crosses a value: a string, or a declared event.

    Without `hold` a string's force is below roundoff. With it the body of mark a, a sphere without gravity, meets
    ground along the line of both marks: half a period later it flies back.
    """

    name: str
    a: Mark
    b: Mark
    value: float
    declared: bool = False
    crossing: Literal["either", "rising", "falling"] = "either"
    hold: float = 0.0  # how long a stiff string is taut: half a period
    impulsive = False

    @property
    def acts(self) -> bool:
        """Whether it changes the motion."""
        return self.hold > 0.0


@dataclass(frozen=True)
class Level:
    """A declared event: a coordinate (3 is the angle) of a body's centre of mass, or its rate, crosses a value."""

    name: str
    body: str
    coordinate: int
    rate: bool
    value: float
    crossing: Literal["either", "rising", "falling"] = "either"
    impulsive = False
    acts = False


Watch = Contact | Length | Level


@dataclass(frozen=True)
class World:
    """Bodies, what is watched, and until when."""

    dimension: int
    bodies: tuple[Body, ...]
    watches: tuple[Watch, ...]
    gravity: np.ndarray = field(default_factory=lambda: NOTHING)
    horizon: float = 1.0

    @property
    def extent(self) -> float:
        """The diagonal of the box around all bodies and marks at t = 0, at least 1: runs count their errors in it."""
        places = {GROUND: NOTHING} | {body.name: body.place for body in self.bodies}
        marks = [mark for watch in self.watches if not isinstance(watch, Level) for mark in (watch.a, watch.b)]
        points = [body.place for body in self.bodies] + [places[mark.body] + mark.arm for mark in marks]
        return max(1.0, float(np.linalg.norm(np.ptp(points, axis=0))))

    def placed(self, turn: np.ndarray, shift: np.ndarray) -> World:
        """Return the world turned by a rotation matrix (3, 3) and then moved; levels keep their axes."""

        def mark(old: Mark) -> Mark:
            return replace(old, arm=turn @ old.arm + (shift if old.body == GROUND else 0.0))

        def watch(old: Watch) -> Watch:
            if isinstance(old, Level):
                return old
            moved = replace(old, a=mark(old.a), b=mark(old.b))
            if isinstance(moved, Length) or moved.normal is None:
                return moved
            return replace(moved, normal=turn @ moved.normal, edges=tuple(turn @ edge for edge in moved.edges))

        bodies = tuple(
            replace(
                body, place=turn @ body.place + shift, velocity=turn @ body.velocity, spin=turn @ body.spin,
                offset=turn @ body.offset, axis=turn @ body.axis,
            )
            for body in self.bodies
        )  # fmt: skip
        watches = tuple(watch(each) for each in self.watches)
        return replace(self, bodies=bodies, watches=watches, gravity=turn @ self.gravity)
