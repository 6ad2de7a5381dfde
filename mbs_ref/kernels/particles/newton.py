"""Newton's pairs and the post-Newtonian terms, eight instants side by side."""

# An intrinsic takes one argument fewer than its definition.
# pyright: reportCallIssue=false

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import attract


@jit
def newton_pairs(gm, base, delta, out):
    """Add gm_j (x_j - x_i) / r^3 over all pairs to `out` (n, 3, LANES)."""
    n = gm.shape[0]
    for i in range(n):
        for j in range(i + 1, n):
            mi, mj = gm[i], gm[j]
            if mi == 0.0 and mj == 0.0:
                continue
            x, y, z = base[j, 0] - base[i, 0], base[j, 1] - base[i, 1], base[j, 2] - base[i, 2]
            attract(delta, out, i, j, x, y, z, mi, mj)


@jit
def central_relativity(gm, inverse_c2, base, delta, velocity, out):
    """Add the first body's Schwarzschild term: gm/(c^2 r^3) [(4 gm/r - v^2) r + 4 (r.v) v]."""
    for i in range(1, gm.shape[0]):
        for k in range(LANES):
            x = base[i, 0] - base[0, 0] + (delta[i, 0, k] - delta[0, 0, k])
            y = base[i, 1] - base[0, 1] + (delta[i, 1, k] - delta[0, 1, k])
            z = base[i, 2] - base[0, 2] + (delta[i, 2, k] - delta[0, 2, k])
            u = velocity[i, 0, k] - velocity[0, 0, k]
            v = velocity[i, 1, k] - velocity[0, 1, k]
            w = velocity[i, 2, k] - velocity[0, 2, k]
            r2 = x * x + y * y + z * z
            r = np.sqrt(r2)
            common = gm[0] * inverse_c2 / (r2 * r)
            along = common * (4.0 * gm[0] / r - (u * u + v * v + w * w))
            across = common * 4.0 * (x * u + y * v + z * w)
            out[i, 0, k] += along * x + across * u
            out[i, 1, k] += along * y + across * v
            out[i, 2, k] += along * z + across * w


@jit
def potentials(gm, base, delta, velocity, potential, speed):
    """Fill sum_k gm_k / r_ik and v_i^2."""
    n = gm.shape[0]
    for i in range(n):
        for k in range(LANES):
            u, v, w = velocity[i, 0, k], velocity[i, 1, k], velocity[i, 2, k]
            potential[i, k] = 0.0
            speed[i, k] = u * u + v * v + w * w
    for i in range(n):
        for j in range(i + 1, n):
            bx, by, bz = base[j, 0] - base[i, 0], base[j, 1] - base[i, 1], base[j, 2] - base[i, 2]
            for k in range(LANES):
                x = bx + (delta[j, 0, k] - delta[i, 0, k])
                y = by + (delta[j, 1, k] - delta[i, 1, k])
                z = bz + (delta[j, 2, k] - delta[i, 2, k])
                inverse = 1.0 / np.sqrt(x * x + y * y + z * z)
                potential[i, k] += gm[j] * inverse
                potential[j, k] += gm[i] * inverse


@jit
def einstein_infeld_hoffmann(gm, inverse_c2, base, delta, velocity, newton, potential, speed, out):
    """Add the 1PN terms of Park et al. 2021, eq 27, with beta = gamma = 1; `newton` are all a_j."""
    n = gm.shape[0]
    potentials(gm, base, delta, velocity, potential, speed)
    for i in range(n):
        for j in range(n):
            m = gm[j] * inverse_c2
            if i == j or m == 0.0:
                continue
            for k in range(LANES):
                x = base[j, 0] - base[i, 0] + (delta[j, 0, k] - delta[i, 0, k])
                y = base[j, 1] - base[i, 1] + (delta[j, 1, k] - delta[i, 1, k])
                z = base[j, 2] - base[i, 2] + (delta[j, 2, k] - delta[i, 2, k])
                r2 = x * x + y * y + z * z
                inverse = 1.0 / np.sqrt(r2)
                cube = inverse / r2
                ui, vi, wi = velocity[i, 0, k], velocity[i, 1, k], velocity[i, 2, k]
                uj, vj, wj = velocity[j, 0, k], velocity[j, 1, k], velocity[j, 2, k]
                aj, bj, cj = newton[j, 0, k], newton[j, 1, k], newton[j, 2, k]
                toward = (x * uj + y * vj + z * wj) * inverse
                bracket = (
                    -4.0 * potential[i, k] - potential[j, k] + speed[i, k] + 2.0 * speed[j, k]
                    - 4.0 * (ui * uj + vi * vj + wi * wj) - 1.5 * toward * toward
                    + 0.5 * (x * aj + y * bj + z * cj)
                )  # fmt: skip
                along = m * cube * bracket
                slip = -m * cube * (x * (4.0 * ui - 3.0 * uj) + y * (4.0 * vi - 3.0 * vj) + z * (4.0 * wi - 3.0 * wj))
                pull = 3.5 * m * inverse
                out[i, 0, k] += along * x + slip * (ui - uj) + pull * aj
                out[i, 1, k] += along * y + slip * (vi - vj) + pull * bj
                out[i, 2, k] += along * z + slip * (wi - wj) + pull * cj
