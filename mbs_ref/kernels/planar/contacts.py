"""Shapes that touch in the plane: where and how they meet, and the rows of their gap.

gap = n . (c - o) - r with n fixed in body b for a line, gap = |c - o| - r for two circles.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels.contact.laws import ENDS_CAPPED, ENDS_OPEN, PAIR_FLAT, PAIR_ROUND
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.marks import turned
from mbs_ref.kernels.planar.vectors import cross, dot, left, minus, over, plus, rotated, times
from mbs_ref.kernels.rigid.geometry import Touch
from mbs_ref.kernels.rigid.marks import gap_between, rate_between
from mbs_ref.kernels.rigid.model import contact_pairs_of, kinematics_of


class Surface(NamedTuple):
    """The point of a surface that is nearest to a circle's centre."""

    gap: Any  # m
    normal: Any  # outwards, a pair along world axes
    beyond: Any  # m, excess over open ends
    along: Any  # m, place along a line


@bare
def _on_line(pairs, k, x, tangent):
    """Return the Surface that a line, a segment or a capped segment shows at x."""
    normal = left(tangent)
    along, above = dot(x, tangent), dot(x, normal)
    beyond = abs(along) - pairs.half[k, 0]
    if pairs.ends[k] == ENDS_OPEN:
        return Surface(above - pairs.radius[k], normal, beyond, along)
    if pairs.ends[k] == ENDS_CAPPED and beyond > 0.0:
        px = math.copysign(beyond, along)
        distance = math.sqrt(px * px + above * above)
        outward = over(plus(times(px, tangent), times(above, normal)), distance)
        return Surface(distance - pairs.radius[k], outward, -1.0, along)
    return Surface(above - pairs.radius[k], normal, -1.0, along)


@bare
def _on_circle(pairs, k, x):
    distance = math.sqrt(dot(x, x))
    if distance == 0.0:
        return Surface(-pairs.radius[k] - pairs.half[k, 0], (0.0, 1.0), -1.0, 0.0)
    return Surface(distance - pairs.radius[k] - pairs.half[k, 0], over(x, distance), -1.0, 0.0)


@bare
def _through_gap(pairs, k, x, seat):
    """Return the direction outwards through the tooth gap nearest to a pin at x; `seat` points to the first gap."""
    pitch = 2.0 * math.pi / pairs.ends[k]
    angle = pitch * np.round(math.atan2(cross(seat, x), dot(seat, x)) / pitch)
    return rotated(math.cos(angle), math.sin(angle), seat)


@bare
def _in_sprocket(pairs, k, x, seat):
    """Return the Surface of the wall of the tooth gap nearest to a pin at x."""
    outward = _through_gap(pairs, k, x, seat)
    out = dot(x, outward) - pairs.half[k, 0]
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
    return Surface(pairs.radius[k] - offset, normal, out - pairs.thickness[k], 0.0)


@bare
def _places(pairs, work, k):
    """Return the arms of the circle's centre and of the other shape's origin, and the way from this to that."""
    a, b = pairs.a[k], pairs.b[k]
    center, origin = turned(work, a, pairs.center[k]), turned(work, b, pairs.origin[k])
    return center, origin, gap_between(work, b, a, origin, center)


@bare
def contact_geometry(model, work, k):
    """Return the Touch of a pair."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    center, _, x = _places(pairs, work, k)
    back = pairs.radius[k]
    rolled = 0.0
    if pairs.kind[k] == PAIR_ROUND:
        surface = _on_circle(pairs, k, x)
    else:
        direction = turned(work, b, pairs.axes[k, 0])
        if pairs.kind[k] == PAIR_FLAT:
            surface = _on_line(pairs, k, x, direction)
            rolled = back * (kin.motion[a, 3] - kin.motion[b, 3])
        else:
            surface = _in_sprocket(pairs, k, x, direction)
            back = 0.0
    n = surface.normal
    arm_a = minus(center, times(back, n))
    arm_b = minus(plus(kin.pose[a], arm_a), kin.pose[b])
    u = rate_between(work, b, a, arm_b, arm_a)
    slip = n[1] * u[0] - n[0] * u[1]
    return Touch(surface.gap, dot(n, u), surface.beyond, n, slip, arm_a, arm_b, surface.along + rolled)


@bare
def leaving_ends(model, work, k):
    """Return the rate (m/s) of the excess over open ends."""
    pairs = contact_pairs_of(model)
    center, origin, x = _places(pairs, work, k)
    outward = turned(work, pairs.b[k], pairs.axes[k, 0])
    if pairs.kind[k] == PAIR_FLAT:
        outward = times(math.copysign(1.0, dot(x, outward)), outward)
    else:
        outward = _through_gap(pairs, k, x, outward)
    return dot(outward, rate_between(work, pairs.b[k], pairs.a[k], plus(x, origin), center))
