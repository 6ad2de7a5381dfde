"""Granules: many rounded shapes that may all touch one another and walls, by one law.

A shape is a core, which is a point, a segment or a box, and all that lies within a radius of it. The depth of two
points is the sum of the radii less their distance. Forces of corners on cores and of edges that cross add up, less what
is counted twice (inclusion and exclusion):

    corners of a on core b + corners of b on core a - corners of a on corners of b + edges on edges - ends of these

so that one point of contact has the law's force once, a flat face has one at each of its corners, and a force that
follows from a potential remains one: the sum is continuous where the nearest features change.
"""

import math

from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.contact.neighbours import refresh_neighbours
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.marks import exchange, magnitude, rate_between

PARALLEL = 1e-12  # -, squared sine of the angle of edges that have no single nearest points
EDGES = 12  # of a box


@bare
def _has_corner(grains, i, corner):
    """Return whether core i has this corner: bit k is its side along axis k, 0 where the core has no length."""
    has = True
    for k in range(grains.half.shape[1]):
        has &= corner >> k & 1 == 0 or grains.half[i, k] > 0.0
    return has


@bare
def _corner(work, grains, i, corner):
    """Return the place (m) of a corner of core i."""
    x = core.centre(work, grains.body[i])
    for k in range(grains.half.shape[1]):
        along = grains.half[i, k] if corner >> k & 1 else -grains.half[i, k]
        x = core.plus(work, x, core.times(work, along, grains.axes[i, k]))
    return x


@bare
def _edge(work, grains, i, edge):
    """Return the middle (m), the direction and half of the length (m, 0 of no edge) of an edge of core i (space)."""
    k = edge // 4
    start = (edge & 1) << (k + 1) % 3 | (edge >> 1 & 1) << (k + 2) % 3
    along, half = core.times(work, 1.0, grains.axes[i, k]), grains.half[i, k]
    middle = core.plus(work, _corner(work, grains, i, start), core.times(work, half, along))
    return middle, along, half if _has_corner(grains, i, start) else 0.0


@bare
def _from_core(work, grains, j, x):
    """Return the distance (m) of a point from core j, negative inside, and the direction away from it."""
    y = core.minus(work, x, core.centre(work, grains.body[j]))
    away, most, face = y, -math.inf, y
    for k in range(grains.half.shape[1]):
        along, half = core.dot(work, y, grains.axes[j, k]), grains.half[j, k]
        away = core.minus(work, away, core.times(work, min(max(along, -half), half), grains.axes[j, k]))
        if abs(along) - half > most:
            most, face = abs(along) - half, core.times(work, math.copysign(1.0, along), grains.axes[j, k])
    distance = magnitude(work, away)
    if most < 0.0 or distance == 0.0:
        return most, face
    return distance, core.over(work, away, distance)


@bare
def _press(work, grains, i, x, b, n, gap, sign):
    """Add `sign` times the force of grain i, by the point x (m) of its core, on body b; n points from b to it."""
    a = grains.body[i]
    inward = core.times(work, -grains.radius[i], n)
    arm_a = core.plus(work, core.minus(work, x, core.centre(work, a)), inward)
    arm_b = core.minus(work, core.plus(work, x, inward), core.centre(work, b))
    u = rate_between(work, b, a, arm_b, arm_a)
    closing = core.dot(work, n, u)
    normal = law.normal_force(grains, grains, 0, -gap, -closing)
    if normal < 0.0 and grains.release[0] == law.RELEASE_FORCE:
        return
    force = core.times(work, sign * normal, n)
    if grains.coefficient[0] > 0.0:
        slip = core.minus(work, u, core.times(work, closing, n))
        scale = sign * law.drag(grains, 0, normal, magnitude(work, slip))
        force = core.plus(work, force, core.times(work, scale, slip))
    exchange(work, a, arm_a, b, arm_b, force)


@bare
def _press_points(work, grains, i, x, j, y, sign):
    """Add `sign` times the force between points of two cores (m)."""
    away = core.minus(work, x, y)
    distance, reach = magnitude(work, away), grains.radius[i] + grains.radius[j]
    if 0.0 < distance < reach:
        _press(work, grains, i, x, grains.body[j], core.over(work, away, distance), distance - reach, sign)


@bare
def _press_corners(work, grains, i, j, once):
    """Add the forces of the corners of core i on core j, less those on its corners unless `once`."""
    corners, reach = 1 << grains.half.shape[1], grains.radius[i] + grains.radius[j]
    for corner in range(corners):
        if not _has_corner(grains, i, corner):
            continue
        x = _corner(work, grains, i, corner)
        distance, n = _from_core(work, grains, j, x)
        if distance >= reach:
            continue
        _press(work, grains, i, x, grains.body[j], n, distance - reach, 1.0)
        for other in range(0 if once else corners):
            if _has_corner(grains, j, other):
                _press_points(work, grains, i, x, j, _corner(work, grains, j, other), -1.0)


