"""Two gyroscopes in a row are a chain of two links on spherical joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import spatial_chain
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Spins that are fast make it long."""
    truth = spatial_chain.solve(scene, times)
    return truth if isinstance(truth, NoTruth) else replace(truth, is_costly=True)
