"""The arrays of a compiled scene of particles, one group a field; a field that is not in use is empty."""

from typing import Annotated, NamedTuple

from mbs_ref.kernels.algebra.lanes import WIDTH, in_one_room
from mbs_ref.kernels.border.groups import Floats, Ints, empty
from mbs_ref.kernels.border.handles import handle_class

EXPONENTIAL, STANDARD = 0, 1  # atmospheres
LANES = WIDTH  # instants evaluated side by side: the stages of a Gauss step, or one instant repeated


class Particles(NamedTuple):
    gm: Annotated[Floats, "n"]  # m^3/s^2
    radius: Annotated[Floats, "n"]  # m
    gravity: Annotated[Floats, 3]  # m/s^2
    epoch: Annotated[Floats, 1]  # s past J2000 TDB at t = 0
    uses_velocity: Annotated[Ints, 1]  # whether an acceleration depends on velocities


class RelativityArrays(NamedTuple):
    form: Annotated[Ints, 1]  # 0 none, 1 central, 2 eih
    inverse_c2: Annotated[Floats, 1]  # s^2/m^2


class Zonals(NamedTuple):
    body: Annotated[Ints, "k"]
    radius: Annotated[Floats, "k"]  # m
    harmonic: Annotated[Floats, "k", 5]  # J2 .. J6
    precesses: Annotated[Ints, "k"]
    axis: Annotated[Floats, "k", 3]


class Figures(NamedTuple):
    body: Annotated[Ints, "k"]
    radius: Annotated[Floats, "k"]  # m
    j2: Annotated[Floats, "k"]
    c22: Annotated[Floats, "k"]


class Tides(NamedTuple):
    body: Annotated[Ints, "k"]
    raiser: Annotated[Ints, "k"]
    radius: Annotated[Floats, "k"]  # m
    love_number: Annotated[Floats, "k"]
    lag: Annotated[Floats, "k"]  # s
    spin: Annotated[Floats, "k", 3]  # rad/s


class Points(NamedTuple):
    """Fixed attractors: the ring."""

    gm: Annotated[Floats, "k"]  # m^3/s^2
    place: Annotated[Floats, "k", 3]  # m


class ThirdBodies(NamedTuple):
    body: Annotated[Ints, "k"]
    source: Annotated[Ints, "k"]  # 0 sun, 1 moon
    gm: Annotated[Floats, "k"]  # m^3/s^2


class Drags(NamedTuple):
    body: Annotated[Ints, "k"]
    planet: Annotated[Ints, "k"]
    air: Annotated[Ints, "k"]  # EXPONENTIAL or STANDARD
    number: Annotated[Floats, "k", 6]  # c_D A/m, density, altitude, scale height, radius, spin


class Lights(NamedTuple):
    body: Annotated[Ints, "k"]
    planet: Annotated[Ints, "k"]
    number: Annotated[Floats, "k", 3]  # c_R A/m, radius, pressure


class ParticleGroups(NamedTuple):
    particles: Particles
    relativity: RelativityArrays
    zonals: Zonals
    figures: Figures
    tides: Tides
    points: Points
    third_bodies: ThirdBodies
    drags: Drags
    lights: Lights


class Lanes(NamedTuple):
    """Scratch; base + delta is the position, so that differences of neighbours keep their digits."""

    time: Annotated[Floats, "LANES"]  # s
    base: Annotated[Floats, "n", 3]  # m
    delta: Annotated[Floats, "n", 3, "LANES"]  # m
    velocity: Annotated[Floats, "n", 3, "LANES"]  # m/s
    acceleration: Annotated[Floats, "n", 3, "LANES"]  # m/s^2
    newton: Annotated[Floats, "n", 3, "LANES"]  # m/s^2, before the post-Newtonian terms
    potential: Annotated[Floats, "n", "LANES"]  # m^2/s^2
    speed: Annotated[Floats, "n", "LANES"]  # m^2/s^2, squared
    pole: Annotated[Floats, 3, "LANES"]  # of the body whose zonal harmonics act
    axes: Annotated[Floats, 3, 3]  # rows: body axes
    # of the steps of a leg of Gauss's method, whose stage accelerations are `acceleration`
    old: Annotated[Floats, "n", 3, "LANES"]  # m/s^2, stage accelerations of the step before
    fixed: Annotated[Floats, "n", 3, "LANES"]  # m, the part of delta that no iteration changes
    start: Annotated[Floats, "n", 3, "LANES"]  # m/s, the velocity that the step began with, in every lane
    zero: Annotated[Floats, "n", 3, "LANES"]
    table: Annotated[Floats, "LANES", "LANES"]  # weights of the extrapolation
    lines: Annotated[Floats, 4, "LANES"]


class ParticleScratch(NamedTuple):
    lanes: Lanes


def particle_scratch(n: int) -> ParticleScratch:
    """Allocate the scratch of one run; what has lanes lies where packed instructions may load and store."""
    return ParticleScratch(in_one_room(empty(Lanes, n=n, LANES=LANES)))


ParticleModel = handle_class(__name__, "ParticleModel", ParticleGroups)
ParticleWork = handle_class(__name__, "ParticleWork", ParticleScratch, LANES=LANES)