@bare
def _press_crossing(work, grains, i, one, j, other):
    """Add the force of two edges whose nearest points lie between their ends, less that of an end nearest to it."""
    (m, u, g), (o, v, h) = one, other
    w = core.minus(work, m, o)
    c, d, e = core.dot(work, u, v), core.dot(work, u, w), core.dot(work, v, w)
    sine = 1.0 - c * c
    s, t = (c * e - d) / max(sine, PARALLEL), (e - c * d) / max(sine, PARALLEL)
    if sine <= PARALLEL or abs(s) >= g or abs(t) >= h:
        return
    x, y = core.plus(work, m, core.times(work, s, u)), core.plus(work, o, core.times(work, t, v))
    away, reach = core.minus(work, x, y), grains.radius[i] + grains.radius[j]
    distance = magnitude(work, away)
    if not 0.0 < distance < reach:
        return
    side = -1.0 if _from_core(work, grains, j, x)[0] < 0.0 else 1.0  # negative where an edge is inside the other core
    n = core.over(work, away, side * distance)
    _press(work, grains, i, x, grains.body[j], n, side * distance - reach, 1.0)
    least = math.inf
    for end in range(4):
        q = h if end % 2 else -h
        p = min(max(c * q - d, -g), g)
        if end < 2:
            p = g if end % 2 else -g
            q = min(max(e + c * p, -h), h)
        at, there = core.plus(work, m, core.times(work, p, u)), core.plus(work, o, core.times(work, q, v))
        gap = core.minus(work, at, there)
        if core.dot(work, gap, gap) < least:
            least, x, y = core.dot(work, gap, gap), at, there
    _press_points(work, grains, i, x, j, y, -1.0)


@bare
def _press_edges(work, grains, i, j):
    """Add the forces of all edges that cross (space)."""
    near = grains.radius[i] + grains.reach[j]
    for edge in range(EDGES):
        one = _edge(work, grains, i, edge)
        apart = core.minus(work, core.centre(work, grains.body[j]), one[0])
        along = min(max(core.dot(work, apart, one[1]), -one[2]), one[2])
        apart = core.minus(work, apart, core.times(work, along, one[1]))
        if one[2] == 0.0 or core.dot(work, apart, apart) >= near * near:
            continue
        for other in range(EDGES):
            _press_crossing(work, grains, i, one, j, _edge(work, grains, j, other))


@bare
def _touch(work, grains, i, j):
    """Add the forces of two grains that may overlap."""
    place, other = core.centre(work, grains.body[i]), core.centre(work, grains.body[j])
    x, reach = core.minus(work, place, other), grains.reach[i] + grains.reach[j]
    is_point, is_other = grains.reach[i] == grains.radius[i], grains.reach[j] == grains.radius[j]
    if core.dot(work, x, x) >= reach * reach:
        return
    if is_point and is_other:
        _press_points(work, grains, i, place, j, other, 1.0)
    elif is_point:
        _press_corners(work, grains, i, j, True)
    elif is_other:
        _press_corners(work, grains, j, i, True)
    else:
        _press_corners(work, grains, i, j, True)
        _press_corners(work, grains, j, i, False)
        if grains.half.shape[1] == 3:  # in the plane two edges do not cross before a corner is inside
            _press_edges(work, grains, i, j)


@bare
def _touch_walls(work, grains, i, ground):
    for w in range(grains.offset.shape[0]):
        n = core.times(work, 1.0, grains.normal[w])  # as a tuple
        if core.dot(work, core.centre(work, grains.body[i]), n) - grains.offset[w] >= grains.reach[i]:
            continue
        for corner in range(1 << grains.half.shape[1]):
            if _has_corner(grains, i, corner):
                x = _corner(work, grains, i, corner)
                gap = core.dot(work, x, n) - grains.offset[w] - grains.radius[i]
                if gap < 0.0:
                    _press(work, grains, i, x, ground, n, gap, 1.0)


@jit
def rigid_apply_granules(model, work):
    grains, ground = model.granules, model.bodies.mass.shape[0]
    for i in range(grains.body.shape[0]):
        place = core.centre(work, grains.body[i])
        for c in range(len(place)):
            grains.place[i, c] = place[c]
            if grains.reach[i] > grains.radius[i]:
                axis = core.turned(work, grains.body[i], grains.unit[c])
                for k in range(len(place)):
                    grains.axes[i, c, k] = axis[k]
        _touch_walls(work, grains, i, ground)
    refresh_neighbours(grains)
    for i in range(grains.body.shape[0]):
        if grains.overflow[0] == 1:
            for j in range(i + 1, grains.body.shape[0]):
                _touch(work, grains, i, j)
        else:
            for p in range(grains.first[i], grains.first[i + 1]):
                _touch(work, grains, i, grains.near[p])
