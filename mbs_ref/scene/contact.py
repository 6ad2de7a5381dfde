"""Contact parts of a scene: what touches what, by which law, with which friction.

The penetration d is positive inside; d' is its rate. Every law is a type of its own and names the rule
by which it lets go. Points are world points at t = 0.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from mbs_ref.scene.part import Name, NonNegative, Part, Positive, Vector

Vector3 = tuple[float, float, float]
Restitution = Annotated[float, Field(ge=0.0, le=1.0)]


# --- laws -----------------------------------------------------------------------------------------


class SpringDamperLaw(Part):
    """F = k d + c d' (Fox 1999 eq 18, Fox 2001 eq 28): jumps by c v0 at touch-down.

    release "gap" lets go at d = 0 and pulls shortly before; "force" lets go where F = 0 and never pulls.
    """

    type: Literal["spring_damper_law"] = "spring_damper_law"
    stiffness: Positive  # N/m
    damping: NonNegative = 0.0  # N s/m
    release: Literal["gap", "force"] = "gap"


class ProgressiveLaw(Part):
    """F = k d + c d d' (Fox 1999 eq 33, Fox 2001 eq 34): continuous with a kink; lets go at d = 0, where F = 0."""

    type: Literal["progressive_law"] = "progressive_law"
    stiffness: Positive  # N/m
    damping: NonNegative = 0.0  # N s/m^2


class HuntCrossleyLaw(Part):
    """F = d^n (k + c d') (Hunt and Crossley 1975); lets go at d = 0, where F = 0."""

    type: Literal["hunt_crossley_law"] = "hunt_crossley_law"
    stiffness: Positive  # N/m^n
    damping: NonNegative = 0.0  # N s/m^(n + 1)
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5


class LankaraniNikraveshLaw(Part):
    """F = k d^n (1 + 3 (1 - e^2)/4 d'/v0), v0 the speed at touch-down (Lankarani and Nikravesh 1990).

    Lets go at d = 0, where F = 0. e is nominal: the law returns another restitution.
    """

    type: Literal["lankarani_nikravesh_law"] = "lankarani_nikravesh_law"
    stiffness: Positive  # N/m^n
    restitution: Restitution
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5
    slowest: Positive = 1e-3  # m/s, v0 is taken no smaller: a contact made at rest has no impact speed


class FloresLaw(Part):
    """F = k d^n (1 + 8 (1 - e)/(5 e) d'/v0), v0 the speed at touch-down (Flores et al. 2011).

    Lets go at d = 0, where F = 0. e is nominal: the law returns another restitution.
    """

    type: Literal["flores_law"] = "flores_law"
    stiffness: Positive  # N/m^n
    restitution: Annotated[float, Field(gt=0.0, le=1.0)]
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5
    slowest: Positive = 1e-3  # m/s, v0 is taken no smaller


class RigidLaw(Part):
    """No penetration: at touch-down an impulse reverses the normal speed, v+ = -e v- (Newton)."""

    type: Literal["rigid_law"] = "rigid_law"
    restitution: Restitution


class ConstraintLaw(Part):
    """No penetration and no rebound: while contact lasts the constraint gap = 0 stands for the force.

    The papers' other cure (Fox 2001). At touch-down an impulse takes the approach speed away (restitution 0);
    the contact lets go where the multiplier would pull. Circles on lines and circles alone, without friction.
    """

    type: Literal["constraint_law"] = "constraint_law"


ContactLaw = Annotated[
    SpringDamperLaw
    | ProgressiveLaw
    | HuntCrossleyLaw
    | LankaraniNikraveshLaw
    | FloresLaw
    | RigidLaw
    | ConstraintLaw,
    Field(discriminator="type"),
]


# --- friction -------------------------------------------------------------------------------------


class RegularisedCoulomb(Part):
    """F_t = -mu F_n tanh(v_t / v_s): smooth, and creeps where Coulomb's law would stick."""

    type: Literal["regularised_coulomb"] = "regularised_coulomb"
    coefficient: NonNegative
    speed: Positive = 1e-3  # m/s, v_s


class StickSlip(Part):
    """Coulomb's law with located transitions: F_t = -mu F_n sign(v_t), or a stiff spring while it sticks.

    Sticks where the tangential force needed is within mu_s F_n, and slips where it is not.
    """

    type: Literal["stick_slip"] = "stick_slip"
    coefficient: NonNegative  # mu
    static: NonNegative | None = None  # mu_s; mu unless given
    stiffness: Positive  # N/m, of the sticking contact
    damping: NonNegative = 0.0  # N s/m, of the sticking contact

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.static is not None and self.static < self.coefficient:
            raise ValueError(f"static = {self.static} must not be below coefficient = {self.coefficient}")
        return self


Friction = Annotated[RegularisedCoulomb | StickSlip, Field(discriminator="type")]


def _require_radius(radius_a: float, radius_b: float) -> None:
    if radius_a + radius_b == 0.0:
        raise ValueError("radius_a and radius_b are both 0; one must be positive")


def _no_friction_on_a_constraint(law: Any, friction: Any) -> None:
    if isinstance(law, ConstraintLaw) and friction is not None:
        raise ValueError(f"friction = {friction.type} does not go with constraint_law; leave it out")


# --- pairs ----------------------------------------------------------------------------------------


