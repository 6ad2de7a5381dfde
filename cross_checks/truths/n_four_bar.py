"""The N-four-bar, exactly one degree of freedom."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.numerics.elliptic import amplitude, quarter_period
from cross_checks.truth import Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """All cranks turn alike: [(N+1)/3 + N] theta'' = [(N+1)/2 + N] g sin(theta), theta(0) = 0, theta'(0) = 1.

    Energy gives (theta/2)'^2 = 1/4 + kappa sin^2(theta/2), so theta/2 + pi/2 = am(K + t sqrt(1/4 + kappa) | m)
    with m = 4 kappa / (1 + 4 kappa).
    """
    loops = int(scene.parameters["loops"])
    theta = _angle(loops, np.longdouble(scene.parameters["gravity"]), times.astype(np.longdouble))
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


def _angle(loops: int, gravity, times: np.ndarray) -> np.ndarray:
    """Crank angle (n_t,) from the vertical, rad."""
    one = np.longdouble(1)
    kappa = gravity * ((loops + 1) * one / 2 + loops) / ((loops + 1) * one / 3 + loops)  # 1/s^2
    m = 4 * kappa / (1 + 4 * kappa)
    phase = amplitude(quarter_period(m) + times * np.sqrt(one / 4 + kappa), m)
    return 2 * phase - 2 * np.arctan2(one, one * 0)
