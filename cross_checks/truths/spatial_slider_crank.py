"""The spatial slider-crank in the crank angle alone."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.agreement import converged
from cross_checks.certify.mechanisms.one_freedom import agree_on
from cross_checks.certify.numerics import jet
from cross_checks.certify.numerics.jet import Jet
from cross_checks.truth import Truth
from mbs_ref.scene import Scene, Universal
from mbs_ref.scenes.slider_cranks import PIVOT


def solve(scene: Scene, times: np.ndarray) -> Truth:
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
    agreement = agree_on(scene, poses, 0.0, float(scene.parameters["crank_speed"]), times)
    return converged(
        agreement, "Lagrange's by DOP853",
        "Hamilton's equations in the crank angle by extrapolation in extended precision", is_costly=True,
    )  # fmt: skip
