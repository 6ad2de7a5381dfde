"""Shapes that touch in space: where and how they meet, and the rows of their gap.

gap = n . (c - o) - r with n fixed in body b for a plane, gap = |c - o| - r for two spheres.
"""

from __future__ import annotations

import math

from mbs_ref.kernels.contact.laws import ENDS_CAPPED, ENDS_OPEN, PAIR_FLAT
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid.geometry import Touch
from mbs_ref.kernels.rigid.marks import rate_between
from mbs_ref.kernels.rigid.model import contact_pairs_of, kinematics_of
from mbs_ref.kernels.spatial.vectors import cross, dot, minus, over, plus, times, turn


@bare
def _on_plane(pairs, k, x, e, f, n):
    """Return the gap, the outward normal and how far the centre is beyond an open end."""
    along, across, above = dot(x, e), dot(x, f), dot(x, n)
    past_e = abs(along) - pairs.half[k, 0]
    past_f = abs(across) - pairs.half[k, 1]
    if pairs.ends[k] == ENDS_OPEN:
        return above - pairs.radius[k], n, max(past_e, past_f)
    if pairs.ends[k] == ENDS_CAPPED and (past_e > 0.0 or past_f > 0.0):
        p = math.copysign(max(past_e, 0.0), along)
        q = math.copysign(max(past_f, 0.0), across)
        distance = math.sqrt(p * p + q * q + above * above)
        outward = over(plus(plus(times(p, e), times(q, f)), times(above, n)), distance)
        return distance - pairs.radius[k], outward, -1.0
    return above - pairs.radius[k], n, -1.0


@bare
def _on_sphere(pairs, k, x, n):
    distance = math.sqrt(dot(x, x))
    if distance == 0.0:
        return -pairs.radius[k] - pairs.half[k, 0], n, -1.0
    return distance - pairs.radius[k] - pairs.half[k, 0], over(x, distance), -1.0


@bare
def _places(pairs, kin, k):
    """Return the way between the bodies, the arm of the sphere's centre, and the way to it from the other's origin."""
    a, b = pairs.a[k], pairs.b[k]
    c = turn(kin.turned[a], pairs.center[k])
    apart = minus(kin.position[a], kin.position[b])
    return apart, c, minus(plus(apart, c), turn(kin.turned[b], pairs.origin[k]))


@bare
def contact_geometry(model, work, k):
    """Return the Touch of a pair."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    apart, c, x = _places(pairs, kin, k)
    e = turn(kin.turned[b], pairs.axes[k, 0])
    f = turn(kin.turned[b], pairs.axes[k, 1])
    n = turn(kin.turned[b], pairs.axes[k, 2])
    if pairs.kind[k] == PAIR_FLAT:
        gap, n, beyond = _on_plane(pairs, k, x, e, f, n)
    else:
        gap, n, beyond = _on_sphere(pairs, k, x, n)
    on_a = minus(c, times(pairs.radius[k], n))
    on_b = plus(apart, on_a)
    u = rate_between(work, b, a, on_b, on_a)
    closing = dot(n, u)
    return Touch(gap, closing, beyond, n, minus(u, times(closing, n)), on_a, on_b, (e, f))


@bare
def leaving_ends(model, work, k):
    """Return the rate (m/s) of the excess over open ends of a plane."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    apart, c, x = _places(pairs, kin, k)
    e, f = turn(kin.turned[b], pairs.axes[k, 0]), turn(kin.turned[b], pairs.axes[k, 1])
    along, across = dot(x, e), dot(x, f)
    u = minus(kin.velocity[a], kin.velocity[b])
    u = minus(plus(u, cross(kin.omega[a], c)), cross(kin.omega[b], plus(apart, c)))
    if abs(along) - pairs.half[k, 0] >= abs(across) - pairs.half[k, 1]:
        return math.copysign(1.0, along) * dot(u, e)
    return math.copysign(1.0, across) * dot(u, f)
