"""A stack that settles: masses on springs and dampers, linear while no corner lets go, by the matrix exponential."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import expm

from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene

UNCERTAINTY = 1e-12  # m, of the matrix exponential at these sinks
LOOKS = 400  # times at which the corners are asked whether they still push


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """y = (heights above the start, rates) obeys y' = A y + b."""
    law: Any = scene.contacts[0].law
    mass = np.array([body.mass for body in scene.bodies])
    n = len(mass)
    below = np.eye(n) - np.eye(n, k=-1)  # compression d = -below z
    stiff, damp = 4.0 * law.stiffness * below.T @ below, 4.0 * law.damping * below.T @ below
    matrix = np.zeros((2 * n + 1, 2 * n + 1))
    matrix[:n, n : 2 * n] = np.eye(n)
    matrix[n : 2 * n, :n] = -stiff / mass[:, None]
    matrix[n : 2 * n, n : 2 * n] = -damp / mass[:, None]
    matrix[n : 2 * n, -1] = scene.gravity[2]
    start = np.append(np.zeros(2 * n), 1.0)
    looks = np.concatenate((np.geomspace(1e-6, 1.0, LOOKS) * max(float(times[-1]), 1e-6), times[times > 0.0]))
    seen = np.array([expm(matrix * t) @ start for t in looks])
    push = -(law.stiffness * seen[:, :n] + law.damping * seen[:, n : 2 * n]) @ below.T
    if not np.all(push > 0.0):
        return NoTruth("a corner lets go while the stack settles; the linear motion holds while all push")
    sunk = np.array([(expm(matrix * t) @ start)[:n] for t in times])
    position = np.array([body.position for body in scene.bodies])[None] + sunk[:, :, None] * np.array([0.0, 0.0, 1.0])
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), n, 1))
    return Truth(position, still, UNCERTAINTY, "exact", "the linear motion of masses on springs, matrix exponential")
