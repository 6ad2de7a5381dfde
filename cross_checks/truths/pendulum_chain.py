"""Chains of rods, converged in minimal coordinates."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.agreement import agree, agreed
from cross_checks.certify.mechanisms.rod_chain import EXTENDED_UP_TO, Rods, hamilton, lagrange
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene

LARGEST = 200  # links: the dense mass matrix in absolute angles takes too long beyond


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Lagrange's equations by DOP853 against Hamilton's by extrapolation, both in absolute angles."""
    links = len(scene.bodies)
    if links > LARGEST:
        return NoTruth(f"the chain's truth is converged up to {LARGEST} links, and this one has {links}")
    return converged(rods_of(scene, np.ones(links)), times)


def rods_of(scene: Scene, length: np.ndarray) -> Rods:
    """Read masses, inertias and starting angles from the bodies; lengths (n,) in m."""
    mass, inertia, angle = (np.array([getattr(b, key) for b in scene.bodies]) for key in ("mass", "inertia", "angle"))
    return Rods(length, mass, inertia, -scene.gravity[1], angle)


def converged(rods: Rods, times: np.ndarray) -> Truth:
    """Return the truth of rods released from rest."""
    extended = len(rods.length) <= EXTENDED_UP_TO
    agreement = agree(lagrange(rods), hamilton(rods), times, extended=extended)
    precision = "extended" if extended else "double"
    how = (
        f"Hamilton's equations in absolute angles by extrapolation in {precision} precision; "
        f"Lagrange's by DOP853 differ by {agreement.difference:.1e} m; "
        f"a start error grows {agreement.sensitivity:.1e}-fold"
    )
    return agreed(agreement, how)
