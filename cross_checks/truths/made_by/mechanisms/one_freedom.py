"""A conservative mechanism of one freedom: Lagrange's and Hamilton's equations in the coordinate that it leaves."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.made_by.numerics.jet import Jet, parameter
from cross_checks.truths.made_by.numerics.tabulated import Tabulated
from cross_checks.truths.truth import Truth
from mbs_ref.scene import PlanarBody, Scene, SpatialBody, symmetric
from mbs_ref.scene.euler_parameters import from_matrix


@dataclass(frozen=True)
class OneFreedom:
    """Where every body is as a function of one coordinate s; kinetic energy is J(s) s'^2 / 2."""

    poses: Callable[[Jet], tuple[Jet, Jet]]  # s -> centres (n, d) m, and axes (n, 3, 3) or angles (n,), as jets
    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # kg m^2 about the centres: (n, 3, 3) in body axes, or (n,) in the plane
    gravity: np.ndarray  # (d,) m/s^2
    start: Any  # s at t = 0, in any precision
    rate: Any  # s' at t = 0
    stored: Callable[[Jet], Jet] = lambda s: s * 0  # s -> the potential of all forces but weight, J

    def at(self, s):
        """Return J, J' / 2, V and V' at s."""
        place, turn = self.poses(parameter(s))
        if self.inertia.ndim == 1:
            spin, more, momentum = turn.first, turn.second, self.inertia * turn.first
        else:
            back = np.swapaxes(turn.value, 1, 2)
            spin, more = _axial(back @ turn.first), _axial(back @ turn.second)
            momentum = np.einsum("kij,kj->ki", self.inertia, spin)
        size = np.sum(self.mass[:, None] * place.first**2) + np.sum(spin * momentum)
        half_slope = np.sum(self.mass[:, None] * place.first * place.second) + np.sum(more * momentum)
        weight, stored = self.mass[:, None] * self.gravity, self.stored(parameter(s))
        height, pull = -np.sum(place.value * weight), -np.sum(place.first * weight)
        return size, half_slope, height + stored.value, pull + stored.first

    def world(self, s) -> tuple[np.ndarray, np.ndarray]:
        """Return centres (n, d), and Euler parameters (n, 4) or angles (n,)."""
        place, turn = self.poses(parameter(s))
        return place.value, turn.value if self.inertia.ndim == 1 else np.array([from_matrix(a) for a in turn.value])


def _axial(matrices):
    """Return the vectors of the skew parts."""
    skew = (matrices - np.swapaxes(matrices, 1, 2)) / 2
    return np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)


def lagrange(given: OneFreedom) -> Formulation:
    """J s'' + J' s'^2 / 2 + V' = 0 with the slopes by the rules of differentiation."""
    terms = Tabulated(lambda s: np.array(given.at(s)))

    def derivative(t, y):
        size, half_slope, _, pull = terms(y[0])
        return np.array([y[1], -(half_slope * y[1] ** 2 + pull) / size], dtype=y.dtype)

    return Formulation(derivative, np.array([given.start, given.rate]), lambda t, y: given.world(y[0]))


def hamilton(given: OneFreedom) -> Formulation:
    """p = J s', p' = J' s'^2 / 2 - V', with J' and V' by a complex step: exact to rounding."""
    tiny = np.clongdouble(1e-30j)

    def stepped(s: np.longdouble) -> np.ndarray:
        size, _, height, _ = given.at(s + tiny)
        return np.array([size.real, size.imag / tiny.imag, height.real, height.imag / tiny.imag])

    terms = Tabulated(stepped)

    def derivative(t, y):
        size, slope, _, pull = terms(y[0])
        turning = y[1] / size
        return np.array([turning, 0.5 * slope * turning**2 - pull], dtype=y.dtype)

    start = np.array([given.start, given.at(given.start)[0] * given.rate])
    return Formulation(derivative, start, lambda t, y: given.world(y[0]))


def agree_on(
    scene: Scene, poses: Callable[[Jet], tuple[Jet, Jet]], start: Any, rate: Any, times: np.ndarray,
    ways: tuple[str, str], *, stored: Callable[[Jet], Jet] = OneFreedom.stored, is_costly: bool = False,
) -> Truth:  # fmt: skip
    """Return the truth, solved both ways, of a scene whose bodies, in its order, are where `poses` says."""
    mass = np.array([body.mass for body in scene.bodies])
    rigid = (body for body in scene.bodies if isinstance(body, PlanarBody | SpatialBody))
    inertia = np.array([body.inertia if isinstance(body, PlanarBody) else symmetric(body.inertia) for body in rigid])
    given = OneFreedom(poses, mass, inertia, np.array(scene.gravity), start, rate, stored)
    return agree(lagrange(given), hamilton(given), times, ways, extended=True, is_costly=is_costly)
