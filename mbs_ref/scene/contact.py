"""Contact parts of a scene: what touches what, by which law, with which friction.

The penetration d is positive inside; d' is its rate. Every law is a type of its own, states its
release rule, and returns the numbers of the solver's kernels. Points are world points at t = 0.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from mbs_ref.scene.base import part
from mbs_ref.scene.base.attached import NO_ORIENTATION, Attached
from mbs_ref.scene.bodies import Body, PointMass
from mbs_ref.scene.joints import axis_complaints

Restitution = Annotated[float, Field(ge=0.0, le=1.0)]


class LawNumbers(NamedTuple):
    """F = k d^n + c d^m d' with c = damping + impact_damping k / v0, v0 the speed at touch-down."""

    stiffness: float = 0.0  # k, N/m^n
    damping: float = 0.0  # N s/m^(m + 1)
    exponent: float = 1.0  # n
    damping_exponent: float = 0.0  # m
    impact_damping: float = 0.0  # -
    slowest: float = 1.0  # m/s, v0 is taken no smaller
    restitution: float = 0.0  # -, of an impulse
    release: Literal["gap", "force", "rigid", "constraint"] = "gap"  # rule by which the contact opens


class Law(part.Part):
    """A contact law."""

    IMPULSIVE: ClassVar[bool] = False  # acts at touch-down, in an instant
    HOLDS: ClassVar[bool] = False  # replaces the force by a constraint while contact lasts
    NEEDS_IMPACT_SPEED: ClassVar[bool] = False

    type: Any

    def numbers(self) -> LawNumbers:
        """Return the numbers in the solver's arrays."""
        raise NotImplementedError(f"{type(self).__name__} names no numbers")


class SpringDamperLaw(Law):
    """F = k d + c d' (Fox 1999 eq 18, Fox 2001 eq 28): jumps by c v0 at touch-down.

    With release "gap" it opens at d = 0 and pulls shortly before; with "force" it opens at F = 0 and never pulls.
    """

    type: Literal["spring_damper_law"] = "spring_damper_law"
    stiffness: part.Positive  # N/m
    damping: part.NonNegative = 0.0  # N s/m
    release: Literal["gap", "force"] = "gap"  # what opens the contact

    def numbers(self) -> LawNumbers:
        return LawNumbers(self.stiffness, self.damping, release=self.release)


class ProgressiveLaw(Law):
    """F = k d + c d d' (Fox 1999 eq 33, Fox 2001 eq 34): continuous with a kink; opens at d = 0, where F = 0."""

    type: Literal["progressive_law"] = "progressive_law"
    stiffness: part.Positive  # N/m
    damping: part.NonNegative = 0.0  # N s/m^2

    def numbers(self) -> LawNumbers:
        return LawNumbers(self.stiffness, self.damping, damping_exponent=1.0)


class HuntCrossleyLaw(Law):
    """F = d^n (k + c d') (Hunt and Crossley 1975); opens at d = 0, where F = 0."""

    type: Literal["hunt_crossley_law"] = "hunt_crossley_law"
    stiffness: part.Positive  # N/m^n
    damping: part.NonNegative = 0.0  # N s/m^(n + 1)
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5  # -, n

    def numbers(self) -> LawNumbers:
        return LawNumbers(self.stiffness, self.damping, self.exponent, self.exponent)


class BekkerLaw(Law):
    """F = b l (k_c / b + k_phi) d^n + c d d': a foot of width b and length l sinks into soil (Bekker 1956).

    Pressure and sinkage of soil that is pressed once. It has no memory: no rut stays where the load has passed.
    """

    type: Literal["bekker_law"] = "bekker_law"
    cohesive: part.NonNegative  # N/m^(n + 1), k_c
    frictional: part.NonNegative  # N/m^(n + 2), k_phi
    exponent: Annotated[float, Field(ge=0.1, le=3.0)]  # -, n
    width: part.Positive  # m, b, of the track or plate that the foot is part of
    length: part.Positive  # m, l
    damping: part.NonNegative = 0.0  # N s/m^2

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.cohesive == self.frictional == 0.0:
            raise ValueError("cohesive and frictional are both 0; one must be positive")
        return self

    def numbers(self) -> LawNumbers:
        stiffness = self.length * (self.cohesive + self.width * self.frictional)
        return LawNumbers(stiffness, self.damping, self.exponent, 1.0)


