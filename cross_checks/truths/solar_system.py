"""The solar system's model, converged; how near the model is to reality, cross_checks.ephemerides.observed asks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cross_checks.certify.sky.particles import converge
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import seek_truth
from mbs_ref import scenes
from mbs_ref.scene import Scene, SpatialBody


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion of the scene's own equations; a sphere's steady spin is exact."""
    if scene.parameters["formulation"] == "point":
        return converge(scene, times)
    points = {**scene.parameters, "formulation": "point", "spin": False}
    truth = seek_truth(scenes.make(scene.name, **points), times)  # which may be known already
    if isinstance(truth, NoTruth):
        return truth
    spins = [body.angular_velocity for body in scene.bodies if isinstance(body, SpatialBody)]
    spinning = np.broadcast_to(spins, truth.position.shape)
    return replace(truth, orientation=_turned(scene, times), angular_velocity=spinning)


def _turned(scene: Scene, times: np.ndarray) -> np.ndarray:
    """Return the Euler parameters (n_t, n_bodies, 4) of spheres that turn steadily from the identity."""
    result = np.zeros((len(times), len(scene.bodies), 4))
    result[..., 0] = 1.0
    for k, body in enumerate(scene.bodies):
        assert isinstance(body, SpatialBody)
        rate = np.linalg.norm(body.angular_velocity)
        if rate > 0.0:
            half = 0.5 * rate * times
            result[:, k] = np.column_stack(
                (np.cos(half), np.outer(np.sin(half), np.array(body.angular_velocity) / rate))
            )
    return result
