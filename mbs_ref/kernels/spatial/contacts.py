"""Shapes of space (mbs_ref.kernels.rigid.shapes): planes, rectangles, and what they share with the plane."""

import math

from mbs_ref.kernels.contact.laws import ENDS_CAPPED, ENDS_OPEN, PAIR_FLAT, PAIR_ROUND
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid.shapes import Surface, on_round, tooth_gap, tooth_wall
from mbs_ref.kernels.spatial.marks import turned
from mbs_ref.kernels.spatial.vectors import dot, minus, over, plus, times


@bare
def _on_plane(pairs, k, x, edges, n):
    """Return the Surface of a plane, a rectangle or a capped rectangle."""
    (e, f), radius = edges, pairs.radius[k]
    along, across, above = dot(x, e), dot(x, f), dot(x, n)
    past_e, past_f = abs(along) - pairs.half[k, 0], abs(across) - pairs.half[k, 1]
    if pairs.ends[k] == ENDS_OPEN:
        return Surface(above - radius, n, max(past_e, past_f), radius, edges)
    if pairs.ends[k] == ENDS_CAPPED and (past_e > 0.0 or past_f > 0.0):
        p = math.copysign(max(past_e, 0.0), along)
        q = math.copysign(max(past_f, 0.0), across)
        distance = math.sqrt(p * p + q * q + above * above)
        outward = over(plus(plus(times(p, e), times(q, f)), times(above, n)), distance)
        return Surface(distance - radius, outward, -math.inf, radius, edges)
    return Surface(above - radius, n, -math.inf, radius, edges)


@bare
def _edges(work, pairs, k):
    return turned(work, pairs.b[k], pairs.axes[k, 0]), turned(work, pairs.b[k], pairs.axes[k, 1])


@bare
def surface(model, work, k, x):
    pairs = model.contact_pairs
    n = turned(work, pairs.b[k], pairs.axes[k, 2])
    if pairs.kind[k] == PAIR_FLAT:
        return _on_plane(pairs, k, x, _edges(work, pairs, k), n)
    e, f = _edges(work, pairs, k)
    if pairs.kind[k] == PAIR_ROUND:
        return on_round(work, pairs, k, x, n, (e, f))
    wall = tooth_wall(pairs, k, (dot(x, e), dot(x, f)), (1.0, 0.0), (e, f))
    normal = plus(times(wall.normal[0], e), times(wall.normal[1], f))
    return Surface(wall.gap, normal, wall.beyond, wall.back, wall.held)


@bare
def outwards(model, work, k, x):
    pairs = model.contact_pairs
    e, f = _edges(work, pairs, k)
    along, across = dot(x, e), dot(x, f)
    if pairs.kind[k] != PAIR_FLAT:
        gap = tooth_gap(pairs, k, (along, across), (1.0, 0.0))
        return plus(times(gap[0], e), times(gap[1], f))
    if abs(along) - pairs.half[k, 0] >= abs(across) - pairs.half[k, 1]:
        return times(math.copysign(1.0, along), e)
    return times(math.copysign(1.0, across), f)


slip = bare(lambda n, u, closing: minus(u, times(closing, n)))
