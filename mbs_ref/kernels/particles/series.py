"""Taylor series of particles under Newton's attraction, J2 of bodies with one axis in common, and uniform gravity.

With d the way from one body of a pair to the other, h its part along the axis p, and s = d.d, a unit gm attracts by
    f = -A d - 2 b h s^(-5/2) p,  A = s^(-3/2) + b s^(-5/2) - 5 b h^2 s^(-7/2),
where b = 3/2 (J2 R^2 of both bodies): `bulge` of mbs_ref.kernels.particles.pair. Coefficients follow by recurrences:
A. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99, sec. 2; that of powers is theirs of s^a.

A vector is one packed number (mbs_ref.kernels.algebra.lanes): x, y, z, and its part along the axis in two more lanes.
The powers of s stand in the lanes of what they are multiplied by, so that a product of series has one multiplication a
term: s^(-3/2) in the first lane, s^(-5/2) in that of h, s^(-7/2) in that of h^2.
"""

import sys
from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels import series as interface
from mbs_ref.kernels.algebra.lanes import (
    WIDTH,
    chosen_in_lanes,
    in_every_lane,
    in_lanes,
    lane_of,
    larger,
    largest_of_lanes,
)
from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import handle_class
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.jit import bare, placed
from mbs_ref.kernels.particles.pair import touching

HEIGHT, SQUARED = 3, 4  # lanes of h and of h^2
GAP, SQUARE, SLOPE, POWER, MIXED, PULL = range(6)  # series of a pair: d, s, k times coefficient k of s, ...
POLE, GRAVITY, IN_SQUARED, RISE, CUBE, FIFTH, SEVENTH = range(7)  # numbers of each lane
EXPONENTS = np.array([-1.5, -1.5, -1.5, -2.5, -3.5, 0.0, 0.0, 0.0])  # of s, in each lane


class Orbits(NamedTuple):
    """Bodies and pairs of them, then the scratch of a run. Coefficients of one order lie side by side."""

    gm: Annotated[Floats, "n"]  # m^3/s^2
    radius: Annotated[Floats, "n"]  # m
    falls: Annotated[Ints, "n"]  # 1 where another body attracts it
    first: Annotated[Ints, "pairs"]
    second: Annotated[Ints, "pairs"]
    bulge: Annotated[Floats, "pairs"]  # m^2
    fixed: Annotated[Floats, 7, "WIDTH"]
    place: Annotated[Floats, "n", "orders", "WIDTH"]  # m/s^k
    pair: Annotated[Floats, "pairs", "orders", 6, "WIDTH"]
    end: Annotated[Floats, 3, "WIDTH"]  # of a body later in the step: place, velocity, acceleration
    atol: Annotated[Floats, "n", 2, "WIDTH"]  # m, m/s; infinite beyond x, y and z
    scale: Annotated[Floats, "n", 2, "WIDTH"]  # 1 over the tolerances of a step


class OrbitGroups(NamedTuple):
    series: Orbits


ExpandedOrbits = handle_class(__name__, "ExpandedOrbits", OrbitGroups, WIDTH=WIDTH, orders=interface.MAX_ORDER + 2)


@placed
def start_at(s, y, rtol):
    """Let a step start at places and velocities y."""
    n, place, atol, scale = s.gm.shape[0], in_lanes(s.place), in_lanes(s.atol), in_lanes(s.scale)
    for b in range(n):
        for order in range(2):
            along, first = 0.0, 3 * (order * n + b)
            for c in range(3):
                s.place[b, order, c] = y[first + c]
                along += y[first + c] * s.fixed[POLE, c]
            s.place[b, order, HEIGHT] = s.place[b, order, SQUARED] = along
            scale[b, order] = 1.0 / (atol[b, order] + rtol * abs(place[b, order]))


@placed
def evaluate(s, order, h, y, dy):
    """Write the state and its rate at h (s) from the start."""
    place, end, n = in_lanes(s.place), in_lanes(s.end), s.gm.shape[0]
    for b in range(n):
        rise = rate = acceleration = in_every_lane(0.0)
        for k in range(order + 1 if s.falls[b] else 2, 1, -1):
            acceleration = acceleration * h + (k * (k - 1.0)) * place[b, k]
            rate = rate * h + k * place[b, k]
            rise = rise * h + place[b, k]
        end[0] = place[b, 0] + h * (place[b, 1] + h * rise)
        end[1], end[2] = place[b, 1] + h * rate, acceleration
        for c in range(3):
            k = 3 * b + c
            y[k], y[3 * n + k], dy[k], dy[3 * n + k] = s.end[0, c], s.end[1, c], s.end[1, c], s.end[2, c]


