"""What acts on satellites beside gravity of the bodies: third bodies, a ring, drag, sunlight.

The air is that of the US Standard Atmosphere 1976 (NOAA-S/T 76-1562), from 5 km below sea level to 86 km. Temperature
is linear in geopotential altitude, layer by layer; the air is a perfect gas at rest under its weight.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import in_lanes
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.directions import moon_place, sun_place
from mbs_ref.kernels.particles.model import LANES, STANDARD
from mbs_ref.kernels.particles.pair import add_to, apart_at, of_body
from mbs_ref.kernels.spatial.marks import dot, minus

LOWEST, HIGHEST = -5000.0, 86_000.0  # m, geometric; above, the species of the air part
EARTH_RADIUS = 6_356_766.0  # m, of the geopotential altitude alone: eq 18
BASE = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3])  # m', table 4
GRADIENT = np.array([-6.5e-3, 0.0, 1e-3, 2.8e-3, 0.0, -2.8e-3, -2e-3])  # K/m', of the molecular-scale temperature
GROUND_TEMPERATURE, GROUND_PRESSURE = 288.15, 101_325.0  # K, Pa
GAS = 8314.32 / 28.9644  # J/(kg K): R* / M_0
WEIGHT = 9.80665 / GAS  # K/m': g_0' M_0 / R*


TEMPERATURE = GROUND_TEMPERATURE + np.concatenate(([0.0], np.cumsum(GRADIENT[:-1] * np.diff(BASE))))  # K, at the bases


def _base_pressures() -> np.ndarray:
    found = [GROUND_PRESSURE]
    for b, rise in enumerate(np.diff(BASE)):
        found.append(found[-1] * pressure_ratio.py_func(TEMPERATURE[b], GRADIENT[b], rise))
    return np.array(found)


@jit
def pressure_ratio(temperature, gradient, rise):
    """Return p / p_b at a rise (m') above a layer's base: eq 33a where the temperature changes, 33b where not."""
    if gradient == 0.0:
        return np.exp(-WEIGHT * rise / temperature)
    return (temperature / (temperature + gradient * rise)) ** (WEIGHT / gradient)


PRESSURE = _base_pressures()  # Pa, at the bases


@jit
def standard_density(altitude):
    """Return the density (kg/m^3) at a geometric altitude (m), eq 42; NaN where the formulas do not hold."""
    if not LOWEST <= altitude <= HIGHEST:
        return np.nan
    high = EARTH_RADIUS * altitude / (EARTH_RADIUS + altitude)  # m', eq 18
    b = 0
    while b + 1 < BASE.shape[0] and high >= BASE[b + 1]:
        b += 1
    rise = high - BASE[b]
    pressure = PRESSURE[b] * pressure_ratio(TEMPERATURE[b], GRADIENT[b], rise)
    return pressure / (GAS * (TEMPERATURE[b] + GRADIENT[b] * rise))


DAY = 86_400.0  # s
AU = 149_597_870_700.0  # m
SUN_RADIUS = 6.957e8  # m, IAU 2015 Resolution B3


@jit
def add_points(model, work):
    """Add the attraction of the fixed points of a ring."""
    points, base = model.points, work.lanes.base
    delta, out = in_lanes(work.lanes.delta), in_lanes(work.lanes.acceleration)
    for i in range(base.shape[0]):
        for p in range(points.gm.shape[0]):
            way = minus(minus(points.place[p], base[i]), of_body(delta, i))
            r2 = dot(way, way)
            add_to(out, i, points.gm[p] / (r2 * np.sqrt(r2)), way)


@jit
def add_third_bodies(model, work):
    """gm [(s - r)/|s - r|^3 - s/|s|^3] with r from the origin, where the body at rest is."""
    third, particles, lanes = model.third_bodies, model.particles, work.lanes
    place = lanes.axes[0]
    for q in range(third.body.shape[0]):
        i = third.body[q]
        for k in range(LANES):
            d = (particles.epoch[0] + lanes.time[k]) / DAY
            if third.source[q] == 0:
                sun_place(d, place)
            else:
                moon_place(d, place)
            away = np.sqrt(place[0] * place[0] + place[1] * place[1] + place[2] * place[2])
            gap = 0.0
            for c in range(3):
                gap += (place[c] - lanes.base[i, c] - lanes.delta[i, c, k]) ** 2
            gap = np.sqrt(gap)
            for c in range(3):
                near = (place[c] - lanes.base[i, c] - lanes.delta[i, c, k]) / gap**3
                lanes.acceleration[i, c, k] += third.gm[q] * (near - place[c] / away**3)


@jit
def add_drags(model, work):
    """-(1/2) rho (c_D A / m) |u| u with u the velocity in the turning air."""
    drags, lanes = model.drags, work.lanes
    base, delta, velocity = lanes.base, lanes.delta, lanes.velocity
    for q in range(drags.body.shape[0]):
        i, j, number = drags.body[q], drags.planet[q], drags.number[q]
        for k in range(LANES):
            x, y, z = apart_at(base, delta, j, i, k)
            altitude = np.sqrt(x * x + y * y + z * z) - number[4]
            if drags.air[q] == STANDARD:
                density = standard_density(altitude)
            else:
                density = number[1] * np.exp(-(altitude - number[2]) / number[3])
            u = velocity[i, 0, k] - velocity[j, 0, k] + number[5] * y
            v = velocity[i, 1, k] - velocity[j, 1, k] - number[5] * x
            w = velocity[i, 2, k] - velocity[j, 2, k]
            factor = -0.5 * density * number[0] * np.sqrt(u * u + v * v + w * w)
            lanes.acceleration[i, 0, k] += factor * u
            lanes.acceleration[i, 1, k] += factor * v
            lanes.acceleration[i, 2, k] += factor * w


@jit
def lit_share(a, b, c):
    """Return the visible share of a disc of radius a, another of radius b being c away (all rad; M&G eq 3.87-3.94)."""
    if c >= a + b:
        return 1.0
    if c <= b - a:
        return 0.0
    if c <= a - b:
        return 1.0 - b * b / (a * a)
    x = (c * c + a * a - b * b) / (2.0 * c)
    y = np.sqrt(max(a * a - x * x, 0.0))
    area = a * a * np.arccos(x / a) + b * b * np.arccos((c - x) / b) - c * y
    return 1.0 - area / (np.pi * a * a)


@jit
def add_lights(model, work):
    """P (c_R A / m) (1 au)^2 (r - s)/|r - s|^3 times the visible share of the Sun."""
    lights, particles, lanes = model.lights, model.particles, work.lanes
    sun, away, here = lanes.axes[0], lanes.axes[1], lanes.axes[2]
    for q in range(lights.body.shape[0]):
        i, j, number = lights.body[q], lights.planet[q], lights.number[q]
        for k in range(LANES):
            sun_place((particles.epoch[0] + lanes.time[k]) / DAY, sun)
            gap, high, dot = 0.0, 0.0, 0.0
            for c in range(3):
                here[c] = lanes.base[i, c] - lanes.base[j, c] + (lanes.delta[i, c, k] - lanes.delta[j, c, k])
                away[c] = here[c] - sun[c]
                gap += away[c] * away[c]
                high += here[c] * here[c]
                dot += away[c] * here[c]
            gap, high = np.sqrt(gap), np.sqrt(high)
            angle = np.arccos(min(1.0, max(-1.0, dot / (gap * high))))  # between the body and the Sun, as seen
            lit = lit_share(np.arcsin(SUN_RADIUS / gap), np.arcsin(min(1.0, number[1] / high)), angle)
            factor = lit * number[2] * number[0] * AU * AU / gap**3
            for c in range(3):
                lanes.acceleration[i, c, k] += factor * away[c]
