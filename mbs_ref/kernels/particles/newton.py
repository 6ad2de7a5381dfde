"""Newton's pairs and the post-Newtonian terms, eight instants side by side: arrays of lanes (n, 3) or (n,)."""

# An intrinsic takes one argument fewer than its definition.
# pyright: reportCallIssue=false

from mbs_ref.kernels.algebra.lanes import root_in_lanes
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.particles.pair import apart, attract, of_body
from mbs_ref.kernels.spatial.marks import add, dot, minus, plus, times


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
        r = root_in_lanes(r2)
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
            inverse = 1.0 / root_in_lanes(dot(d, d))
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
            inverse = 1.0 / root_in_lanes(r2)
            cube = inverse / r2
            toward = dot(d, vj) * inverse
            bracket = (
                -4.0 * potential[i] - potential[j] + speed[i] + 2.0 * speed[j]
                - 4.0 * dot(vi, vj) - 1.5 * toward * toward + 0.5 * dot(d, aj)
            )  # fmt: skip
            slip = -m * cube * dot(d, minus(times(4.0, vi), times(3.0, vj)))
            pull = plus(plus(times(m * cube * bracket, d), times(slip, minus(vi, vj))), times(3.5 * m * inverse, aj))
            add(out[i], 0, pull)
