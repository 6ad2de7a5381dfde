"""Shapes that touch: where and how a circle or sphere of body a meets a shape of body b.

gap = n . (c - o) - r with n fixed in body b for a line or plane, gap = |c - o| - r for two circles or spheres.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.marks import gap_between, rate_between


class Surface(NamedTuple):
    """The point of a surface that is nearest to the centre of a circle or sphere."""

    gap: Any  # m
    normal: Any  # outwards
    beyond: Any  # m, excess over open ends; -inf without any
    back: Any  # m, from the centre against the normal to the point of contact
    held: Any  # what sticks: in the plane the place rolled and slid along a line (m), in space the two edges


class Touch(NamedTuple):
    """Where and how two shapes meet."""

    gap: Any  # m
    closing: Any  # m/s, the gap's rate
    beyond: Any  # m, excess over open ends; -inf without any
    normal: Any  # from b to a; the tangent in the plane is the normal turned by -90 degrees
    slip: Any  # m/s, of a on b: along the tangent, or in the tangent plane as a vector
    arm_a: Any  # m, from the centre of mass of a to the point of contact
    arm_b: Any  # m
    held: Any  # of Surface


@bare
def on_round(work, pairs, k, x, upwards, held):
    """Return the Surface of a circle or sphere; its normal is `upwards` where the centres coincide."""
    distance = math.sqrt(core.dot(work, x, x))
    normal = upwards if distance == 0.0 else core.over(work, x, distance)
    return Surface(distance - pairs.radius[k] - pairs.half[k, 0], normal, -math.inf, pairs.radius[k], held)


@bare
def tooth_gap(pairs, k, x, seat):
    """Return the direction outwards through the tooth gap nearest to a pin at x; `seat` points to the first gap.

    All are pairs of numbers in the sprocket's plane.
    """
    pitch = 2.0 * math.pi / pairs.ends[k]
    turned, ahead = seat[0] * x[1] - seat[1] * x[0], seat[0] * x[0] + seat[1] * x[1]
    angle = pitch * np.round(math.atan2(turned, ahead) / pitch)
    c, s = math.cos(angle), math.sin(angle)
    return c * seat[0] - s * seat[1], s * seat[0] + c * seat[1]


@bare
def tooth_wall(pairs, k, x, seat, held):
    """Return the Surface of the wall of the tooth gap nearest to a pin at x, in the sprocket's plane."""
    outward = tooth_gap(pairs, k, x, seat)
    out = x[0] * outward[0] + x[1] * outward[1] - pairs.half[k, 0]
    side = outward[1] * x[0] - outward[0] * x[1]
    wall = math.copysign(1.0, side)
    cosine, sine = pairs.flank[k]
    width = abs(side)
    if width * sine + out * cosine > 0.0:  # on the straight flank
        offset = width * cosine - out * sine
        du = sine
        dw = -wall * cosine
    else:
        offset = math.sqrt(width * width + out * out)
        du = -out / offset if offset > 0.0 else 1.0
        dw = -side / offset if offset > 0.0 else 0.0
    normal = (du * outward[0] + dw * outward[1], du * outward[1] - dw * outward[0])
    return Surface(pairs.radius[k] - offset, normal, out - pairs.thickness[k], 0.0, held)


@bare
def _places(pairs, work, k):
    """Return the arms of the centre and of the other shape's origin, and the way from this to that."""
    a, b = pairs.a[k], pairs.b[k]
    center, origin = core.turned(work, a, pairs.center[k]), core.turned(work, b, pairs.origin[k])
    return center, origin, gap_between(work, b, a, origin, center)


@bare
def contact_geometry(model, work, k):
    """Return the Touch of a pair."""
    pairs = model.contact_pairs
    a, b = pairs.a[k], pairs.b[k]
    center, _, x = _places(pairs, work, k)
    surface = core.surface(model, work, k, x)
    n = surface.normal
    arm_a = core.minus(work, center, core.times(work, surface.back, n))
    arm_b = core.minus(work, core.plus(work, core.centre(work, a), arm_a), core.centre(work, b))
    u = rate_between(work, b, a, arm_b, arm_a)
    closing = core.dot(work, n, u)
    slip = core.slip(work, n, u, closing)
    return Touch(surface.gap, closing, surface.beyond, n, slip, arm_a, arm_b, surface.held)


@bare
def leaving_ends(model, work, k):
    """Return the rate (m/s) of the excess over open ends."""
    pairs = model.contact_pairs
    center, origin, x = _places(pairs, work, k)
    out = core.outwards(model, work, k, x)
    return core.dot(work, out, rate_between(work, pairs.b[k], pairs.a[k], core.plus(work, x, origin), center))
