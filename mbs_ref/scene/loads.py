"""The loads of a scene: forces, torques, springs, bushings and a user's own force."""

from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, SkipValidation, model_validator

from mbs_ref.scene.base import part
from mbs_ref.scene.base.attached import Attached, AttachedPair
from mbs_ref.scene.base.part import require_perpendicular
from mbs_ref.scene.celestial import CelestialLoad
from mbs_ref.scene.contact import Granules
from mbs_ref.scene.joints import axis_complaints
from mbs_ref.scene.signals import Constant, Signal


class Force(Attached):
    """A force at a point of a body: vector times a signal, along fixed world or body axes."""

    type: Literal["force"] = "force"
    body: part.BodyName
    point: part.Point  # m, world, t = 0
    vector: part.Vector  # N
    frame: Literal["world", "body"] = "world"  # axes of the vector
    factor: Signal = Constant()  # times the load


class Torque(Attached):
    """A torque on a planar body times a signal."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2,)
    COUNTERPART: ClassVar[str] = "torque_vector"
    TURNS: ClassVar[bool] = True

    type: Literal["torque"] = "torque"
    body: part.BodyName
    torque: float  # N m
    factor: Signal = Constant()  # times the load


class TorqueVector(Attached):
    """A torque on a spatial body: vector times a signal, along fixed world or body axes."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    COUNTERPART: ClassVar[str] = "torque"
    TURNS: ClassVar[bool] = True

    type: Literal["torque_vector"] = "torque_vector"
    body: part.BodyName
    vector: part.Vector3  # N m
    frame: Literal["world", "body"] = "world"  # axes of the vector
    factor: Signal = Constant()  # times the load


class SpringDamper(AttachedPair):
    """A point-to-point spring and damper: F = k (l - l0) + c dl/dt, optionally in tension only.

    `limit` caps the pull, as a belt's load limiter does. It has no memory: what it pays out it winds up again, so that
    the spring returns what it would have stored at the limited force.
    """

    type: Literal["spring_damper"] = "spring_damper"
    point_a: part.Point  # m, world, t = 0
    point_b: part.Point  # m, world, t = 0
    stiffness: part.NonNegative  # N/m
    damping: part.NonNegative = 0.0  # N s/m
    rest_length: part.NonNegative | None = None  # m; the distance at t = 0 unless given
    tension_only: bool = False  # slack below the rest length, and never pushing
    limit: part.Positive | None = None  # N, the largest pull, of a spring that pulls only; none unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.limit is not None and not self.tension_only:
            raise ValueError(f"limit = {self.limit} N requires tension_only = true")
        return self


class TorsionSpring(AttachedPair):
    """A rotational spring and damper on the relative angle of two bodies.

    In space the angle is that of body b about `axis`, fixed in body a, counted from t = 0; it goes with a
    joint that keeps the axis. Beyond 3 rad either way a spatial spring stops the run: it cannot count turns.
    """

    TURNS: ClassVar[bool] = True

    type: Literal["torsion_spring"] = "torsion_spring"
    stiffness: part.NonNegative  # N m/rad
    damping: part.NonNegative = 0.0  # N m s/rad
    rest_angle: float | None = None  # rad, of b relative to a; the initial one unless given
    axis: part.Direction | None = None  # direction, world, t = 0; required in space, forbidden in the plane

    def complaints(self, dimension: int) -> Iterator[str]:
        yield from axis_complaints(self.type, self.axis, dimension)


class Bushing(AttachedPair):
    """Six springs and dampers between a mark on each of two bodies, along axes fixed in body a (space).

    Stiffness and damping are for the offset along x, y, z and the rotation vector about x, y, z of the bushing's
    axes. The marks coincide at t = 0, and nothing is strained, unless body b's point or axes are given. Beyond 3 rad of
    relative rotation it stops the run.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    TURNS: ClassVar[bool] = True

    type: Literal["bushing"] = "bushing"
    point: part.Point3  # m, world, t = 0, of the mark on body a
    stiffness: part.SixNonNegative  # N/m, N m/rad
    damping: part.SixNonNegative = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # N s/m, N m s/rad
    x_axis: part.Direction3 = (1.0, 0.0, 0.0)  # direction, world, t = 0
    y_axis: part.Direction3 = (0.0, 1.0, 0.0)  # direction, world, t = 0; perpendicular to x_axis
    point_b: part.Point3 | None = None  # m, world, t = 0, of the mark on body b; `point` unless given
    x_axis_b: part.Direction3 | None = None  # direction, world, t = 0, on body b; x_axis unless given
    y_axis_b: part.Direction3 | None = None  # direction, world, t = 0, on body b; y_axis unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_perpendicular("x_axis", self.x_axis, "y_axis", self.y_axis)
        x, y = self.x_axis_b or self.x_axis, self.y_axis_b or self.y_axis
        require_perpendicular("x_axis_b", x, "y_axis_b", y)
        return self

    @property
    def frames(self) -> tuple[np.ndarray, np.ndarray]:
        """The axes (3, 3) of both marks as columns, world, t = 0."""
        own = part.unit(self.x_axis), part.unit(self.y_axis)
        far = part.unit(self.x_axis_b or self.x_axis), part.unit(self.y_axis_b or self.y_axis)
        return np.column_stack((*own, part.cross(*own))), np.column_stack((*far, part.cross(*far)))


class PointBushing(AttachedPair):
    """An isotropic spring and damper between two marks: F = k e + c de/dt, e their gap (plane).

    The marks coincide at t = 0 unless point_b is given. Both forces act at body b's mark, so there is no couple:
    momentum is conserved, and the damper only dissipates. Body a bears their arm, so it may not be a point mass.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2,)

    type: Literal["point_bushing"] = "point_bushing"
    point: part.Point  # m, world, t = 0, of the mark on body a
    point_b: part.Point | None = None  # m, world, t = 0, of the mark on body b; `point` unless given
    stiffness: part.NonNegative  # N/m
    damping: part.NonNegative = 0.0  # N s/m

    def refuses_particle(self, end: str, dimension: int) -> str:
        return "and cannot bear the bushing's couple; let it be body_b" if end == "body_a" else ""


class UserForce(Attached):
    """A user's own force law, called as function(t, q, v) -> generalized forces.

    q, v and the result have shape (n_bodies, 3) in the scene's body order: m, m, rad; N, N, N m. In space
    q is (n_bodies, 7): m and Euler parameters, v and the result (n_bodies, 6): m/s, rad/s; N, N m, world axes,
    about the centre of mass. A Python function is slow, and cannot be written to TOML.
    """

    type: Literal["user_force"] = "user_force"
    function: Annotated[Callable[..., Any], SkipValidation]


Load = Annotated[
    Force | Torque | TorqueVector | SpringDamper | TorsionSpring | Bushing | PointBushing | Granules
    | UserForce | CelestialLoad,
    Field(discriminator="type"),
]  # fmt: skip
