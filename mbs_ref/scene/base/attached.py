"""A part that acts on bodies: what joints, loads, contacts and events have in common."""

from collections.abc import Iterator
from functools import cache
from typing import Any, ClassVar

from mbs_ref.scene.base.part import EndName, Name, Part, Role, fields_of
from mbs_ref.scene.bodies import GROUND
from mbs_ref.scene.signals import AnySignal

NO_ORIENTATION = "and has no orientation; use a rigid body"


@cache
def _signal_fields(kind: type[Part]) -> tuple[str, ...]:
    """Return the fields of a kind of part that hold functions of time."""
    return tuple(name for name, field in kind.model_fields.items() if field.annotation == AnySignal)


def coordinate_complaints(coordinate: str, dimension: int, instead: str = "") -> Iterator[str]:
    """Yield what keeps a scene of this dimension from having the coordinate; `instead` advises on the angle."""
    if dimension == 2 and coordinate == "z":
        yield "coordinate = 'z' is for space alone"
    if dimension == 3 and coordinate == "angle":
        yield "coordinate = 'angle' is for the plane alone" + instead


class Attached(Part):
    """A named part that acts on bodies. Class attributes state the properties of its kind."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)  # of the scenes that may contain it
    COUNTERPART: ClassVar[str] = ""  # the type that does the same in the other dimension
    TURNS: ClassVar[bool] = False  # whether it acts on its bodies' orientation

    type: Any  # every kind names its own
    name: Name

    @property
    def ends(self) -> tuple[str, str]:
        """The two bodies it acts between; one that has a single body acts from ground."""
        fields = vars(self)  # quicker than hasattr, for which a model raises an exception
        return (fields["body_a"], fields["body_b"]) if "body_a" in fields else (GROUND, fields.get("body", GROUND))

    @property
    def signals(self) -> list[AnySignal]:
        """Its functions of time."""
        return [getattr(self, field) for field in _signal_fields(type(self))]

    def mark(self, end: str) -> tuple[float, ...] | None:
        """Return the world point (m, t = 0) of its attachment to the body named in the field `end`, if it has one."""
        fields, side = vars(self), end.removeprefix("body")
        for name in ("point" + side, "center" + side, "point", "center"):
            mark = fields.get(name)
            if mark is not None:
                return mark
        return None

    def vectors(self) -> Iterator[tuple[str, tuple[float, ...]]]:
        """Yield the fields that hold world vectors of the scene's dimension."""
        for field in fields_of(type(self), Role.WORLD_VECTOR):
            if getattr(self, field) is not None:
                yield field, getattr(self, field)

    def complaints(self, dimension: int) -> Iterator[str]:
        """Yield what is invalid in a scene of this dimension, beyond `DIMENSIONS` and the vectors' lengths."""
        yield from ()

    def refuses_particle(self, end: str, dimension: int) -> str:
        """Return why the body named in the field `end` may not be a point mass; empty where it may."""
        return NO_ORIENTATION if self.TURNS else ""


class AttachedPair(Attached):
    """A part between two bodies, or a body and ground."""

    body_a: EndName
    body_b: EndName
