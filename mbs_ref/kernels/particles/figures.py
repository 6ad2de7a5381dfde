"""What bodies do by not being points: zonal harmonics, the Moon's figure, tides. Each acts and reacts."""

import numpy as np

from mbs_ref.kernels.algebra.lanes import in_every_lane, in_lanes
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.particles.directions import earth_pole, moon_axes
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import add_to, apart, apart_at, bulge, of_body, share
from mbs_ref.kernels.spatial.marks import cross, dot, minus, plus, times

DAY = 86_400.0  # s


@bare
def _zonal(base, delta, out, i, j, gm, radius, harmonic, last, pole):
    """Add J_2 .. J_(last + 2) of body i: sum J_n (R/r)^n / r^2 [P'_(n+1)(s) r/|r| - P'_n(s) p]."""
    d = apart(base, delta, i, j)
    r2 = dot(d, d)
    inverse = 1.0 / np.sqrt(r2)
    s = dot(d, pole) * inverse
    ratio = radius * inverse
    power = ratio * ratio / r2
    p_old, p = s, 1.5 * s * s - 0.5  # P_1, P_2
    d_old, slope = in_every_lane(1.0), 3.0 * s  # P'_1, P'_2
    along, toward = in_every_lane(0.0), in_every_lane(0.0)
    for q in range(last + 1):
        n = q + 2.0
        d_next = d_old + (2.0 * n + 1.0) * p  # P'_(n+1) = P'_(n-1) + (2n+1) P_n
        along += harmonic[q] * power * d_next
        toward += harmonic[q] * power * slope
        p_next = ((2.0 * n + 1.0) * s * p - n * p_old) / (n + 1.0)
        p_old, p, d_old, slope = p, p_next, slope, d_next
        power *= ratio
    share(out, i, j, gm, minus(times(along * inverse, d), times(toward, pole)))


@jit
def add_zonals(model, work):
    """Add the zonal harmonics of every body that has them; J2 alone by its own formula."""
    zonals, particles, lanes = model.zonals, model.particles, work.lanes
    base, delta, out, gm = lanes.base, in_lanes(lanes.delta), in_lanes(lanes.acceleration), particles.gm
    for z in range(zonals.body.shape[0]):
        i, radius, harmonic, axis = zonals.body[z], zonals.radius[z], zonals.harmonic[z], lanes.axes[0]
        for k in range(LANES):
            if zonals.precesses[z] == 1:
                earth_pole((particles.epoch[0] + lanes.time[k]) / DAY, axis)
            else:
                for c in range(3):
                    axis[c] = zonals.axis[z, c]
            for c in range(3):
                lanes.pole[c, k] = axis[c]
        last = 0
        for q in range(harmonic.shape[0]):
            if harmonic[q] != 0.0:
                last = q
        seen = in_lanes(lanes.pole)
        pole = (seen[0], seen[1], seen[2])
        for j in range(gm.shape[0]):
            if j == i or (gm[i] == 0.0 and gm[j] == 0.0):
                continue
            if last == 0:
                bulge(base, delta, out, i, j, gm, 1.5 * harmonic[0] * radius * radius, pole)
            else:
                _zonal(base, delta, out, i, j, gm, radius, harmonic, last, pole)


@bare
def _share(out, i, j, k, gm, a):
    """Do what `share` does at one instant."""
    for c in range(3):
        out[j, c, k] += gm[i] * a[c]
        out[i, c, k] -= gm[j] * a[c]


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
                x, y, z = apart_at(base, delta, i, j, k)
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
                _share(lanes.acceleration, i, j, k, gm, (ax, ay, az))


@jit
def add_tides(model, work):
    """Mignard 1979: -3 k2 gm_m R^5 / r^8 [r + tau (2 r (r.v) / r^2 + r x w + v)] on the raiser, per gm ratio."""
    tides, lanes, gm = model.tides, work.lanes, model.particles.gm
    delta, velocity, out = in_lanes(lanes.delta), in_lanes(lanes.velocity), in_lanes(lanes.acceleration)
    for q in range(tides.body.shape[0]):
        i, j, lag = tides.body[q], tides.raiser[q], tides.lag[q]
        d, v = apart(lanes.base, delta, i, j), minus(of_body(velocity, j), of_body(velocity, i))
        r2 = dot(d, d)
        ratio = tides.radius[q] ** 5 / (r2 * r2 * r2 * r2)
        along = 1.0 + lag * 2.0 * dot(d, v) / r2
        pull = plus(times(along, d), times(lag, plus(cross(d, tides.spin[q]), v)))
        force = -3.0 * tides.love_number[q] * ratio * gm[j]  # on the raiser, over its own gm: m/s^2 / (m ...)
        add_to(out, j, force, pull)
        add_to(out, i, -(force * gm[j] / gm[i]), pull)