@placed
def take_tolerances(s, atol):
    """Keep the absolute tolerances of places and velocities."""
    n = s.gm.shape[0]
    for b in range(n):
        for order in range(2):
            for c in range(3):
                s.atol[b, order, c] = atol[3 * (order * n + b) + c]


@placed
def largest_term(s, k):
    """Return the largest coefficient k of a place, or of a velocity, over its tolerance."""
    place, scale, largest = in_lanes(s.place), in_lanes(s.scale), in_every_lane(0.0)
    for b in range(s.gm.shape[0]):
        if s.falls[b]:
            largest = larger(abs(place[b, k]) * scale[b, 0], largest)
            largest = larger(abs((k + 1.0) * place[b, k + 1]) * scale[b, 1], largest)
    return largest_of_lanes(largest)


@placed
def expand(s, order):
    """Fill the coefficients up to `order` + 1 from places and velocities at the start."""
    place, pair, fixed, gm, zero = in_lanes(s.place), in_lanes(s.pair), in_lanes(s.fixed), s.gm, in_every_lane(0.0)
    for b in range(gm.shape[0]):
        place[b, 2] = 0.5 * fixed[GRAVITY]
        for k in range(3, order + 2 if s.falls[b] else 3):
            place[b, k] = zero
    for k in range(order):
        lead = 1.0 / ((k + 1.0) * (k + 2.0))
        for p in range(s.first.shape[0]):
            i, j = s.first[p], s.second[p]
            force = lead * _attraction(pair[p], k, place[j, k] - place[i, k], s.bulge[p], fixed)
            if gm[i] > 0.0:
                place[j, k + 2] += gm[i] * force
            if gm[j] > 0.0:
                place[i, k + 2] -= gm[j] * force


@placed
def _attraction(own, k, gap, bulge, fixed):
    """Return coefficient k of a pair's f, by its coefficient `gap` of d and all before; fill those of its series."""
    square = low = high = mixed = force = in_every_lane(0.0)
    for m in range(1, k):
        square += own[m, GAP] * own[k - m, GAP]
        force += own[m, PULL] * own[k - m, GAP]
        low += own[m, SQUARE] * own[k - m, POWER]
        high += own[m, SLOPE] * own[k - m, POWER]
        mixed += own[m, MIXED] * own[k - m, POWER]
    own[k, GAP] = gap
    square += gap * gap if k == 0 else 2.0 * (own[0, GAP] * gap)
    s = in_every_lane(lane_of(square, 0) + lane_of(square, 1) + lane_of(square, 2))
    both = chosen_in_lanes(fixed[IN_SQUARED], square, gap)
    own[k, SQUARE], own[k, SLOPE], own[k, MIXED] = s, s * float(k), both
    if k == 0:
        inverse = 1.0 / s
        own[0, SLOPE] = inverse  # no coefficient needs what belongs there
        power = inverse * np.sqrt(inverse) * (fixed[CUBE] + inverse * (fixed[FIFTH] + inverse * fixed[SEVENTH]))
        mixed = both * power
    else:
        first = own[0, POWER]
        high, low = high + s * float(k) * first, low + s * first
        power = own[0, SLOPE] * (fixed[RISE] * (1.0 / k) * high - low)
        mixed += own[0, MIXED] * power + both * first
    own[k, POWER] = power
    pull = in_every_lane(5.0 * bulge * lane_of(mixed, SQUARED) - (lane_of(power, 0) + bulge * lane_of(power, HEIGHT)))
    own[k, PULL] = pull
    force += pull * own[0, GAP]
    if k > 0:
        force += own[0, PULL] * gap
    return force - (2.0 * bulge * lane_of(mixed, HEIGHT)) * fixed[POLE]


# Return whether two bodies are closer at y than the sum of their radii.
collided = bare(lambda s, y: touching(s.radius, y, s.radius.shape[0]))


supply((Orbits,), interface, (sys.modules[__name__],))
