"""Shapes of the plane (mbs_ref.kernels.rigid.shapes): lines, and what they share with space."""

import math

from mbs_ref.kernels.contact.laws import ENDS_CAPPED, ENDS_OPEN, PAIR_FLAT, PAIR_ROUND, PAIR_SPROCKET
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.planar.marks import turned
from mbs_ref.kernels.planar.vectors import dot, over, perpendicular, plus, times
from mbs_ref.kernels.rigid.shapes import Surface, on_round, tooth_gap, tooth_wall


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
        return Surface(distance - radius, outward, -math.inf, radius, held)
    return Surface(above - radius, normal, -math.inf, radius, held)


@bare
def surface(model, work, k, x):
    pairs = model.contact_pairs
    a, b = pairs.a[k], pairs.b[k]
    if pairs.kind[k] == PAIR_ROUND:
        return on_round(work, pairs, k, x, (0.0, 1.0), 0.0)
    direction = turned(work, b, pairs.axes[k, 0])
    if pairs.kind[k] == PAIR_SPROCKET:
        return tooth_wall(pairs, k, x, direction, 0.0)
    motion = work.kinematics.motion
    return _on_line(pairs, k, x, direction, pairs.radius[k] * (motion[a, 3] - motion[b, 3]))


@bare
def outwards(model, work, k, x):
    pairs = model.contact_pairs
    direction = turned(work, pairs.b[k], pairs.axes[k, 0])
    if pairs.kind[k] == PAIR_FLAT:
        return times(math.copysign(1.0, dot(x, direction)), direction)
    return tooth_gap(pairs, k, x, direction)


slip = bare(lambda n, u, closing: n[1] * u[0] - n[0] * u[1])