class LankaraniNikraveshLaw(Law):
    """F = k d^n (1 + 3 (1 - e^2)/4 d'/v0), v0 the speed at touch-down (Lankarani and Nikravesh 1990).

    Opens at d = 0, where F = 0. e is nominal: the actual restitution differs.
    """

    NEEDS_IMPACT_SPEED: ClassVar[bool] = True

    type: Literal["lankarani_nikravesh_law"] = "lankarani_nikravesh_law"
    stiffness: part.Positive  # N/m^n
    restitution: Restitution  # -, e
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5  # -, n
    slowest: part.Positive = 1e-3  # m/s, v0 is taken no smaller: a contact that starts at rest has no impact speed

    def numbers(self) -> LawNumbers:
        factor = 0.75 * (1.0 - self.restitution**2)
        return LawNumbers(self.stiffness, 0.0, self.exponent, self.exponent, factor, self.slowest)


class FloresLaw(Law):
    """F = k d^n (1 + 8 (1 - e)/(5 e) d'/v0), v0 the speed at touch-down (Flores et al. 2011).

    Opens at d = 0, where F = 0. e is nominal: the actual restitution differs.
    """

    NEEDS_IMPACT_SPEED: ClassVar[bool] = True

    type: Literal["flores_law"] = "flores_law"
    stiffness: part.Positive  # N/m^n
    restitution: Annotated[float, Field(gt=0.0, le=1.0)]  # -, e
    exponent: Annotated[float, Field(ge=1.0, le=10.0)] = 1.5  # -, n
    slowest: part.Positive = 1e-3  # m/s, v0 is taken no smaller

    def numbers(self) -> LawNumbers:
        factor = 1.6 * (1.0 - self.restitution) / self.restitution
        return LawNumbers(self.stiffness, 0.0, self.exponent, self.exponent, factor, self.slowest)


class RigidLaw(Law):
    """No penetration: at touch-down an impulse reverses the normal speed, v+ = -e v- (Newton).

    Bounces end in rest where e < 1. Then contact lasts as under `constraint_law`, where a constraint may stand for the
    force. Without friction.
    """

    IMPULSIVE: ClassVar[bool] = True

    type: Literal["rigid_law"] = "rigid_law"
    restitution: Restitution  # -, e

    def numbers(self) -> LawNumbers:
        return LawNumbers(restitution=self.restitution, release="rigid")


class ConstraintLaw(Law):
    """No penetration and no rebound: while contact lasts the constraint gap = 0 stands for the force.

    The papers' other cure (Fox 2001). At touch-down an impulse removes the approach speed (restitution 0);
    the contact opens where the multiplier would pull. For circles and spheres alone, without friction.
    """

    IMPULSIVE: ClassVar[bool] = True
    HOLDS: ClassVar[bool] = True

    type: Literal["constraint_law"] = "constraint_law"

    def numbers(self) -> LawNumbers:
        return LawNumbers(release="constraint")


StateLaw = SpringDamperLaw | ProgressiveLaw | HuntCrossleyLaw | BekkerLaw  # of depth and its rate alone
ForceLaw = StateLaw | LankaraniNikraveshLaw | FloresLaw
ContactLaw = Annotated[ForceLaw | RigidLaw | ConstraintLaw, Field(discriminator="type")]


class FrictionNumbers(NamedTuple):
    """Friction as the solver's arrays hold it."""

    kind: Literal["none", "smooth", "stick_slip"] = "none"
    coefficient: float = 0.0  # mu
    static: float = 0.0  # mu_s
    creep: float = 1.0  # m/s, v_s
    grip_stiffness: float = 0.0  # N/m
    grip_damping: float = 0.0  # N s/m
    lever: float = 0.0  # m, of rolling resistance
    roll: float = 1.0  # rad/s, w_s


class RegularisedCoulomb(part.Part):
    """F_t = -mu F_n tanh(v_t / v_s): smooth, and creeps where Coulomb's law would stick."""

    STICKS: ClassVar[bool] = False

    type: Literal["regularised_coulomb"] = "regularised_coulomb"
    coefficient: part.NonNegative  # -, mu
    speed: part.Positive = 1e-3  # m/s, v_s

    def numbers(self) -> FrictionNumbers:
        return FrictionNumbers("smooth", self.coefficient, creep=self.speed)


