"""Truths of the planar and the spatial slider-crank, in the crank angle alone."""

import numpy as np

from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import Truth
from mbs_ref.scene import Scene, Universal
from mbs_ref.scenes.slider_cranks import PIVOT

WAYS = "Lagrange's by DOP853", "Hamilton's equations in the crank angle by extrapolation in extended precision"


def slider_crank(scene: Scene, times: np.ndarray) -> Truth:
    """Crank at phi, rod at psi: r sin(phi) + l sin(psi) = 0."""
    given = scene.parameters
    crank, rod = float(given["crank_length"]), float(given["rod_length"])

    def poses(phi: Jet) -> tuple[Jet, Jet]:
        psi = -jet.arcsin(jet.sin(phi) * (crank / rod))
        pin, reach = (jet.stack([jet.cos(a), jet.sin(a)]) * size for a, size in ((phi, crank), (psi, rod)))
        slider = jet.stack([(pin + reach)[0], phi * 0])
        return jet.stack([pin * 0.5, pin + reach * 0.5, slider]), jet.stack([phi, psi, phi * 0])

    return agree_on(scene, poses, float(given["crank_angle"]), float(given["crank_speed"]), times, WAYS)


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
