"""The arrays of a compiled scene of particles, one group a field; a field that is not in use is empty."""

# Groups are filled from lists of arrays whose length the checker cannot see.
# pyright: reportCallIssue=false

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.handles import accessor

LANES = 8  # instants evaluated side by side: the stages of a Gauss step, or one instant repeated


class Particles(NamedTuple):
    gm: np.ndarray  # (n,) m^3/s^2
    radius: np.ndarray  # (n,) m
    gravity: np.ndarray  # (3,) m/s^2
    epoch: np.ndarray  # (1,) s past J2000 TDB at t = 0
    uses_velocity: np.ndarray  # (1,) int: whether an acceleration depends on velocities


class RelativityArrays(NamedTuple):
    form: np.ndarray  # (1,) int: 0 none, 1 central, 2 eih
    inverse_c2: np.ndarray  # (1,) s^2/m^2


class Zonals(NamedTuple):
    body: np.ndarray  # (k,) int
    radius: np.ndarray  # (k,) m
    harmonic: np.ndarray  # (k, 5) J2 .. J6
    precesses: np.ndarray  # (k,) int
    axis: np.ndarray  # (k, 3)


class Figures(NamedTuple):
    body: np.ndarray  # (k,) int
    radius: np.ndarray  # (k,) m
    j2: np.ndarray  # (k,)
    c22: np.ndarray  # (k,)


class Tides(NamedTuple):
    body: np.ndarray  # (k,) int
    raiser: np.ndarray  # (k,) int
    radius: np.ndarray  # (k,) m
    love: np.ndarray  # (k,)
    lag: np.ndarray  # (k,) s
    spin: np.ndarray  # (k, 3) rad/s


class Points(NamedTuple):
    """Fixed attractors: the ring."""

    gm: np.ndarray  # (k,) m^3/s^2
    place: np.ndarray  # (k, 3) m


class ThirdBodies(NamedTuple):
    body: np.ndarray  # (k,) int
    source: np.ndarray  # (k,) int: 0 sun, 1 moon
    gm: np.ndarray  # (k,) m^3/s^2


class Drags(NamedTuple):
    body: np.ndarray  # (k,) int
    center: np.ndarray  # (k,) int
    number: np.ndarray  # (k, 6) c_D A/m, density, altitude, scale height, radius, spin


class Lights(NamedTuple):
    body: np.ndarray  # (k,) int
    center: np.ndarray  # (k,) int
    number: np.ndarray  # (k, 3) c_R A/m, radius, pressure


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

    time: np.ndarray  # (LANES,) s
    base: np.ndarray  # (n, 3) m
    delta: np.ndarray  # (n, 3, LANES) m
    velocity: np.ndarray  # (n, 3, LANES) m/s
    acceleration: np.ndarray  # (n, 3, LANES) m/s^2
    newton: np.ndarray  # (n, 3, LANES) m/s^2, before the post-Newtonian terms
    potential: np.ndarray  # (n, LANES) m^2/s^2
    speed: np.ndarray  # (n, LANES) m^2/s^2, squared
    pair: np.ndarray  # (12, LANES) scratch of one pair
    axes: np.ndarray  # (3, 3) rows: body axes


class ParticleScratch(NamedTuple):
    lanes: Lanes


def floats(*shape: int) -> np.ndarray:
    return np.zeros(shape)


def integers(*shape: int) -> np.ndarray:
    return np.zeros(shape, dtype=np.int64)


def particle_scratch(n: int) -> ParticleScratch:
    """Allocate the scratch of one run."""
    wide = [floats(n, 3, LANES) for _ in range(4)]
    return ParticleScratch(
        Lanes(floats(LANES), floats(n, 3), *wide, floats(n, LANES), floats(n, LANES), floats(12, LANES), floats(3, 3))
    )


def empty_groups() -> ParticleGroups:
    """Return groups without bodies and fields."""
    return ParticleGroups(
        Particles(floats(0), floats(0), floats(3), floats(1), integers(1)),
        RelativityArrays(integers(1), floats(1)),
        Zonals(integers(0), floats(0), floats(0, 5), integers(0), floats(0, 3)),
        Figures(integers(0), floats(0), floats(0), floats(0)),
        Tides(integers(0), integers(0), floats(0), floats(0), floats(0), floats(0, 3)),
        Points(floats(0), floats(0, 3)),
        ThirdBodies(integers(0), integers(0), floats(0)),
        Drags(integers(0), integers(0), floats(0, 6)),
        Lights(integers(0), integers(0), floats(0, 3)),
    )


_EMPTY = empty_groups()
particles_of = accessor(_EMPTY, "particles")
relativity_of = accessor(_EMPTY, "relativity")
zonals_of = accessor(_EMPTY, "zonals")
figures_of = accessor(_EMPTY, "figures")
tides_of = accessor(_EMPTY, "tides")
points_of = accessor(_EMPTY, "points")
third_bodies_of = accessor(_EMPTY, "third_bodies")
drags_of = accessor(_EMPTY, "drags")
lights_of = accessor(_EMPTY, "lights")
lanes_of = accessor(particle_scratch(0), "lanes")
