"""The air of the US Standard Atmosphere 1976 (NOAA-S/T 76-1562), from 5 km below sea level to 86 km.

Temperature is linear in geopotential altitude, layer by layer; the air is a perfect gas at rest under its weight.
"""

import numpy as np

from mbs_ref.kernels.jit import jit

LOWEST, HIGHEST = -5000.0, 86_000.0  # m, geometric; above, the species of the air part
EARTH_RADIUS = 6_356_766.0  # m, of the geopotential altitude alone: eq 18
BASE = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3])  # m', table 4
GRADIENT = np.array([-6.5e-3, 0.0, 1e-3, 2.8e-3, 0.0, -2.8e-3, -2e-3])  # K/m', of the molecular-scale temperature
GROUND_TEMPERATURE, GROUND_PRESSURE = 288.15, 101_325.0  # K, Pa
GAS = 8314.32 / 28.9644  # J/(kg K): R* / M_0
WEIGHT = 9.80665 / GAS  # K/m': g_0' M_0 / R*


def _base_temperatures() -> np.ndarray:
    return GROUND_TEMPERATURE + np.concatenate(([0.0], np.cumsum(GRADIENT[:-1] * np.diff(BASE))))


TEMPERATURE = _base_temperatures()  # K, at the bases


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
