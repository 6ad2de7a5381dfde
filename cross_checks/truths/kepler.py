"""The ellipse of two bodies, by Kepler's equation in extended precision."""

from __future__ import annotations

import numpy as np

from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """M = E - e sin E with Newton's method; x = cos E - e, y = sqrt(1 - e^2) sin E (a = gm = 1)."""
    planet = scene.bodies[1]
    x, v = np.longdouble(planet.position[0]), np.longdouble(planet.velocity[1])
    a = 1 / (2 / x - v * v)  # of the orbit that the rounded start is on
    e = 1 - x / a
    mean = np.sqrt(1 / a**3) * times.astype(np.longdouble)
    anomaly = _eccentric_anomaly(mean, e)
    position = np.zeros((len(times), 2, 3))
    position[:, 1, 0] = a * (np.cos(anomaly) - e)
    position[:, 1, 1] = a * np.sqrt(1 - e * e) * np.sin(anomaly)
    speed = float(np.sqrt((1 + e) / (1 - e)))
    uncertainty = 2e-16 + speed * float(times[-1]) * 1e-17  # m: double output; extended precision carries the phase
    return Truth(
        position, np.zeros((len(times), 2)), uncertainty, "exact", "Kepler's equation solved in extended precision"
    )


def _eccentric_anomaly(mean: np.ndarray, e) -> np.ndarray:
    turns = np.rint(mean / (2 * np.pi))
    whole = turns * (2 * np.longdouble("3.14159265358979323846264338327950288"))
    rest = mean - whole
    anomaly = rest + e * np.sign(rest)
    low, high = rest - e, rest + e  # E - M = e sin E lies between
    for _ in range(200):
        residual = anomaly - e * np.sin(anomaly) - rest
        high, low = np.where(residual > 0, anomaly, high), np.where(residual > 0, low, anomaly)
        newton = anomaly - residual / (1 - e * np.cos(anomaly))
        inside = (newton > low) & (newton < high)
        new = np.where(inside, newton, (low + high) / 2)
        if np.all(np.abs(new - anomaly) <= 1e-19 * (1 + np.abs(new))):
            break
        anomaly = new
    return new + whole
