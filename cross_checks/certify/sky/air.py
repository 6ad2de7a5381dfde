"""The US Standard Atmosphere 1976 (NOAA-S/T 76-1562), as one hydrostatic integral over its layers."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.numbers import real

GEOPOTENTIAL_RADIUS = 6_356_766  # m: r_0 of eq 18
LAYERS = ((0, "-6.5"), (11, "0"), (20, "1.0"), (32, "2.8"), (47, "0"), (51, "-2.8"), (71, "-2.0"))  # km', K/km'
TOP = 86  # km', above all that is asked for
GEOMETRIC = (-5000, 86_000)  # m


class NoAirError(ArithmeticError):
    """Asked for air where the tables' formulas do not hold."""


def standard_density(altitude: np.ndarray) -> np.ndarray:
    """Return the density (kg/m^3) at geometric altitudes (m), all in extended precision.

    ln p / p_0 = -(g_0' M_0 / R*) times the integral of dH / T_M, which layer by layer is ln(1 + x) / x of the rise over
    the base's temperature, x the relative change of temperature; rho = p M_0 / (R* T_M). NoAirError outside.
    """
    low, high = GEOMETRIC
    if np.any((altitude < low) | (altitude > high)):
        raise NoAirError(
            f"the standard atmosphere ends at {low / 1000:g} and {high / 1000:g} km, and the body leaves it"
        )
    height = altitude / (1 + altitude / GEOPOTENTIAL_RADIUS) / 1000  # km'
    temperature, integral = real("288.15"), np.zeros_like(height)
    here = np.zeros_like(height)
    for number, (base, gradient) in enumerate(LAYERS):
        slope = real(gradient)
        end = LAYERS[number + 1][0] if number + 1 < len(LAYERS) else TOP
        rise = np.clip(height - base, -np.inf if number == 0 else 0, end - base)
        integral = integral + rise / temperature * _log1p_ratio(slope * rise / temperature)
        here = here + slope * rise
        temperature = temperature + slope * (end - base)
    gas = real("8314.32") / real("28.9644")  # J/(kg K)
    pressure = 101_325 * np.exp(-1000 * real("9.80665") / gas * integral)
    return pressure / (gas * (real("288.15") + here))


def _log1p_ratio(x: np.ndarray) -> np.ndarray:
    """Return ln(1 + x) / x, 1 at x = 0."""
    safe = np.where(x == 0, 1, x)
    return np.where(x == 0, 1, np.log1p(safe) / safe)
