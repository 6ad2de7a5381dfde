"""A scene: bodies, joints, loads, contacts and events, checked as a whole."""

from collections import Counter
from collections.abc import Callable
from functools import wraps
from itertools import chain, islice
from typing import Any, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from mbs_ref.display import facts, listing
from mbs_ref.scene.base.attached import complaints
from mbs_ref.scene.base.part import Name, Part, Positive, Vector
from mbs_ref.scene.bodies import GROUND, Body, PointMass
from mbs_ref.scene.contact import Contact, granular_complaints
from mbs_ref.scene.events import Event
from mbs_ref.scene.joints import Joint
from mbs_ref.scene.loads import Load
from mbs_ref.scene.signals import breakpoints
from mbs_ref.trajectory import WORLDS, World

MOST_COMPLAINTS = 100  # about one scene at once: each may list the bodies, and there may be 100 000


class _OfBodies(NamedTuple):
    """Derived data of a scene's bodies."""

    bodies: tuple[Body, ...]
    dimension: int
    places: dict[str, int]  # by name; -1 for ground


def of_last_scene[T](make: Callable[["Scene"], T]) -> Callable[["Scene"], T]:
    """Return a function that remembers what it returned for the last scene; its result must not be changed."""
    last: tuple[Scene | None, Any] = (None, None)

    @wraps(make)
    def made(scene: "Scene") -> T:
        nonlocal last
        known, result = last
        if known is not scene:
            result = make(scene)
            last = scene, result
        return result

    return made


class Scene(Part):
    """Bodies, joints, loads and gravity, checked as a whole."""

    name: Name
    description: str = ""  # one sentence
    source: str = ""  # where the data come from
    duration: Positive = 1.0  # s, simulated time unless the settings give another
    gravity: Vector = (0.0, 0.0)  # m/s^2; in space, too, none unless given
    bodies: tuple[Body, ...] = Field(min_length=1, max_length=100_000)  # one at least
    joints: tuple[Joint, ...] = ()  # joints and drives
    loads: tuple[Load, ...] = ()  # forces, springs, gravity fields
    contacts: tuple[Contact, ...] = ()  # pairs of shapes that may touch
    events: tuple[Event, ...] = ()  # crossings to record or to stop at
    parameters: dict[str, float | int | str | bool] = {}  # what the scene was built with

    @model_validator(mode="after")
    def _check(self) -> Self:
        if "gravity" not in self.model_fields_set:
            vars(self)["gravity"] = (0.0,) * self.dimension
        attached = {"joints": self.joints, "loads": self.loads, "contacts": self.contacts, "events": self.events}
        general = complaints(self.dimension, self.gravity, self.bodies, attached)
        errors = list(islice(chain(general, granular_complaints(self.loads, self.bodies)), MOST_COMPLAINTS))
        if len(errors) == MOST_COMPLAINTS:
            errors.append("and perhaps more: the search ended here")
        if errors:
            raise ValueError("\n".join(errors))
        return self

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self._of_bodies.dimension

    @property
    def planar(self) -> bool:
        """Whether every body moves in the plane."""
        return self.dimension == 2

    @property
    def world(self) -> World:
        """What distinguishes motions of this dimension from others."""
        return WORLDS[self.dimension]

    @property
    def body_names(self) -> list[str]:
        return [body.name for body in self.bodies]

    def body_index(self, name: str) -> int:
        """Return the body's place in `bodies`; -1 for ground."""
        return self.places[name]

    @property
    def places(self) -> dict[str, int]:
        """The place in `bodies` of every body by its name; -1 for ground."""
        return self._of_bodies.places

    @property
    def _of_bodies(self) -> _OfBodies:
        """The derived data, cached while `bodies` is the same tuple; a copy may have another."""
        cache: dict[str, Any] = vars(self)
        data: _OfBodies | None = cache.get("_cached_of_bodies")
        if data is None or data.bodies is not self.bodies:
            places = {body.name: k for k, body in enumerate(self.bodies)} | {GROUND: -1}
            data = _OfBodies(self.bodies, max(len(body.position) for body in self.bodies), places)
            cache["_cached_of_bodies"] = data
        return data

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        parts = (*self.bodies, *self.joints, *self.loads, *self.contacts, *self.events)
        kinds = Counter(part.type.replace("_", " ") for part in parts)
        made_of = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        table = facts(self.name, [
            ("about", self.description), ("source", self.source), ("made of", made_of), ("gravity, m/s²", self.gravity),
            ("duration, s", self.duration), ("parameters", self.parameters),
        ])  # fmt: skip
        rows = [(body.name, body.mass, body.position) for body in self.bodies]
        return table + listing("Bodies", ("name", "mass, kg", "centre of mass at t = 0, m"), rows)

    @of_last_scene
    def breakpoints(self) -> tuple[float, ...]:
        """Return the sorted times (s) at which a declared signal may be non-smooth."""
        parts = (*self.loads, *self.joints)
        return tuple(sorted({t for part in parts for signal in part.signals for t in breakpoints(signal)}))


def with_rates(scene: Scene, rates: np.ndarray) -> Scene:
    """Return the scene with its bodies' velocities and angular velocities, 3 a body in the plane and 6 in space.

    `rates` are in m/s and rad/s, one body after the other; those that would turn a point mass are ignored.
    """
    bodies = []
    for body, own in zip(scene.bodies, rates.reshape(len(scene.bodies), -1), strict=True):
        straight, turning = len(body.velocity), own[len(body.velocity) :]
        update: dict[str, Any] = {"velocity": tuple(own[:straight].tolist())}
        if not isinstance(body, PointMass):
            update["angular_velocity"] = float(turning[0]) if len(turning) == 1 else tuple(turning.tolist())
        bodies.append(body.model_copy(update=update))
    return scene.model_copy(update={"bodies": tuple(bodies)})
