"""Shapes of the plane (mbs_ref.kernels.rigid.shapes): lines, circles and the walls between a sprocket's teeth."""

import math

import numpy as np

from mbs_ref.kernels.contact.laws import ENDS_CAPPED, ENDS_OPEN, PAIR_FLAT, PAIR_ROUND, PAIR_SPROCKET
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.marks import turned
from mbs_ref.kernels.planar.vectors import cross, dot, over, perpendicular, plus, rotated, times
from mbs_ref.kernels.rigid.shapes import Surface, on_round


@bare
def _on_line(pairs, k, x, tangent, rolled):
    """Return the Surface of a line, a segment or a capped segment."""
    normal, radius = perpendicular(tangent), pairs.radius[k]
    along, above = dot(x, tangent), dot(x, normal)
    held, beyond = along + rolled, abs(along) - pairs.half[k, 0]
    if pairs.ends[k] == ENDS_OPEN:
        return Surface(above - radius, normal, beyond, radius, held)
    if pairs.ends[k] == ENDS_CAPPED and beyond > 0.0:
        px = math.copysign(beyond, along)
        distance = math.sqrt(px * px + above * above)
        outward = over(plus(times(px, tangent), times(above, normal)), distance)
        return Surface(distance - radius, outward, -1.0, radius, held)
    return Surface(above - radius, normal, -1.0, radius, held)


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
    return Surface(pairs.radius[k] - offset, normal, out - pairs.thickness[k], 0.0, 0.0)


@bare
def surface(model, work, k, x):
    pairs = model.contact_pairs
    a, b = pairs.a[k], pairs.b[k]
    if pairs.kind[k] == PAIR_ROUND:
        return on_round(work, pairs, k, x, (0.0, 1.0), 0.0)
    direction = turned(work, b, pairs.axes[k, 0])
    if pairs.kind[k] == PAIR_SPROCKET:
        return _in_sprocket(pairs, k, x, direction)
    motion = work.kinematics.motion
    return _on_line(pairs, k, x, direction, pairs.radius[k] * (motion[a, 3] - motion[b, 3]))


@bare
def outwards(model, work, k, x):
    pairs = model.contact_pairs
    direction = turned(work, pairs.b[k], pairs.axes[k, 0])
    if pairs.kind[k] == PAIR_FLAT:
        return times(math.copysign(1.0, dot(x, direction)), direction)
    return _through_gap(pairs, k, x, direction)


@bare
def slip(n, u, closing):
    return n[1] * u[0] - n[0] * u[1]
