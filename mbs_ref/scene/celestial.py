"""Gravity and what else moves celestial bodies: each physics is a part of its own, with its source.

They act on scenes of three-dimensional point masses, the gravity gradient on rigid bodies. Frames are inertial with
ICRF axes; times are TDB seconds. G m is known to ten digits and more, G to four: parts therefore take the product,
`gm` in m^3/s^2.
"""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from mbs_ref.scene.base.attached import Attached
from mbs_ref.scene.base.part import BodyName, Direction3, Name, NonNegative, Positive

G_SI = 6.67430e-11  # m^3/(kg s^2), CODATA 2018; turns gm into kilograms where energy is wanted in joules
C_SI = 299_792_458.0  # m/s, exact
AU_M = 149_597_870_700.0  # m, IAU 2012 Resolution B2, exact
DAY_S = 86_400.0  # s
J2000_JD = 2_451_545.0  # TDB

Pole = Literal["fixed", "earth_iau2006"]


class CelestialPart(Attached):
    """What acts on point masses in space."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)


class Newton(CelestialPart):
    """Newton's attraction between all pairs, the gm of each body in scene order."""

    type: Literal["newton"] = "newton"
    gm: tuple[NonNegative, ...]  # m^3/s^2; 0 for a body that is attracted and attracts nothing
    radius: tuple[NonNegative, ...] = ()  # m; two bodies closer than the sum of theirs have collided


class Relativity(CelestialPart):
    """Post-Newtonian gravity: the Einstein-Infeld-Hoffmann equations, or the first body's field alone.

    Sources: eih, Park et al., Astron. J. 161 (2021) 105, eq 27 with beta = gamma = 1; central,
    IERS Conventions 2010, eq 10.12, first line.
    """

    type: Literal["relativity"] = "relativity"
    form: Literal["eih", "central"] = "eih"  # all pairs, or the first body's field alone
    c: Positive = C_SI  # m/s


class Oblateness(CelestialPart):
    """Zonal harmonics J2 to J6 of a body, acting on every other body, with the reaction on it.

    The pole is fixed, or the Earth's: precession and the 18.6-year nutation (IERS Conventions 2010, eq 5.16).
    """

    type: Literal["oblateness"] = "oblateness"
    body: BodyName
    radius: Positive  # m
    zonal: Annotated[tuple[float, ...], Field(min_length=1, max_length=5)]  # J2, J3, ... J6
    pole: Pole = "fixed"  # fixed, or the Earth's
    axis: Direction3 = (0.0, 0.0, 1.0)  # unit vector, ICRF; of the fixed pole


class LunarFigure(CelestialPart):
    """The Moon's J2 and C22, turned by the IAU rotation model: approximate, good to 0.02 degrees.

    Rotation: Archinal et al., Celest. Mech. Dyn. Astr. 109 (2011) 101, table 2.
    """

    type: Literal["lunar_figure"] = "lunar_figure"
    body: BodyName
    radius: Positive  # m
    j2: float  # -
    c22: float  # -


class Tide(CelestialPart):
    """The tide that `raiser` raises on `body`, acting back on it with one constant time lag: approximate.

    Source: Mignard, Moon and Planets 20 (1979) 301, eq 5.
    """

    type: Literal["tide"] = "tide"
    body: BodyName
    raiser: BodyName
    radius: Positive  # m, of the body
    love_number: NonNegative  # -, k2
    lag: NonNegative  # s
    spin: tuple[float, float, float]  # rad/s, of the body


class Ring(CelestialPart):
    """A ring of equal fixed point masses about the origin (Park et al. 2021, sec. 2: the Kuiper belt).

    The first lies along the normal's cross product with the coordinate axis that is most across it.
    """

    type: Literal["ring"] = "ring"
    gm: Positive  # m^3/s^2, of the whole ring
    radius: Positive  # m
    normal: Direction3  # unit vector, ICRF
    count: Annotated[int, Field(ge=3, le=1000)] = 36  # point masses


