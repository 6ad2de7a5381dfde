"""The elastic pendulum in Cartesian and in polar coordinates."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.agreement import Formulation, agree, agreed
from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's equations by DOP853 against Hamilton's polar ones by extrapolation in extended precision."""
    given = {key: float(value) for key, value in scene.parameters.items()}
    agreement = agree(_cartesian(**given), _polar(**given), times, extended=True)
    how = (
        "polar Hamilton's equations by extrapolation in extended precision; "
        f"Newton's in x, y by DOP853 differ by {agreement.difference:.1e} m"
    )
    return agreed(agreement, how)


def _cartesian(rest_length, mass, stiffness, damping, gravity) -> Formulation:
    def derivative(t, y):
        x, v = y[:2], y[2:]
        r = np.hypot(*x)
        pull = stiffness * (r - rest_length) + damping * (x @ v) / r  # N
        return np.concatenate([v, -pull * x / (r * mass) - np.array([0.0, gravity])])

    return Formulation(derivative, np.array([rest_length, 0.0, 0.0, 0.0]), lambda t, y: (y[None, :2], np.zeros(1)))


def _polar(rest_length, mass, stiffness, damping, gravity) -> Formulation:
    def derivative(t, y):
        r, phi, p, spin = y  # m, rad, kg m/s, kg m^2/s
        turn = spin / (mass * r**2)
        pull = stiffness * (r - rest_length) + damping * p / mass
        push = mass * r * turn**2 - pull - mass * gravity * np.sin(phi)
        return np.array([p / mass, turn, push, -mass * gravity * r * np.cos(phi)], dtype=y.dtype)

    def poses(t, y):
        return y[0] * np.array([[np.cos(y[1]), np.sin(y[1])]]), np.zeros(1)

    return Formulation(derivative, np.array([rest_length, 0.0, 0.0, 0.0]), poses)