class RollingFriction(part.Part):
    """Friction of `regularised_coulomb`, and resistance to rolling: the force acts ahead of the point of contact.

    With w = (omega_a - omega_b) x n, n the normal, it acts e tanh(|w| / w_s) ahead, along w: a couple e F_n against
    rolling, as of pressure that leads a wheel (Johnson, Contact Mechanics, 1985, sec. 9.1). Spin about n is free. Below
    w_s the resistance fades, so that a wheel creeps where it would stand.
    """

    STICKS: ClassVar[bool] = False

    type: Literal["rolling_friction"] = "rolling_friction"
    coefficient: part.NonNegative  # -, mu
    speed: part.Positive = 1e-3  # m/s, v_s
    lever: part.Positive  # m, e: the coefficient of rolling resistance times the radius
    rate: part.Positive = 1e-2  # rad/s, w_s

    def numbers(self) -> FrictionNumbers:
        return FrictionNumbers("smooth", self.coefficient, creep=self.speed, lever=self.lever, roll=self.rate)


class StickSlip(part.Part):
    """Coulomb's law with located transitions: F_t = -mu F_n sign(v_t), or a stiff spring while it sticks.

    Sticks where the tangential force needed is within mu_s F_n, and slips where it is not.
    """

    STICKS: ClassVar[bool] = True  # located transitions; in space its deflections are states

    type: Literal["stick_slip"] = "stick_slip"
    coefficient: part.NonNegative  # -, mu
    static: part.NonNegative | None = None  # -, mu_s; mu unless given
    stiffness: part.Positive  # N/m, of the sticking contact
    damping: part.NonNegative = 0.0  # N s/m, of the sticking contact

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.static is not None and self.static < self.coefficient:
            raise ValueError(f"static = {self.static} must not be below coefficient = {self.coefficient}")
        return self

    def numbers(self) -> FrictionNumbers:
        static = self.coefficient if self.static is None else self.static
        return FrictionNumbers("stick_slip", self.coefficient, static, 1.0, self.stiffness, self.damping)


Smooth = Annotated[RegularisedCoulomb | RollingFriction, Field(discriminator="type")]
Friction = Annotated[RegularisedCoulomb | RollingFriction | StickSlip, Field(discriminator="type")]


class ContactPart(Attached):
    """Two shapes on two bodies, a law and friction."""

    SHAPED_B: ClassVar[bool] = False  # whether body_b carries more than a circle or a sphere
    MAY_HOLD: ClassVar[bool] = True  # whether a law may stand for a constraint here

    law: ContactLaw  # of the normal force
    friction: Any = None  # none unless given

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        if self.law.HOLDS and not self.MAY_HOLD:
            raise ValueError(f"law = {self.law.type!r} is for circles and spheres, not for {self.type}")
        if self.law.HOLDS and getattr(self, "extent", "") == "capped":
            raise ValueError(f"extent = 'capped' does not go with {self.law.type}; its ends turn the normal")
        if self.law.IMPULSIVE and self.friction is not None:
            cure = "leave friction out, or take a law with a force, such as 'hunt_crossley_law'"
            raise ValueError(f"law = {self.law.type!r} has no force that friction could use; {cure}")
        return self

    @property
    def holds(self) -> bool:
        """Whether a constraint stands for the force while contact lasts."""
        rests = isinstance(self.law, RigidLaw) and self.law.restitution < 1.0
        return self.law.HOLDS or (rests and self.MAY_HOLD and getattr(self, "extent", "") != "capped")

    def refuses_particle(self, end: str, dimension: int) -> str:
        shaped = end == "body_b" and self.SHAPED_B
        return "and carries circles without friction only; use a rigid body" if self.friction or shaped else ""


class CircleOnLine(ContactPart):
    """A circle on one body against a straight surface on another or on ground; a radius of 0 is a corner.

    Walking from point_1 to point_2 the free side is on the left. `extent`: "line" has no ends, "segment"
    touches only where the circle's centre is between the ends, "capped" has solid end points too.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2,)
    COUNTERPART: ClassVar[str] = "sphere_on_plane"
    SHAPED_B: ClassVar[bool] = True

    type: Literal["circle_on_line"] = "circle_on_line"
    body_a: part.EndName  # carries the circle
    center: part.Point  # m, world, t = 0
    radius: part.NonNegative  # m
    body_b: part.EndName = "ground"  # carries the line
    point_1: part.Point  # m, world, t = 0
    point_2: part.Point  # m, world, t = 0
    extent: Literal["line", "segment", "capped"] = "line"  # where the surface ends
    thickness: part.Positive | None = None  # m: what appears deeper than this is behind the surface, not in it
    friction: Friction | None = None  # none unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if math.dist(self.point_1, self.point_2) == 0.0:
            raise ValueError("point_1 and point_2 coincide; the surface has no direction")
        return self


class RoundPair(ContactPart):
    """Two round shapes that touch from outside."""

    body_a: part.EndName
    center_a: part.Point  # m, world, t = 0
    radius_a: part.NonNegative  # m
    body_b: part.EndName
    center_b: part.Point  # m, world, t = 0
    radius_b: part.NonNegative  # m
    friction: Smooth | None = None  # none unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.radius_a + self.radius_b == 0.0:
            raise ValueError("radius_a and radius_b are both 0; one must be positive")
        return self


class CircleOnCircle(RoundPair):
    """Two discs that touch from outside."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2,)
    COUNTERPART: ClassVar[str] = "sphere_on_sphere"

    type: Literal["circle_on_circle"] = "circle_on_circle"