class ThirdBody(CelestialPart):
    """The Moon's or the Sun's pull on satellites of a body at rest, its own fall towards it taken off.

    Positions by series good to some 0.1 %: Montenbruck and Gill, Satellite Orbits (2000), sec. 3.3.2, with the
    obliquity of the ecliptic of IAU 2006, 84381.406 seconds of arc.
    """

    type: Literal["third_body"] = "third_body"
    body: BodyName  # the attracted satellite
    source: Literal["sun", "moon"]  # the attracting body
    gm: Positive  # m^3/s^2


class Drag(CelestialPart):
    """Drag in an exponential atmosphere that turns with the body (Montenbruck and Gill, sec. 3.5)."""

    type: Literal["drag"] = "drag"
    body: BodyName
    planet: BodyName
    coefficient: NonNegative  # m^2/kg, c_D A / m
    density: Positive  # kg/m^3, at `altitude`
    altitude: float  # m
    scale_height: Positive  # m
    radius: Positive  # m, where the altitude is zero
    spin: float = 7.292115e-5  # rad/s, about z; IERS Conventions 2010, table 1.2


class StandardDrag(CelestialPart):
    """Drag in the air of the US Standard Atmosphere 1976, between -5 and 86 km; outside, a run stops.

    The air turns with the body, or rests where `spin` is 0. Source: NOAA-S/T 76-1562 (1976), eq 18, 23, 33a, 33b, 42.
    """

    type: Literal["standard_drag"] = "standard_drag"
    body: BodyName
    planet: BodyName
    coefficient: NonNegative  # m^2/kg, c_D A / m
    radius: Positive  # m, where the altitude is zero
    spin: float = 7.292115e-5  # rad/s, about z; IERS Conventions 2010, table 1.2


class RadiationPressure(CelestialPart):
    """Sunlight on a satellite, with umbra and penumbra of a body at rest (Montenbruck and Gill, sec. 3.4).

    The Sun is where ThirdBody has it, and its radius is 6.957e8 m (IAU 2015 Resolution B3).
    """

    type: Literal["radiation_pressure"] = "radiation_pressure"
    body: BodyName
    planet: BodyName
    coefficient: NonNegative  # m^2/kg, c_R A / m
    radius: Positive  # m, of the body that casts the shadow
    pressure: Positive = 4.56e-6  # N/m^2 at 1 au; Montenbruck and Gill, eq 3.69


class GravityGradient(CelestialPart):
    """What a rigid body's extent adds to a planet's attraction: MacCullagh's torque, and his force.

    torque = 3 gm / d^5 (d x J d) and force = -3 gm / (2 d^5) ((tr J - 5 d.J d / d^2) d + 2 J d), with d from the planet
    to the body's centre of mass; the planet bears the opposite force. It goes with `newton`, which attracts the body as
    a point. Source: J. Wertz, Spacecraft Attitude Determination and Control (1978), eq 17-30.
    """

    type: Literal["gravity_gradient"] = "gravity_gradient"
    body: BodyName  # whose inertia feels the gradient
    planet: BodyName
    gm: Positive  # m^3/s^2, of the planet

    def refuses_particle(self, end: str, dimension: int) -> str:
        return "and has no extent to feel the gradient over" if end == "body" else ""


class Epoch(CelestialPart):
    """When t = 0 is: needed by every part whose direction depends on the date."""

    type: Literal["epoch"] = "epoch"
    name: Name = "epoch"
    jd_tdb: float = J2000_JD  # days

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 2_000_000.0 < self.jd_tdb < 3_000_000.0:
            raise ValueError(f"jd_tdb = {self.jd_tdb} is no Julian date between 2 000 000 and 3 000 000")
        return self


Attraction = Newton | Relativity | Oblateness | LunarFigure | Tide | Ring | ThirdBody  # by bodies
CelestialLoad = Attraction | Drag | StandardDrag | RadiationPressure | GravityGradient | Epoch


def at_most_one(parts: list[Any]) -> Any:
    """Return the only load of a type, or None; ValueError where there are more."""
    if len(parts) > 1:
        raise ValueError(f"loads {', '.join(repr(p.name) for p in parts)} are all of type {parts[0].type}; give one")
    return parts[0] if parts else None
