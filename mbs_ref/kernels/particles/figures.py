"""What bodies do by not being points: zonal harmonics, the Moon's figure, tides. Each acts and reacts."""

# An intrinsic takes one argument fewer than its definition.
# pyright: reportCallIssue=false

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.directions import earth_pole, moon_axes
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import bulge

DAY = 86_400.0  # s


@jit
def _share(gm, i, j, k, ax, ay, az, out):
    """Give body j the acceleration gm_i a and body i the reaction -gm_j a."""
    out[j, 0, k] += gm[i] * ax
    out[j, 1, k] += gm[i] * ay
    out[j, 2, k] += gm[i] * az
    out[i, 0, k] -= gm[j] * ax
    out[i, 1, k] -= gm[j] * ay
    out[i, 2, k] -= gm[j] * az


@jit
def _zonal(z, radius, harmonic, px, py, pz, gm, i, lanes):
    """Add J_n of body i: sum J_n (R/r)^n / r^2 [P'_(n+1)(s) r/|r| - P'_n(s) p]."""
    base, delta, out = lanes.base, lanes.delta, lanes.acceleration
    last = 0
    for q in range(harmonic.shape[1]):
        if harmonic[z, q] != 0.0:
            last = q
    for j in range(gm.shape[0]):
        if j == i or (gm[i] == 0.0 and gm[j] == 0.0):
            continue
        for k in range(LANES):
            x = base[j, 0] - base[i, 0] + (delta[j, 0, k] - delta[i, 0, k])
            y = base[j, 1] - base[i, 1] + (delta[j, 1, k] - delta[i, 1, k])
            w = base[j, 2] - base[i, 2] + (delta[j, 2, k] - delta[i, 2, k])
            r2 = x * x + y * y + w * w
            inverse = 1.0 / np.sqrt(r2)
            s = (x * px[k] + y * py[k] + w * pz[k]) * inverse
            ratio = radius[z] * inverse
            power = ratio * ratio / r2
            p_old, p = s, 1.5 * s * s - 0.5  # P_1, P_2
            d_old, d = 1.0, 3.0 * s  # P'_1, P'_2
            along, toward = 0.0, 0.0
            for q in range(last + 1):
                n = q + 2.0
                d_next = d_old + (2.0 * n + 1.0) * p  # P'_(n+1) = P'_(n-1) + (2n+1) P_n
                along += harmonic[z, q] * power * d_next
                toward += harmonic[z, q] * power * d
                p_next = ((2.0 * n + 1.0) * s * p - n * p_old) / (n + 1.0)
                p_old, p, d_old, d = p, p_next, d, d_next
                power *= ratio
            along *= inverse
            _share(gm, i, j, k, along * x - toward * px[k], along * y - toward * py[k], along * w - toward * pz[k], out)


@jit
def _j2_alone(factor, px, py, pz, gm, i, lanes):
    """Add J2 of body i; `factor` is 3/2 J2 R^2, m^2."""
    base = lanes.base
    for j in range(gm.shape[0]):
        if j == i or (gm[i] == 0.0 and gm[j] == 0.0):
            continue
        x, y, z = base[j, 0] - base[i, 0], base[j, 1] - base[i, 1], base[j, 2] - base[i, 2]
        bulge(lanes.delta, lanes.acceleration, i, j, x, y, z, gm[i], gm[j], factor, px, py, pz)


@jit
def add_zonals(model, work):
    zonals, particles, lanes = model.zonals, model.particles, work.lanes
    px, py, pz = lanes.pair[0], lanes.pair[1], lanes.pair[2]
    for z in range(zonals.body.shape[0]):
        axis = lanes.axes[0]
        for k in range(LANES):
            if zonals.precesses[z] == 1:
                earth_pole((particles.epoch[0] + lanes.time[k]) / DAY, axis)
            else:
                for c in range(3):
                    axis[c] = zonals.axis[z, c]
            px[k], py[k], pz[k] = axis[0], axis[1], axis[2]
        higher = 0.0
        for q in range(1, zonals.harmonic.shape[1]):
            higher += abs(zonals.harmonic[z, q])
        if higher == 0.0:
            factor = 1.5 * zonals.harmonic[z, 0] * zonals.radius[z] * zonals.radius[z]
            _j2_alone(factor, px, py, pz, particles.gm, zonals.body[z], lanes)
            continue
        _zonal(z, zonals.radius, zonals.harmonic, px, py, pz, particles.gm, zonals.body[z], lanes)