class SphereOnSphere(RoundPair):
    """Two spheres that touch from outside (space)."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    COUNTERPART: ClassVar[str] = "circle_on_circle"

    type: Literal["sphere_on_sphere"] = "sphere_on_sphere"


class PinOnSprocket(ContactPart):
    """A round pin in the tooth gaps of a sprocket: seats on the pitch circle with straight flanks.

    A gap is an arc about a point of the pitch circle, wider than the pin by `clearance`, opening
    outwards between flanks inclined by `flank_angle`; beyond the addendum radius there is no tooth. In space the pin is
    a cylinder as long as need be along the axle, touched in the plane through its centre.
    """

    SHAPED_B: ClassVar[bool] = True
    MAY_HOLD: ClassVar[bool] = False

    type: Literal["pin_on_sprocket"] = "pin_on_sprocket"
    body_a: part.EndName  # carries the pin
    center: part.Point  # m, world, t = 0
    body_b: part.EndName  # the sprocket
    axle: part.Point  # m, world, t = 0: its centre
    teeth: Annotated[int, Field(ge=3, le=1000)]  # number of gaps
    pitch_radius: part.Positive  # m
    addendum_radius: part.Positive  # m
    first_seat: float = 0.0  # rad, angle of one gap at t = 0, in the world or from `seat`
    clearance: part.Positive  # m, seat radius minus pin radius
    flank_angle: Annotated[float, Field(ge=0.0, lt=1.5)] = 0.3490658503988659  # rad (20 degrees), from the radius
    axis: part.Direction | None = None  # direction of the axle, world, t = 0; required in space, forbidden in the plane
    seat: part.Direction | None = None  # direction, world, t = 0, perpendicular to axis; likewise
    friction: RegularisedCoulomb | None = None  # none unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.axis is not None and self.seat is not None and len(self.axis) == len(self.seat):
            part.require_perpendicular("axis", self.axis, "seat", self.seat)
        return self

    def complaints(self, dimension: int) -> Iterator[str]:
        yield from axis_complaints(self.type, self.axis, dimension)
        if (self.axis is None) != (self.seat is None):
            yield "axis and seat go together: give both in space, and neither in the plane"


class SphereOnPlane(ContactPart):
    """A sphere on one body against a flat surface on another or on ground (space); a radius of 0 is a corner.

    The normal points to the free side. `extent`: "plane" has no ends, "rectangle" touches only where the
    sphere's centre is between its edges, "capped" has solid edges and corners too; the last two need `size`
    about `point` and the direction `edge` of its first side.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    COUNTERPART: ClassVar[str] = "circle_on_line"
    SHAPED_B: ClassVar[bool] = True

    type: Literal["sphere_on_plane"] = "sphere_on_plane"
    body_a: part.EndName  # carries the sphere
    center: part.Point3  # m, world, t = 0
    radius: part.NonNegative  # m
    body_b: part.EndName = "ground"  # carries the plane
    point: part.Point3  # m, world, t = 0: on the plane, the middle of a rectangle
    normal: part.Direction3  # direction, world, t = 0
    extent: Literal["plane", "rectangle", "capped"] = "plane"  # where the surface ends
    size: tuple[part.Positive, part.Positive] | None = None  # m, sides of a rectangle
    edge: part.Direction3 | None = None  # direction of the first side, world, t = 0; perpendicular to normal
    thickness: part.Positive | None = None  # m: what appears deeper than this is behind the surface, not in it
    friction: Friction | None = None  # none unless given

    def mark(self, end: str) -> tuple[float, ...]:
        return self.center if end == "body_a" else self.point

    @model_validator(mode="after")
    def _check(self) -> Self:
        bounded = self.extent != "plane"
        if bounded != (self.size is not None) or bounded != (self.edge is not None):
            raise ValueError(f"extent = {self.extent!r}: a rectangle needs size and edge, a plane has neither")
        if self.edge is not None:
            part.require_perpendicular("edge", self.edge, "normal", self.normal)
        if self.extent == "capped" and self.friction is not None and self.friction.STICKS:
            raise ValueError("extent = 'capped' turns the tangent plane at its edges; stick_slip needs a flat surface")
        return self


