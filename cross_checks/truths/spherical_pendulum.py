"""The spherical pendulum in Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.numerics.elliptic import amplitude, quarter_period
from cross_checks.certify.numerics.quadrature import TOLERANCE, running_integral
from cross_checks.certify.numerics.sensitivity import rounding_error
from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Return the bob's motion; every angle and speed is in its domain but the separatrix, where it is not known."""
    names = ("length", "gravity", "angle", "speed")
    data, grid = np.array([scene.parameters[name] for name in names], dtype=np.longdouble), times.astype(np.longdouble)
    position, error = _motion(data, grid)
    uncertainty = error + rounding_error(lambda near, few: _motion(near, few)[0], data, grid)
    theta = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1, 1))
    how = "elliptic functions by the arithmetic-geometric mean, azimuth by quadrature, extended precision"
    return Truth(position[:, None].astype(float), theta, uncertainty, "exact", how)


def _motion(data: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray, float]:
    """u = z / l: u'^2 = (2 g / l) (u - u1)(u - u2)(u - u3), u1 <= u <= u2 < 1 < u3 (Whittaker 1904, section 55).

    u = u1 + (u2 - u1) sn^2(p t + offset), p = sqrt((2 g / l)(u3 - u1)) / 2; the azimuth is the integral of
    h / (1 - u^2), h = v / l sin(angle0) the angular momentum per m l^2. Return positions (n_t, 3) and their error, m.
    """
    length, gravity, angle, speed = data
    u0 = -np.cos(angle)
    level = speed**2 / (2 * gravity * length) + u0  # energy over m g l
    half, constant = (level - u0) / 2, u0**2 - level * u0 - 1  # the other two roots: u^2 - 2 half u + constant = 0
    root = np.sqrt(half**2 - constant)
    u3 = half + root
    other = constant / u3
    u1, u2 = min(u0, other), max(u0, other)
    m, p = (u2 - u1) / (u3 - u1), np.sqrt(2 * gravity / length * (u3 - u1)) / 2
    quarter = quarter_period(m)
    offset = quarter if u0 > other else 0 * quarter
    h = speed / length * np.sin(angle)

    def height(t):
        return u1 + (u2 - u1) * np.sin(amplitude(offset + p * t, m)) ** 2

    steep = float(1 / min(1 - u1**2, 1 - u2**2))  # how the azimuth magnifies the rounding of u
    noise = steep * float(np.finfo(np.longdouble).eps)
    piece = float(quarter / p) / 16
    phi, error = running_integral(lambda t: h / (1 - height(t) ** 2), grid, piece, max(TOLERANCE, 16 * noise))
    u = height(grid)
    radius = np.sqrt(1 - u**2)
    position = length * np.stack([radius * np.cos(phi), radius * np.sin(phi), u], axis=1)
    return position, float(length) * (error + 4.0 * noise * (1.0 + float(p * grid[-1])))