@jit
def add_figures(model, work):
    """Add gm R^2 grad(q(r) / r^5), q = -J2/2 (2 z^2 - x^2 - y^2) + 3 C22 (x^2 - y^2), in body axes."""
    figures, particles, lanes = model.figures, model.particles, work.lanes
    base, delta, axes, gm = lanes.base, lanes.delta, lanes.axes, particles.gm
    for f in range(figures.body.shape[0]):
        i, j2, c22 = figures.body[f], figures.j2[f], figures.c22[f]
        for k in range(LANES):
            moon_axes((particles.epoch[0] + lanes.time[k]) / DAY, axes)
            for j in range(gm.shape[0]):
                if j == i or (gm[i] == 0.0 and gm[j] == 0.0):
                    continue
                x = base[j, 0] - base[i, 0] + (delta[j, 0, k] - delta[i, 0, k])
                y = base[j, 1] - base[i, 1] + (delta[j, 1, k] - delta[i, 1, k])
                z = base[j, 2] - base[i, 2] + (delta[j, 2, k] - delta[i, 2, k])
                u = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
                v = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
                w = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
                r2 = x * x + y * y + z * z
                q = -0.5 * j2 * (2.0 * w * w - u * u - v * v) + 3.0 * c22 * (u * u - v * v)
                common = figures.radius[f] * figures.radius[f] / (r2 * r2 * np.sqrt(r2))
                back = 5.0 * q / r2
                gu = common * ((j2 + 6.0 * c22) * u - back * u)
                gv = common * ((j2 - 6.0 * c22) * v - back * v)
                gw = common * (-2.0 * j2 * w - back * w)
                ax = axes[0, 0] * gu + axes[1, 0] * gv + axes[2, 0] * gw
                ay = axes[0, 1] * gu + axes[1, 1] * gv + axes[2, 1] * gw
                az = axes[0, 2] * gu + axes[1, 2] * gv + axes[2, 2] * gw
                _share(gm, i, j, k, ax, ay, az, lanes.acceleration)


@jit
def add_tides(model, work):
    """Mignard 1979: -3 k2 gm_m R^5 / r^8 [r + tau (2 r (r.v) / r^2 + r x w + v)] on the raiser, per gm ratio."""
    tides, particles, lanes = model.tides, model.particles, work.lanes
    base, delta, velocity, out, gm = lanes.base, lanes.delta, lanes.velocity, lanes.acceleration, particles.gm
    for q in range(tides.body.shape[0]):
        i, j, lag = tides.body[q], tides.raiser[q], tides.lag[q]
        for k in range(LANES):
            x = base[j, 0] - base[i, 0] + (delta[j, 0, k] - delta[i, 0, k])
            y = base[j, 1] - base[i, 1] + (delta[j, 1, k] - delta[i, 1, k])
            z = base[j, 2] - base[i, 2] + (delta[j, 2, k] - delta[i, 2, k])
            u = velocity[j, 0, k] - velocity[i, 0, k]
            v = velocity[j, 1, k] - velocity[i, 1, k]
            w = velocity[j, 2, k] - velocity[i, 2, k]
            sx, sy, sz = tides.spin[q, 0], tides.spin[q, 1], tides.spin[q, 2]
            r2 = x * x + y * y + z * z
            ratio = tides.radius[q] ** 5 / (r2 * r2 * r2 * r2)
            along = 1.0 + lag * 2.0 * (x * u + y * v + z * w) / r2
            fx = along * x + lag * (y * sz - z * sy + u)
            fy = along * y + lag * (z * sx - x * sz + v)
            fz = along * z + lag * (x * sy - y * sx + w)
            force = -3.0 * tides.love[q] * ratio * gm[j]  # on the raiser, over its own gm: m/s^2 / (m ...)
            out[j, 0, k] += force * fx
            out[j, 1, k] += force * fy
            out[j, 2, k] += force * fz
            back = force * gm[j] / gm[i]
            out[i, 0, k] -= back * fx
            out[i, 1, k] -= back * fy
            out[i, 2, k] -= back * fz
