"""Pairs of particles, their attraction with 1PN terms, and the stages of a body, at eight instants at once.

Arrays of lanes (mbs_ref.kernels.algebra.lanes) replace loops over instants, which the compiler does not vectorize by
itself, because it cannot know that the arrays do not overlap.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import in_every_lane, larger, largest_of_lanes
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.spatial.marks import add, dot, minus, plus, times

# Return the vector of body i in an array of lanes (n, 3).
of_body = bare(lambda values, i: (values[i, 0], values[i, 1], values[i, 2]))
# Return base[j] - base[i] (m), equal at all instants.
gap_of = bare(lambda base, i, j: (base[j, 0] - base[i, 0], base[j, 1] - base[i, 1], base[j, 2] - base[i, 2]))


@bare
def apart(base, delta, i, j):
    """Return the way (m) from body i to body j."""
    gap = gap_of(base, i, j)
    return (
        gap[0] + (delta[j, 0] - delta[i, 0]), gap[1] + (delta[j, 1] - delta[i, 1]), gap[2] + (delta[j, 2] - delta[i, 2])
    )  # fmt: skip


@bare
def apart_at(base, delta, i, j, k):
    """Return the way (m) from body i to body j at instant k, of arrays of floats."""
    x, y, z = gap_of(base, i, j)
    return (
        x + (delta[j, 0, k] - delta[i, 0, k]),
        y + (delta[j, 1, k] - delta[i, 1, k]),
        z + (delta[j, 2, k] - delta[i, 2, k]),
    )


@bare
def add_to(out, i, factor, vector):
    """out[i] += factor vector."""
    out[i, 0] += factor * vector[0]
    out[i, 1] += factor * vector[1]
    out[i, 2] += factor * vector[2]


@bare
def share(out, i, j, gm, a):
    """Give body j the acceleration gm_i a and body i the reaction -gm_j a."""
    add_to(out, j, gm[i], a)
    add_to(out, i, -gm[j], a)


@bare
def attract(base, delta, out, i, j, gm):
    """Add gm_j d / r^3 to out[i] and -gm_i d / r^3 to out[j]."""
    d = apart(base, delta, i, j)
    r2 = dot(d, d)
    inverse = 1.0 / (r2 * np.sqrt(r2))
    add_to(out, i, inverse * gm[j], d)
    add_to(out, j, inverse * -gm[i], d)


@bare
def bulge(base, delta, out, i, j, gm, factor, pole):
    """Add what J2 of body i does to body j, and its reaction; `factor` is 3/2 J2 R^2, m^2.

    factor / r^5 [(5 (d.p)^2 / r^2 - 1) d - 2 (d.p) p] with the pole p.
    """
    d = apart(base, delta, i, j)
    r2 = dot(d, d)
    inverse, height = 1.0 / r2, dot(d, pole)
    common = factor * inverse * inverse / np.sqrt(r2)
    along, toward = common * (5.0 * height * height * inverse - 1.0), 2.0 * common * height
    share(out, i, j, gm, minus(times(along, d), times(toward, pole)))


@bare
def _combination(table, source, body, axis, scale):
    """Return scale * source[body, axis, :] @ table; `source` holds floats (n, 3, LANES)."""
    total = in_every_lane(0.0)
    for j in range(LANES):
        total += source[body, axis, j] * scale * table[j]
    return total


@bare
def combine(target, start, table, source, body, axis, scale):
    """Set target[body, axis] = start[body, axis] + scale * source[body, axis, :] @ table, an array of lanes."""
    target[body, axis] = start[body, axis] + _combination(table, source, body, axis, scale)


@bare
def settle(delta, fixed, table, source, body, scale):
    """Set delta[body] = fixed[body] + scale * source[body] @ table.

    Return the largest change of an entry and the largest distance from `fixed`; the first is infinite where an entry
    is not a number.
    """
    change = size = odd = in_every_lane(0.0)
    for c in range(3):
        start = fixed[body, c]
        new = start + _combination(table, source, body, c, scale)
        moved = abs(new - delta[body, c])
        change, size = larger(moved, change), larger(abs(new - start), size)
        odd += moved - moved
        delta[body, c] = new
    return largest_of_lanes(change + odd), largest_of_lanes(size)


@bare
def newton_pairs(gm, base, delta, out):
    """Add gm_j (x_j - x_i) / r^3 over all pairs to `out`."""
    n = gm.shape[0]
    for i in range(n):
        for j in range(i + 1, n):
            if gm[i] != 0.0 or gm[j] != 0.0:
                attract(base, delta, out, i, j, gm)


@bare
def central_relativity(gm, inverse_c2, base, delta, velocity, out):
    """Add the first body's Schwarzschild term: gm/(c^2 r^3) [(4 gm/r - v^2) r + 4 (r.v) v]."""
    for i in range(1, gm.shape[0]):
        d, v = apart(base, delta, 0, i), minus(of_body(velocity, i), of_body(velocity, 0))
        r2 = dot(d, d)
        r = np.sqrt(r2)
        common = gm[0] * inverse_c2 / (r2 * r)
        along, across = common * (4.0 * gm[0] / r - dot(v, v)), common * 4.0 * dot(d, v)
        add(out[i], 0, plus(times(along, d), times(across, v)))


@bare
def potentials(gm, base, delta, velocity, potential, speed):
    """Fill sum_k gm_k / r_ik and v_i^2."""
    n = gm.shape[0]
    for i in range(n):
        v = of_body(velocity, i)
        potential[i], speed[i] = 0.0, dot(v, v)
    for i in range(n):
        for j in range(i + 1, n):
            d = apart(base, delta, i, j)
            inverse = 1.0 / np.sqrt(dot(d, d))
            potential[i] += gm[j] * inverse
            potential[j] += gm[i] * inverse


@bare
def einstein_infeld_hoffmann(gm, inverse_c2, base, delta, velocity, newton, potential, speed, out):
    """Add the 1PN terms of Park et al. 2021, eq 27, with beta = gamma = 1; `newton` are all a_j."""
    n = gm.shape[0]
    potentials(gm, base, delta, velocity, potential, speed)
    for i in range(n):
        for j in range(n):
            m = gm[j] * inverse_c2
            if i == j or m == 0.0:
                continue
            d, vi, vj, aj = apart(base, delta, i, j), of_body(velocity, i), of_body(velocity, j), of_body(newton, j)
            r2 = dot(d, d)
            inverse = 1.0 / np.sqrt(r2)
            cube = inverse / r2
            toward = dot(d, vj) * inverse
            bracket = (
                -4.0 * potential[i] - potential[j] + speed[i] + 2.0 * speed[j]
                - 4.0 * dot(vi, vj) - 1.5 * toward * toward + 0.5 * dot(d, aj)
            )  # fmt: skip
            slip = -m * cube * dot(d, minus(times(4.0, vi), times(3.0, vj)))
            pull = plus(plus(times(m * cube * bracket, d), times(slip, minus(vi, vj))), times(3.5 * m * inverse, aj))
            add(out[i], 0, pull)


@jit
def square_between(y, i, j):
    """Return the square of the distance (m^2) between two bodies."""
    r2 = 0.0
    for c in range(3):
        r2 += (y[3 * i + c] - y[3 * j + c]) ** 2
    return r2


@jit
def touching(radius, y, n):
    """Return whether two bodies are closer than the sum of their radii."""
    for i in range(n):
        for j in range(i + 1, n):
            reach = radius[i] + radius[j]
            if reach > 0.0 and square_between(y, i, j) < reach * reach:
                return True
    return False
