"""Forces on a satellite other than its planet's gravity: Sun and Moon, air, and sunlight."""

from collections.abc import Callable

import numpy as np

from cross_checks.truths.made_by.sky import PI, Field, directions, dot, norm, real
from mbs_ref import Scene
from mbs_ref.scene.celestial import AU_M, Drag, RadiationPressure, StandardDrag, ThirdBody

GEOPOTENTIAL_RADIUS = 6_356_766  # m: r_0 of eq 18
LAYERS = ((0, "-6.5"), (11, "0"), (20, "1.0"), (32, "2.8"), (47, "0"), (51, "-2.8"), (71, "-2.0"))  # km', K/km'
TOP = 86  # km', above every altitude requested
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


SUN_RADIUS = 6.957e8  # m, nominal: IAU 2015 Resolution B3
PLACES = {"sun": directions.sun_place, "moon": directions.moon_place}


def third_body(scene: Scene, load: ThirdBody) -> Field:
    """Return gm [(s - r)/|s - r|^3 - s/|s|^3] (Montenbruck and Gill 2000, eq 3.37)."""
    i, date, gm, place = scene.body_index(load.body), directions.date_of(scene), real(load.gm), PLACES[load.source]

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        s = place(date(t))
        toward, pull = s - x[:, i], np.zeros_like(x)
        pull[:, i] = gm * (toward / norm(toward) ** 3 - s / norm(s) ** 3)
        return pull

    return field


def drag(scene: Scene, load: Drag) -> Field:
    """Return -(1/2) c_D A/m rho u^2 along u, u the velocity in the turning air (M&G 2000, eq 3.97 and 3.98)."""
    ground, thickness = real(load.density), real(load.scale_height)
    reference = real(load.radius) + real(load.altitude)
    return _resistance(scene, load, lambda distance: ground * np.exp((reference - distance) / thickness))


def standard_drag(scene: Scene, load: StandardDrag) -> Field:
    """Return the same of the US Standard Atmosphere 1976."""
    return _resistance(scene, load, lambda distance: standard_density(distance - real(load.radius)))


def _resistance(scene: Scene, load: Drag | StandardDrag, density: Callable[[np.ndarray], np.ndarray]) -> Field:
    """Return the drag of air whose density is known by the distance from the planet's centre, m."""
    i, j = scene.body_index(load.body), scene.body_index(load.planet)
    turning, coefficient = real((0.0, 0.0, load.spin)), real(load.coefficient)

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        r = x[:, i] - x[:, j]
        wind = v[:, i] - v[:, j] - np.cross(turning, r)
        pull = np.zeros_like(x)
        pull[:, i] = -coefficient * density(norm(r)) * norm(wind) * wind / 2
        return pull

    return field


def sunlight(scene: Scene, load: RadiationPressure) -> Field:
    """Return nu P c_R A/m au^2 (r - s)/|r - s|^3, nu the share of the Sun that is seen (M&G 2000, eq 3.75)."""
    i, j, date = scene.body_index(load.body), scene.body_index(load.planet), directions.date_of(scene)
    strength, radius = real(load.pressure) * real(load.coefficient) * real(AU_M) ** 2, real(load.radius)

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        r = x[:, i] - x[:, j]
        away = r - directions.sun_place(date(t))
        pull = np.zeros_like(x)
        pull[:, i] = strength * visible_share(r, away, radius) * away / norm(away) ** 3
        return pull

    return field


def visible_share(r: np.ndarray, away: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return the share (m, 1) of the Sun's disc that a sphere at the origin leaves uncovered at r (M&G, sec. 3.4.2).

    `away` points from the Sun. Discs of radii a and b, c apart: the lens is two segments a^2 (u - sin u cos u) wide.
    """
    a, b = np.arcsin(SUN_RADIUS / norm(away)), np.arcsin(np.minimum(radius / norm(r), 1))
    c = np.arctan2(norm(np.cross(away, r)), dot(away, r))
    u, w = _half_angle(a, b, c), _half_angle(b, a, c)
    lens = a**2 * (u - np.sin(u) * np.cos(u)) + b**2 * (w - np.sin(w) * np.cos(w))
    return 1 - lens / (PI * a**2)


def _half_angle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return half the arc of circle a inside circle b, from a's centre: 0 if outside, pi if swallowed."""
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (a**2 + c**2 - b**2) / (2 * a * c)
    return np.arccos(np.clip(np.where(c > 0, cosine, np.where(a < b, -1, 1)), -1, 1))
