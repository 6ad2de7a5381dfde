"""A part that acts on bodies: what joints, loads, contacts and events have in common."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from mbs_ref.scene.base.part import Name, Part, Role, fields_of
from mbs_ref.scene.bodies import GROUND
from mbs_ref.scene.signals import AnySignal

NO_ORIENTATION = "and has no orientation; use a rigid body"


class Attached(Part):
    """A named part that acts on bodies. What its kind is stands in the class and is asked everywhere else."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)  # of the scenes it may stand in
    COUNTERPART: ClassVar[str] = ""  # the type that does the same in the other dimension
    TURNS: ClassVar[bool] = False  # whether it acts on its bodies' orientation

    type: Any  # every kind names its own
    name: Name

    @property
    def ends(self) -> tuple[str, str]:
        """The two bodies it acts between; one that has a single body acts from ground."""
        parts: Any = self
        return (parts.body_a, parts.body_b) if hasattr(self, "body_a") else (GROUND, getattr(self, "body", GROUND))

    @property
    def signals(self) -> list[AnySignal]:
        """Its functions of time."""
        return [value for value in vars(self).values() if isinstance(value, AnySignal)]

    def mark(self, end: str) -> tuple[float, ...] | None:
        """Return the world point (m, t = 0) where it holds the body named in the field `end`, if it has one."""
        own = (getattr(self, kind + end.removeprefix("body"), None) for kind in ("point", "center"))
        shared = (getattr(self, kind, None) for kind in ("point", "center"))
        return next((mark for mark in (*own, *shared) if mark is not None), None)

    def vectors(self) -> Iterator[tuple[str, tuple[float, ...]]]:
        """Yield the fields that hold world vectors of the scene's dimension."""
        for field in fields_of(type(self), Role.WORLD_VECTOR):
            if getattr(self, field) is not None:
                yield field, getattr(self, field)

    def complaints(self, dimension: int) -> Iterator[str]:
        """Yield what makes no sense in a scene of this dimension, beyond `DIMENSIONS` and the vectors' lengths."""
        yield from ()

    def refuses_particle(self, end: str, dimension: int) -> str:
        """Return why the body named in the field `end` may not be a point mass; empty where it may."""
        return NO_ORIENTATION if self.TURNS else ""
