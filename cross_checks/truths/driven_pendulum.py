"""A rod on a driven carriage: one degree of freedom and a prescribed motion."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.agreement import Formulation, agree, agreed
from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Lagrange's equation by DOP853 against Hamilton's by extrapolation in extended precision."""
    given = {key: float(value) for key, value in scene.parameters.items()}
    agreement = agree(_lagrange(**given), _hamilton(**given), times, extended=True)
    how = (
        "Hamilton's equations in the rod's angle by extrapolation in extended precision; "
        f"Lagrange's by DOP853 differ by {agreement.difference:.1e} m"
    )
    return agreed(agreement, how)


def _lagrange(length, mass, amplitude, omega, angle, gravity) -> Formulation:
    """(l/3) theta'' = (1/2) sin(theta) X'' - (1/2) g cos(theta), X'' = -amplitude omega^2 cos(omega t)."""

    def derivative(t, y):
        push = -amplitude * omega**2 * np.cos(omega * t)
        return np.array([y[1], 1.5 / length * (np.sin(y[0]) * push - gravity * np.cos(y[0]))])

    return Formulation(derivative, np.array([angle, 0.0]), _poses(length, amplitude, omega))


def _hamilton(length, mass, amplitude, omega, angle, gravity) -> Formulation:
    """p = (m l^2/3) theta' - (m l/2) sin(theta) X', p' = -(m l/2) cos(theta) (theta' X' + g)."""
    inertia, moment = mass * length**2 / np.longdouble(3), mass * length / np.longdouble(2)

    def derivative(t, y):
        speed = -amplitude * omega * np.sin(omega * t)
        rate = (y[1] + moment * np.sin(y[0]) * speed) / inertia
        return np.array([rate, -moment * np.cos(y[0]) * (rate * speed + gravity)])

    return Formulation(derivative, np.array([angle, 0.0]), _poses(length, amplitude, omega))


def _poses(length, amplitude, omega):
    def poses(t, y):
        carriage = np.array([amplitude * (np.cos(omega * t) - 1.0), 0.0])
        along = length / 2 * np.array([np.cos(y[0]), np.sin(y[0])])
        return np.stack([carriage, carriage + along]), np.array([0.0, y[0]])

    return poses
