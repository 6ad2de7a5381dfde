"""Lagrange's top with a fixed point: nutation in Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.numerics.elliptic import amplitude, quarter_period
from cross_checks.certify.numerics.quadrature import running_integral
from cross_checks.certify.numerics.sensitivity import DOUBLE_EPS, rounding_error
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import from_axis_angle, product
from mbs_ref.scenes.tops import ARM, ARM_MASS, steady_precession
from mbs_ref.scenes.tops import TOP_AXIAL as AXIAL
from mbs_ref.scenes.tops import TOP_TRANSVERSE as TRANSVERSE

Z, Y = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """u = cos(theta): u'^2 = beta (u0 - u)(1 - u^2) - a^2 (u0 - u)^2 from rest at u0 (Goldstein sec. 5-7).

    With u1 < u0 < u3 its roots, u = u1 + (u0 - u1) sn^2(K + p t), p = sqrt(beta (u3 - u1)) / 2; precession
    phi' = a (u0 - u) / (1 - u^2) and spin psi' = omega_3 - phi' u by quadrature. Steady: phi' is
    a root of its quadratic.
    """
    given = scene.parameters
    spin, tilt, gravity = (float(given[key]) for key in ("spin", "tilt", "gravity"))
    grid = times.astype(np.longdouble)
    data = np.array([spin, tilt, gravity], dtype=np.longdouble)
    if given["motion"] == "steady":
        rate = np.longdouble(steady_precession(spin, tilt, gravity))
        theta, phi = np.full(len(times), np.longdouble(tilt)), rate * grid
        psi = (spin - rate * np.cos(theta)) * grid
        error = DOUBLE_EPS * (abs(float(rate)) + abs(spin)) * float(times[-1])
    else:
        *angles, error = _nutation(data, grid)
        theta, phi, psi = angles
        error += rounding_error(lambda near, few: np.stack(_nutation(near, few)[:3]), data, grid)
    full = 2 * np.arctan2(np.longdouble(0), np.longdouble(-1))
    phi, psi = np.remainder(phi, full).astype(float), np.remainder(psi, full).astype(float)
    turned = product(product(from_axis_angle(Z, phi), from_axis_angle(Y, theta.astype(float))), from_axis_angle(Z, psi))
    axis = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1).astype(float)
    how = "elliptic functions by the arithmetic-geometric mean, quadrature in extended precision"
    return Truth(ARM * axis[:, None], turned[:, None], 1e-15 + error, "exact", how)


def _nutation(data: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return the three Euler angles (z, y, z), each (n_t,), and the error of their quadrature, rad."""
    spin, tilt, gravity = data
    about_pivot = TRANSVERSE + ARM_MASS * np.longdouble(ARM) ** 2
    beta, a = 2 * ARM_MASS * gravity * ARM / about_pivot, AXIAL * spin / about_pivot
    u0 = np.cos(tilt)
    root = np.sqrt(a**4 - 4 * beta * (a**2 * u0 - beta))
    u1, u3 = 2 * (a**2 * u0 - beta) / (a**2 + root), (a**2 + root) / (2 * beta)
    m, p = (u0 - u1) / (u3 - u1), np.sqrt(beta * (u3 - u1)) / 2
    quarter = quarter_period(m)

    def height(t):
        return u1 + (u0 - u1) * np.sin(amplitude(quarter + p * t, m)) ** 2

    def precession(t):
        u = height(t)
        return a * (u0 - u) / (1 - u**2)

    piece = float(quarter / p) / 8
    phi, error = running_integral(precession, times, piece)
    back, more = running_integral(lambda t: precession(t) * height(t), times, piece)
    return np.arccos(height(times)), phi, spin * times - back, error + more
