"""The Sun, eight planets, the Moon and Pluto, with selectable physics."""

import datetime
import math
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from mbs_ref import ephemeris
from mbs_ref.scene import PointMass, Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import DAY_S, G_SI, Epoch, LunarFigure, Newton, Oblateness, Relativity, Ring, Tide
from mbs_ref.scenes import read_data

Formulation = Literal["point", "euler_parameters"]
Triple = tuple[float, float, float]
Model = Literal["lumped", "newton", "gr_sun", "gr", "j2", "asteroids", "full"]
LEVELS = ("newton", "gr", "j2", "asteroids", "full")  # each includes those before it
J2_SUN, R_SUN = 2.1961391516529825e-07, 6.96e8  # -, m: DE440 constants J2SUN, ASUN
J_EARTH = (1.08262539e-3, -2.53241e-6, -1.619898e-6)  # DE440 constants J2E, J3E, J4E
R_EARTH, R_MOON = 6.3781366e6, 1.738e6  # m: DE440 constants RE, AM
SUN_POLE_DEG = (286.13, 63.87)  # right ascension, declination, ICRF: Archinal et al. 2011, table 1
J2_MOON, C22_MOON = 2.03214360135e-4, 2.2380845245752079e-5  # DE440 constants J2M, C22M
LOVE, LAG_S = 0.305, 638.0  # k2 and its lag: Neron de Surgy and Laskar, Astron. Astrophys. 318 (1997) 975
EARTH_SPIN = 7.292115e-5  # rad/s, IERS Conventions 2010, table 1.2
RING_GM = 36 * 5.5227699716988214e-13 * 149_597_870_700.0**3 / DAY_S**2  # m^3/s^2: DE440 constants MA8201-MA8236
RING_RADIUS = 44.0 * 149_597_870_700.0  # m: Park et al. 2021, sec. 2
ECLIPTIC_POLE = (0.0, -0.397777155931914, 0.917482062069182)  # of J2000, ICRF


class Rotation(NamedTuple):
    """A body's mean radius (km), the ICRF direction of its pole (deg) and its rate (deg/day)."""

    radius_km: float
    ascension_deg: float
    declination_deg: float
    rate_deg_day: float

    @property
    def angular_velocity(self) -> tuple[float, float, float]:
        """The rate along the pole, rad/s, ICRF axes."""
        rate = math.radians(self.rate_deg_day) / DAY_S
        a, d = math.radians(self.ascension_deg), math.radians(self.declination_deg)
        return rate * math.cos(d) * math.cos(a), rate * math.cos(d) * math.sin(a), rate * math.sin(d)


ROTATIONS = {name: Rotation(*numbers) for name, numbers in read_data("rotations")["bodies"].items()}


def solar_system(
    *, days: Positive = 360.0, start: Annotated[str, Field(pattern=r"^\d{4}-\d\d-\d\d$")] = "1998-01-01",
    model: Model = "full", formulation: Formulation = "point", spin: bool = False,
) -> Scene:  # fmt: skip
    """Run the solar system from JPL DE440 and see which physics buys which digit (Fox 2001).

    days, start (date, 0 h TDB), model (lumped: Earth and Moon one body; newton; gr; j2; asteroids; full, each
    with those before it; gr_sun: newton with the Sun's relativity alone), formulation (point masses, or rigid
    spheres with Euler parameters as in the paper; those know Newton's gravity alone), spin (spheres turn).
    """
    if formulation == "euler_parameters" and model not in ("lumped", "newton"):
        raise ValueError(f"model = {model!r} acts on point masses alone; euler_parameters allow: lumped, newton")
    if spin and formulation == "point":
        raise ValueError("spin = True: a point mass does not turn; give formulation = 'euler_parameters'")
    jd = julian_date(start)
    names = [name for name in ephemeris.BODIES if model != "lumped" or name != "moon"]
    level = LEVELS.index(model) if model in LEVELS else 0
    if level >= LEVELS.index("asteroids"):
        names += ephemeris.asteroids()
    states = {name: _state(name, jd, model == "lumped") for name in names}
    gms = {name: ephemeris.gm(name) for name in names}
    if model == "lumped":
        gms["earth"] += ephemeris.gm("moon")
    return Scene(
        name="solar_system",
        description=f"{len(names)} bodies from {start} 0 h TDB over {days:g} days, physics: {model}.",
        source=ephemeris.excerpt()["source"],
        duration=days * DAY_S,
        bodies=tuple(
            _body(name, gms[name] / G_SI, tuple(p.tolist()), tuple(v.tolist()), formulation, spin)
            for name, (p, v) in states.items()
        ),
        loads=(Epoch(jd_tdb=jd), Newton(name="newton", gm=tuple(gms.values())), *_physics(model, level)),
    )


def _body(name: str, mass: float, place: Triple, rate: Triple, formulation: str, spin: bool) -> PointMass | SpatialBody:
    if formulation == "point":
        return PointMass(name=name, mass=mass, position=place, velocity=rate)
    rotation = ROTATIONS[name]
    inertia = 0.4 * mass * (rotation.radius_km * ephemeris.KM) ** 2  # kg m^2, of a homogeneous sphere
    turning = rotation.angular_velocity if spin else (0.0, 0.0, 0.0)
    return SpatialBody(
        name=name, mass=mass, inertia=(inertia, inertia, inertia, 0.0, 0.0, 0.0),
        position=place, velocity=rate, angular_velocity=turning,
    )  # fmt: skip


def julian_date(start: str) -> float:
    """Return the Julian date of a calendar date at 0 h; ValueError where there is no such date."""
    return datetime.date.fromisoformat(start).toordinal() + 1_721_424.5


def _state(name: str, jd: float, lumped: bool) -> tuple[np.ndarray, np.ndarray]:
    place, rate = ephemeris.state(name, jd)
    if not lumped or name != "earth":
        return place, rate
    moon, moon_rate = ephemeris.state("moon", jd)
    share = 1.0 / (1.0 + ephemeris.EARTH_MOON_RATIO)
    return place + share * (moon - place), rate + share * (moon_rate - rate)


def _physics(model: str, level: int) -> list[Any]:
    parts: list[Any] = []
    if model == "gr_sun":
        parts.append(Relativity(name="relativity", form="central"))
    if level >= LEVELS.index("gr"):
        parts.append(Relativity(name="relativity"))
    if level >= LEVELS.index("j2"):
        parts += oblate_bodies()
    if level >= LEVELS.index("full"):
        parts += _moon_and_ring()
    return parts


def oblate_bodies() -> list[Oblateness]:
    """Return the Sun's J2 and the Earth's J2 to J4."""
    ra, dec = np.radians(SUN_POLE_DEG)
    axis = (math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec))
    return [
        Oblateness(name="sun_j2", body="sun", radius=R_SUN, zonal=(J2_SUN,), axis=axis),
        Oblateness(name="earth_j", body="earth", radius=R_EARTH, zonal=J_EARTH, pole="earth_iau2006"),
    ]


def _moon_and_ring() -> list[Any]:
    spin = (0.0, 0.0, EARTH_SPIN)
    return [
        LunarFigure(name="moon_figure", body="moon", radius=R_MOON, j2=J2_MOON, c22=C22_MOON),
        Tide(name="earth_tide", body="earth", raiser="moon", radius=R_EARTH, love_number=LOVE, lag=LAG_S, spin=spin),
        Ring(name="kuiper_ring", gm=RING_GM, radius=RING_RADIUS, normal=ECLIPTIC_POLE),
    ]