class Wall(part.Part):
    """A fixed flat surface without ends; its normal points to the free side."""

    point: part.Point  # m, world
    normal: part.Direction  # direction, world


class Granules(Attached):
    """Many rounded shapes about the centres of mass of bodies: all may touch one another, and walls.

    A shape is a core and all that lies within `radius` of it. The core is a point (of a sphere, in the plane a disc)
    unless `half` gives it lengths along the axes of its body: along one axis it is that of a capsule, along more that
    of a plate or a box. One law and one friction hold for all. What touches are corners of cores and edges that cross.
    Pairs come from a neighbour search, so that the work grows with the number of shapes. Touch-downs are not located,
    since many happen in every step: the force follows from the state, and methods of high order are no more accurate
    than the kinks of the law allow.
    """

    type: Literal["granules"] = "granules"
    radius: Annotated[tuple[part.NonNegative, ...], Field(min_length=1)]  # m, one a body or one for all; 0: no shape
    half: tuple[tuple[part.NonNegative, ...], ...] = ()  # m, of the core along the body's axes; as many, or none
    walls: tuple[Wall, ...] = ()  # each a point (m) and the normal to the free side, world
    law: Annotated[StateLaw, Field(discriminator="type")]  # of the normal force
    friction: RegularisedCoulomb | None = None  # none unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not any(self.radius):
            raise ValueError(f"radius = {self.radius}: one must be positive")
        return self

    def shapes(self, count: int, dimension: int) -> tuple[np.ndarray, np.ndarray]:
        """Return radius (n,) and half (n, dimension), m, of `count` bodies."""
        half = np.broadcast_to(self.half or np.zeros((1, dimension)), (count, dimension))
        return np.broadcast_to(self.radius, count), half

    @property
    def ends(self) -> tuple[str, str]:
        return ("ground", "ground") if self.walls else ("", "")  # what it holds to

    def complaints(self, dimension: int) -> Iterator[str]:
        for k, half in enumerate(self.half):
            if len(half) != dimension:
                yield f"half[{k}] = {half} must have {dimension} components here"
        for k, wall in enumerate(self.walls):
            for field, value in (("point", wall.point), ("normal", wall.normal)):
                if len(value) != dimension:
                    yield f"walls[{k}].{field} = {value} must have {dimension} components here"


def granular_complaints(loads: Sequence[Attached], bodies: Sequence[Body]) -> Iterator[str]:
    """Yield what is invalid about the granules of a scene as a whole."""
    groups = {k: load for k, load in enumerate(loads) if isinstance(load, Granules)}
    if len(groups) > 1:
        yield f"loads {', '.join(repr(group.name) for group in groups.values())} are all granules; give one"
    for k, group in groups.items():
        where, allowed = f"loads[{k}] ({group.name})", (1, len(bodies))
        wrong = [(name, len(given)) for name in ("radius", "half") if (given := getattr(group, name) or (0,))]
        wrong = [one for one in wrong if one[1] not in allowed]
        yield from (f"{where}: {name} has {n} entries; allowed: 1, or {len(bodies)}, one a body" for name, n in wrong)
        sizes = cycle(group.radius), cycle(group.half or ((),))
        for body, size, half in () if wrong else zip(bodies, *sizes, strict=False):
            if any(half) and not size:
                yield f"{where}: radius = 0 rounds the edges of {body.name!r}, half = {half}; it must be positive"
            if size and isinstance(body, PointMass) and (any(half) or group.friction):
                what = "half turns with" if any(half) else "friction turns"
                yield f"{where}: its {what} {body.name!r}, a point mass, {NO_ORIENTATION}"


Contact = Annotated[
    CircleOnLine | CircleOnCircle | PinOnSprocket | SphereOnPlane | SphereOnSphere, Field(discriminator="type")
]
