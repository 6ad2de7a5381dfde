"""Truths of the planar and the spatial slider-crank, in the crank angle alone."""

from dataclasses import dataclass

import numpy as np

from cross_checks.truths.made_by.agreement import Formulation, agree
from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import Truth
from mbs_ref.scene import Scene, Universal
from mbs_ref.scenes.slider_cranks import PIVOT

WAYS = "Lagrange's by DOP853", "Hamilton's equations in the crank angle by extrapolation in extended precision"


def slider_crank(scene: Scene, times: np.ndarray) -> Truth:
    """Lagrange's equation, differentiated by hand, against Hamilton's, differentiated by complex steps."""
    given = scene.parameters
    mass, inertia = (np.array([getattr(b, key) for b in scene.bodies]) for key in ("mass", "inertia"))
    crank = Crank(float(given["crank_length"]), float(given["rod_length"]), mass, inertia, float(given["gravity"]))
    phi, rate = float(given["crank_angle"]), float(given["crank_speed"])
    return agree(_lagrange(crank, phi, rate), _hamilton(crank, phi, rate), times, WAYS, extended=True)


@dataclass(frozen=True)
class Crank:
    """Crank, rod, slider, in this order."""

    r: float  # m
    length: float  # m, of the rod
    mass: np.ndarray  # (3,) kg
    inertia: np.ndarray  # (3,) kg m^2
    gravity: float  # m/s^2

    def rod(self, phi):
        """Return the rod's angle psi and its first two derivatives by phi: r sin(phi) + l sin(psi) = 0."""
        ratio = self.r / self.length
        psi = -np.arcsin(ratio * np.sin(phi))
        first = -ratio * np.cos(phi) / np.cos(psi)
        return psi, first, (ratio * np.sin(phi) + first**2 * np.sin(psi)) / np.cos(psi)

    def places(self, phi):
        """Return centres (3, 2) and angles (3,)."""
        psi, _, _ = self.rod(phi)
        pin, reach = self.r * _turned(phi), self.length * _turned(psi)
        return np.stack([pin / 2, pin + reach / 2, (pin + reach) * np.array([1, 0])]), np.array([phi, psi, 0 * phi])

    def slopes(self, phi):
        """Return d(centres)/dphi (3, 2) and d(angles)/dphi (3,)."""
        psi, first, _ = self.rod(phi)
        pin, reach = self.r * _across(phi), self.length * first * _across(psi)
        return np.stack([pin / 2, pin + reach / 2, (pin + reach) * np.array([1, 0])]), np.array([1, first, 0])

    def inertia_of(self, phi):
        """Return J(phi), kg m^2: kinetic energy is J phi'^2 / 2."""
        centres, angles = self.slopes(phi)
        return np.sum(self.mass[:, None] * centres**2) + np.sum(self.inertia * angles**2)

    def weight(self, phi):
        """Return dV/dphi, N m."""
        return self.gravity * np.sum(self.mass * self.slopes(phi)[0][:, 1])


def _turned(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def _across(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


def _lagrange(crank: Crank, phi: float, rate: float) -> Formulation:
    """J phi'' + J' phi'^2 / 2 + V' = 0 with J' written out."""

    def half_slope(angle):
        psi, first, second = crank.rod(angle)
        pin, reach = -crank.r * _turned(angle), crank.length * (second * _across(psi) - first**2 * _turned(psi))
        bends = np.stack([pin / 2, pin + reach / 2, (pin + reach) * np.array([1, 0])])
        centres, _ = crank.slopes(angle)
        return np.sum(crank.mass[:, None] * centres * bends) + crank.inertia[1] * first * second

    def derivative(t, y):
        pull = half_slope(y[0]) * y[1] ** 2 + crank.weight(y[0])
        return np.array([y[1], -pull / crank.inertia_of(y[0])])

    return Formulation(derivative, np.array([phi, rate]), lambda t, y: crank.places(y[0]))


def _hamilton(crank: Crank, phi: float, rate: float) -> Formulation:
    """p = J phi', p' = J' phi'^2 / 2 - V', both slopes by a complex step: exact to rounding."""
    tiny = np.clongdouble(1e-30j)

    def derivative(t, y):
        turn = y[1] / crank.inertia_of(y[0])
        slope = crank.inertia_of(y[0] + tiny).imag / tiny.imag
        height = np.sum(crank.mass * crank.places(y[0] + tiny)[0][:, 1]).imag / tiny.imag
        return np.array([turn, slope * turn**2 / 2 - crank.gravity * height])

    start = np.array([phi, crank.inertia_of(phi) * rate])
    return Formulation(derivative, start, lambda t, y: crank.places(y[0]))


def spatial_slider_crank(scene: Scene, times: np.ndarray) -> Truth:
    """Crank about x from upright; the rod from its pin to the slider, turned as the universal joint lets it."""
    crank, rod = float(scene.parameters["crank_length"]), float(scene.parameters["rod_length"])
    wrist = next(joint for joint in scene.joints if isinstance(joint, Universal))
    second, first = (np.array(axis) / np.linalg.norm(axis) for axis in (wrist.axis_a, wrist.axis_b))

    def poses(angle: Jet) -> tuple[Jet, Jet]:
        turned = jet.turn((1.0, 0.0, 0.0), angle)
        arm = turned @ np.array([0.0, 0.0, crank])
        pin = arm + PIVOT
        across = pin * pin
        reach = jet.sqrt(jet.lift(rod**2) - across[1] - across[2])
        slide = reach * np.array([1.0, 0.0, 0.0])
        along = (slide - pin) * (1 / rod)
        normal = jet.unit(jet.cross(along, second)) * sign
        axes = jet.stack([along, normal, jet.cross(along, normal)], axis=1)
        places = jet.stack([arm * 0.5 + PIVOT, (pin + slide) * 0.5, slide])
        return places, jet.stack([turned, axes, jet.lift(np.eye(3))])

    sign = 1.0
    sign = float(np.sign(poses(jet.parameter(0.0))[1].value[1][:, 1] @ first))
    return agree_on(scene, poses, 0.0, float(scene.parameters["crank_speed"]), times, WAYS, is_costly=True)
