"""Truths of closed loops with one degree of freedom."""

from itertools import pairwise

import numpy as np

from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import Truth
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_axis_angle, rotation_matrices
from mbs_ref.scenes.bricard import AXES, CORNERS


def n_four_bar(scene: Scene, times: np.ndarray) -> Truth:
    """All cranks turn alike: [(N+1)/3 + N] theta'' = [(N+1)/2 + N] g sin(theta), theta(0) = 0, theta'(0) = 1.

    Energy gives (theta/2)'^2 = 1/4 + kappa sin^2(theta/2), so theta/2 + pi/2 = am(K + t sqrt(1/4 + kappa) | m)
    with m = 4 kappa / (1 + 4 kappa).
    """
    loops = int(scene.parameters["loops"])
    theta = _crank_angle(loops, np.longdouble(scene.parameters["gravity"]), times.astype(np.longdouble))
    tip = np.stack([np.sin(theta), np.cos(theta)], axis=1)  # B_k - A_k, m
    feet = np.arange(loops + 1)[:, None] * np.array([1.0, 0.0])
    cranks = feet + tip[:, None] / 2
    couplers = feet[:-1] + np.array([0.5, 0.0]) + tip[:, None]
    upright = np.arctan2(np.longdouble(1), np.longdouble(0))
    angle = np.concatenate([np.repeat((upright - theta)[:, None], loops + 1, 1), np.zeros((len(times), loops))], 1)
    rounding = 1e3 * float(np.finfo(np.longdouble).eps) * (1.0 + 10.0 * float(times[-1]))
    return Truth(
        np.concatenate([cranks, couplers], axis=1).astype(float), angle.astype(float),
        2.3e-16 * (loops + 1) + rounding, "exact",
        "one degree of freedom; Jacobi's amplitude by the arithmetic-geometric mean in extended precision",
    )  # fmt: skip


def _crank_angle(loops: int, gravity, times: np.ndarray) -> np.ndarray:
    """Crank angle (n_t,) from the vertical, rad."""
    one = np.longdouble(1)
    kappa = gravity * ((loops + 1) * one / 2 + loops) / ((loops + 1) * one / 3 + loops)  # 1/s^2
    m = 4 * kappa / (1 + 4 * kappa)
    phase = amplitude(quarter_period(m) + times * np.sqrt(one / 4 + kappa), m)
    return 2 * phase - 2 * np.arctan2(one, one * 0)


def spatial_n_four_bar(scene: Scene, times: np.ndarray) -> Truth:
    """Lift the exact planar motion into the plane z = 0."""
    plane = n_four_bar(scene, times)
    position = np.concatenate([plane.position, np.zeros((*plane.position.shape[:2], 1))], axis=2)
    turned = from_axis_angle((0.0, 0.0, 1.0), plane.orientation)
    return Truth(position, turned, plane.uncertainty, plane.kind, plane.how)


ROOT3 = np.sqrt(np.longdouble(3))
BRICARD_START = np.arctan2(np.sqrt(np.longdouble(2)), np.longdouble(1))  # both angles are right ones there


def bricard(scene: Scene, times: np.ndarray) -> Truth:
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

    how = "Hamilton's equations in the one coordinate of the closed loop by extrapolation in extended precision"
    return agree_on(scene, poses, BRICARD_START, np.longdouble(0), times, ("Lagrange's by DOP853", how))