class CircleOnLine(Part):
    """A circle on one body against a straight surface on another or on ground; a radius of 0 is a corner.

    Walking from point_1 to point_2 the free side is on the left. `extent`: "line" has no ends, "segment"
    touches only where the circle's centre is between the ends, "capped" has solid end points too.
    """

    type: Literal["circle_on_line"] = "circle_on_line"
    name: Name
    body_a: Name  # carries the circle
    center: Vector  # m, world, t = 0
    radius: NonNegative  # m
    body_b: Name = "ground"  # carries the line
    point_1: Vector  # m, world, t = 0
    point_2: Vector  # m, world, t = 0
    extent: Literal["line", "segment", "capped"] = "line"
    thickness: Positive | None = None  # m: what appears deeper than this is behind the surface, not in it
    law: ContactLaw
    friction: Friction | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if math.dist(self.point_1, self.point_2) == 0.0:
            raise ValueError("point_1 and point_2 coincide; the surface has no direction")
        if isinstance(self.law, ConstraintLaw) and self.extent == "capped":
            raise ValueError("extent = 'capped' does not go with constraint_law; allowed: 'line', 'segment'")
        _no_friction_on_a_constraint(self.law, self.friction)
        return self


class CircleOnCircle(Part):
    """Two discs that touch from outside."""

    type: Literal["circle_on_circle"] = "circle_on_circle"
    name: Name
    body_a: Name
    center_a: Vector  # m, world, t = 0
    radius_a: NonNegative  # m
    body_b: Name
    center_b: Vector  # m, world, t = 0
    radius_b: NonNegative  # m
    law: ContactLaw
    friction: RegularisedCoulomb | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        _require_radius(self.radius_a, self.radius_b)
        _no_friction_on_a_constraint(self.law, self.friction)
        return self


class PinOnSprocket(Part):
    """A round pin in the tooth gaps of a sprocket: seats on the pitch circle with straight flanks.

    A gap is an arc about a point of the pitch circle, wider than the pin by `clearance`, opening
    outwards between flanks inclined by `flank_angle`; beyond the addendum radius there is no tooth.
    """

    type: Literal["pin_on_sprocket"] = "pin_on_sprocket"
    name: Name
    body_a: Name  # carries the pin
    center: Vector  # m, world, t = 0
    body_b: Name  # the sprocket
    axle: Vector  # m, world, t = 0: its centre
    teeth: Annotated[int, Field(ge=3, le=1000)]
    pitch_radius: Positive  # m
    addendum_radius: Positive  # m
    first_seat: float = 0.0  # rad, world angle of one gap at t = 0
    clearance: Positive  # m, seat radius minus pin radius
    flank_angle: Annotated[float, Field(ge=0.0, lt=1.5)] = 0.3490658503988659  # rad (20 degrees), from the radius
    law: ContactLaw
    friction: RegularisedCoulomb | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if isinstance(self.law, ConstraintLaw):
            raise ValueError("law = constraint_law is for circle_on_line and circle_on_circle, not for pin_on_sprocket")
        return self


class SphereOnPlane(Part):
    """A sphere on one body against a flat surface on another or on ground (space); a radius of 0 is a corner.

    The normal points to the free side. `extent`: "plane" has no ends, "rectangle" touches only where the
    sphere's centre is between its edges, "capped" has solid edges and corners too; the last two need `size`
    about `point` and the direction `edge` of its first side.
    """

    type: Literal["sphere_on_plane"] = "sphere_on_plane"
    name: Name
    body_a: Name  # carries the sphere
    center: Vector3  # m, world, t = 0
    radius: NonNegative  # m
    body_b: Name = "ground"  # carries the plane
    point: Vector3  # m, world, t = 0: on the plane, the middle of a rectangle
    normal: Vector3  # direction, world, t = 0
    extent: Literal["plane", "rectangle", "capped"] = "plane"
    size: tuple[Positive, Positive] | None = None  # m, sides of a rectangle
    edge: Vector3 | None = None  # direction of the first side, world, t = 0; perpendicular to normal
    thickness: Positive | None = None  # m: what appears deeper than this is behind the surface, not in it
    law: ContactLaw
    friction: Friction | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not math.hypot(*self.normal) > 0.0:
            raise ValueError(f"normal = {self.normal} has no direction; give any vector but zero")
        bounded = self.extent != "plane"
        if bounded != (self.size is not None) or bounded != (self.edge is not None):
            raise ValueError(f"extent = {self.extent!r}: a rectangle needs size and edge, a plane has neither")
        if self.edge is not None:
            scale = math.hypot(*self.normal) * math.hypot(*self.edge)
            if not abs(math.sumprod(self.normal, self.edge)) <= 1e-9 * scale or scale == 0.0:
                raise ValueError(f"edge = {self.edge} must be perpendicular to normal = {self.normal}")
        if self.extent == "capped" and isinstance(self.friction, StickSlip):
            raise ValueError("extent = 'capped' turns the tangent plane at its edges; stick_slip needs a flat surface")
        _require_force(self.law, self.friction)
        return self


class SphereOnSphere(Part):
    """Two spheres that touch from outside (space)."""

    type: Literal["sphere_on_sphere"] = "sphere_on_sphere"
    name: Name
    body_a: Name
    center_a: Vector3  # m, world, t = 0
    radius_a: NonNegative  # m
    body_b: Name
    center_b: Vector3  # m, world, t = 0
    radius_b: NonNegative  # m
    law: ContactLaw
    friction: RegularisedCoulomb | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        _require_radius(self.radius_a, self.radius_b)
        _require_force(self.law, self.friction)
        return self


def _require_force(law: ContactLaw, friction: Friction | None) -> None:
    if friction is not None and isinstance(law, RigidLaw):
        raise ValueError(f"law = {law.type!r} acts in an instant and has no force for friction; leave friction out")
    if isinstance(law, ConstraintLaw):
        raise ValueError("law = constraint_law is for circle_on_line and circle_on_circle, not yet for space")


Contact = Annotated[
    CircleOnLine | CircleOnCircle | PinOnSprocket | SphereOnPlane | SphereOnSphere, Field(discriminator="type")
]
