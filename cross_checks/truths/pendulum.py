"""The simple pendulum in Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.numerics.elliptic import amplitude, quarter_period
from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Released from the horizontal: sin(theta/2) = k sn(K + omega t | k^2), k^2 = 1/2 (Whittaker 1904, section 44)."""
    length, gravity = np.longdouble(scene.parameters["length"]), np.longdouble(scene.parameters["gravity"])
    half = np.longdouble(0.5)
    omega = np.sqrt(gravity / length)  # rad/s
    phase = amplitude(quarter_period(half) + omega * times.astype(np.longdouble), half)
    theta = -2 * np.arcsin(np.sqrt(half) * np.sin(phase))  # from straight down; the bob starts at x = -length
    position = length * np.stack([np.sin(theta), -np.cos(theta)], axis=1)
    turns = 1.0 + float(omega) * float(times[-1])
    uncertainty = float(length) * (2.3e-16 + 1e2 * turns * float(np.finfo(np.longdouble).eps))
    return Truth(
        position[:, None].astype(float), np.zeros((len(times), 1)), uncertainty, "exact",
        "Jacobi elliptic functions by the arithmetic-geometric mean in extended precision",
    )  # fmt: skip
