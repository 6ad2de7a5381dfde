"""Chains on spherical joints, converged in absolute orientations."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.agreement import agree, converged
from cross_checks.certify.mechanisms.spherical_tree import EXTENDED_UP_TO, hamilton, newton_euler, spherical_tree
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene

LARGEST = 40  # bodies: the dense mass matrix takes too long beyond


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Newton's and Euler's equations by DOP853 against Hamilton's by extrapolation."""
    bodies = len(scene.bodies)
    if bodies > LARGEST:
        return NoTruth(f"the chain's truth is converged up to {LARGEST} links, and this one has {bodies}")
    tree, extended = spherical_tree(scene), bodies <= EXTENDED_UP_TO
    agreement = agree(newton_euler(tree), hamilton(tree), times, extended=extended)
    precision = "extended" if extended else "double"
    return converged(
        agreement, "Newton's and Euler's by DOP853",
        f"Hamilton's equations in absolute orientations by extrapolation in {precision} precision",
        is_costly=True,
    )  # fmt: skip
