"""Bricard's mechanism in the one coordinate its geometry leaves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cross_checks.certify.agreement import converged
from cross_checks.certify.mechanisms.one_freedom import agree_on
from cross_checks.certify.numerics import jet
from cross_checks.certify.numerics.jet import Jet
from cross_checks.truth import Truth
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scenes.bricard import AXES, CORNERS

ROOT3 = np.sqrt(np.longdouble(3))
START = np.arctan2(np.sqrt(np.longdouble(2)), np.longdouble(1))  # both angles are right ones there


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Three hinges turn by theta, the three between them by phi, with cos(theta/2) cos(phi/2) = 1/2.

    The threefold-symmetric linkage with right-angled twists (Chen, You, Tarnai, Int. J. Solids Struct. 42
    (2005) 2287: cos(theta) + cos(phi) + cos(theta) cos(phi) = 0). The half-angles are the legs of a right
    spherical triangle of hypotenuse 60 degrees; its angle s is a coordinate without turning points.
    """
    rods = [np.subtract(b, a) for a, b in pairwise(CORNERS)]
    bodies = (body for body in scene.bodies if isinstance(body, SpatialBody))
    start = [rotation_matrices(body.orientation).astype(np.longdouble) for body in bodies]
    right = 2 * np.arctan(np.longdouble(1))

    def poses(s: Jet) -> tuple[Jet, Jet]:
        theta, phi = jet.arctan(jet.cos(s) * ROOT3) * 2, jet.arcsin(jet.sin(s) * (ROOT3 / 2)) * 2
        turns = (jet.lift(right) - theta, jet.lift(right) - phi)  # from the start, about the scene's axes
        turned, corner = jet.lift(np.eye(3)), jet.lift(np.zeros(3))
        places, axes = [], []
        for k, (rod, frame) in enumerate(zip(rods, start, strict=True)):
            turned = turned @ jet.turn(AXES[k], turns[k % 2])
            along = turned @ rod
            places.append(corner + along * 0.5)
            axes.append(turned @ frame)
            corner = corner + along
        return jet.stack(places), jet.stack(axes)

    agreement = agree_on(scene, poses, START, np.longdouble(0), times)
    return converged(
        agreement, "Lagrange's by DOP853",
        "Hamilton's equations in the one coordinate of the closed loop by extrapolation in extended precision",
    )  # fmt: skip
