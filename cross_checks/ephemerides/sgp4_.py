"""SGP4 (Vallado et al. 2006, package sgp4), begun at a state: the tool for two-line elements."""

import numpy as np
from scipy.optimize import least_squares
from sgp4.api import WGS84, Satrec  # pyright: ignore[reportMissingImports]

EPOCH, GM = 18_263.0, 398_600.5  # days from 1949-12-31 to 2000-01-01; km^3/s^2, WGS 84


def propagated(place: np.ndarray, rate: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return places (n, 3), m, at times (s) of the satellite without drag whose state SGP4 meets at t = 0.

    The state (m, m/s) is given in TEME, on a nearly circular orbit. ValueError where no mean elements meet it.
    """
    wanted = np.concatenate((place, rate)) / 1e3
    across, distance, speed = np.cross(place, rate), np.linalg.norm(place) / 1e3, np.linalg.norm(rate) / 1e3
    motion = (2.0 * GM / distance - speed**2) ** 1.5 / GM * 60.0  # rad/min
    tilt, node = np.arctan2(np.hypot(*across[:2]), across[2]), np.arctan2(across[0], -across[1])
    latitude = np.arctan2(wanted[2] / np.sin(tilt), wanted[0] * np.cos(node) + wanted[1] * np.sin(node))
    scale, start = np.repeat((distance, speed), 3), (motion, 0.0, 0.0, tilt, node, latitude)
    fit = least_squares(
        lambda x: (np.concatenate(_satellite(x).sgp4_tsince(0.0)[1:]) - wanted) / scale, start, xtol=1e-15, ftol=1e-15
    )
    if not np.abs(fit.fun).max() < 1e-9:
        raise ValueError(f"SGP4 meets the state {wanted} (km, km/s) to {np.abs(fit.fun).max():.1e} only")
    return 1e3 * np.array([_satellite(fit.x).sgp4_tsince(t / 60.0)[1] for t in times])


def _satellite(x: np.ndarray) -> Satrec:
    """Return the satellite of mean motion, e cos w, e sin w, inclination, node and argument of latitude."""
    motion, c, s, tilt, node, latitude = (float(one) for one in x)
    w, found = float(np.arctan2(s, c)), Satrec()
    found.sgp4init(WGS84, "i", 1, EPOCH, 0.0, 0.0, 0.0, float(np.hypot(c, s)), w, tilt, latitude - w, motion, node)
    return found
