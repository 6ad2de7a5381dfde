"""The one error: how far two motions of a scene are apart, in position, orientation and their rates.

Every component counts over the scene's own scales (mbs_ref.scene.scales): metres over its length L, radians as they
are, m/s over L/T and rad/s over 1/T. The distance between a run and the truth, and between two runs, is measured by
this function alone.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from cross_checks.truth import MARGIN, Truth
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.euler_parameters import geodesic_angle
from mbs_ref.scene.scales import Scales, scales_of

NAMES = ("position", "orientation", "velocity", "angular velocity")
UNITS = ("m", "rad", "m/s", "rad/s")


class Motion(Protocol):
    """What a trajectory and a truth have in common; rates may be unknown."""

    @property
    def position(self) -> np.ndarray: ...
    @property
    def orientation(self) -> np.ndarray: ...
    @property
    def velocity(self) -> np.ndarray | None: ...
    @property
    def angular_velocity(self) -> np.ndarray | None: ...


class Differences(NamedTuple):
    """The largest difference over the bodies at each common sample, and of which body."""

    sizes: np.ndarray  # (n_t, 4): m, rad, m/s, rad/s; zero where one of the two does not know
    bodies: np.ndarray  # (n_t, 4) int, place in the scene

    def relative(self, scales: Scales) -> np.ndarray:
        """Return the sizes over the scene's scales (n_t, 4)."""
        with np.errstate(over="ignore"):
            return self.sizes / units_of(scales)


def units_of(scales: Scales) -> np.ndarray:
    """Return what each component is counted in (4,): m, rad, m/s, rad/s."""
    return np.array([scales.length, 1.0, scales.speed, 1.0 / scales.time])


def differences(scene: Scene, first: Motion, second: Motion) -> Differences:
    """Return how far two motions of a scene are apart over the samples that both have."""
    n = min(len(first.position), len(second.position))
    with np.errstate(over="ignore", invalid="ignore"):  # a run that blew up is infinitely far
        per_body = np.stack([
            np.linalg.norm(first.position[:n] - second.position[:n], axis=2),
            _turn(scene, first.orientation[:n], second.orientation[:n]),
            _gap(first.velocity, second.velocity, n, len(scene.bodies)),
            _gap(first.angular_velocity, second.angular_velocity, n, len(scene.bodies)) * _turning(scene),
        ], axis=1)  # fmt: skip
    per_body = np.nan_to_num(per_body, nan=0.0, posinf=np.inf)  # a truth may not cover every time
    return Differences(np.max(per_body, axis=2), np.argmax(per_body, axis=2))


def from_truth(scene: Scene, path: Motion, truth: Truth) -> Differences:
    """Return how far a run is from the truth; rates count where they differ by MARGIN times what the truth knows."""
    gap = differences(scene, path, truth)
    if truth.velocity is None or truth.rate_uncertainty is None:
        gap.sizes[:, 2:] = 0.0
        return gap
    known = gap.sizes[:, 2:] >= MARGIN * truth.rate_uncertainty[: len(gap.sizes), None]
    gap.sizes[:, 2:] *= known
    return gap


def known_to(scene: Scene, truth: Truth) -> float:
    """Return how well poses of a truth are known, in the measure of the error: the worse of places and turns."""
    length = scales_of(scene).length
    arm = min((body.gyration_radius for body in scene.bodies if body.gyration_radius > 0.0), default=length)
    turn = truth.uncertainty / arm if truth.turn_uncertainty is None else truth.turn_uncertainty
    return max(truth.uncertainty / length, turn)


def _turn(scene: Scene, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the angle between orientations (n_t, n_bodies), rad in [0, pi]; whole turns in the plane do not count."""
    if first.ndim != second.ndim:  # particles, which a truth gives no Euler parameters
        return np.zeros(first.shape[:2])
    if first.ndim == 3:
        angle = geodesic_angle(first, second)
    else:
        angle = np.abs(np.remainder(first - second + np.pi, 2.0 * np.pi) - np.pi)
    return angle * _turning(scene)


def _turning(scene: Scene) -> np.ndarray:
    """Return 1 for every body that has an orientation, 0 for particles (n_bodies,)."""
    return np.array([0.0 if isinstance(body, PointMass) else 1.0 for body in scene.bodies])


def _gap(first: np.ndarray | None, second: np.ndarray | None, n: int, bodies: int) -> np.ndarray:
    if first is None or second is None:
        return np.zeros((n, bodies))
    apart = first[:n] - second[:n]
    return np.abs(apart) if apart.ndim == 2 else np.linalg.norm(apart, axis=2)
