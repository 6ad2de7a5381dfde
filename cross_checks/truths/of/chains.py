"""Truths of chains of rods and of bodies on spherical joints, converged in absolute coordinates."""

import numpy as np

from cross_checks.truths.made_by.agreement import agree
from cross_checks.truths.made_by.mechanisms import rod_chain, spherical_tree
from cross_checks.truths.made_by.mechanisms.rod_chain import Rods
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene

# Links. The dense mass matrix, in absolute angles or orientations, takes too long beyond.
LARGEST_PLANAR, LARGEST_SPATIAL = 200, 40


def pendulum_chain(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Lagrange's equations by DOP853 against Hamilton's by extrapolation, both in absolute angles."""
    links = len(scene.bodies)
    if links > LARGEST_PLANAR:
        return NoTruth(f"the chain's truth is converged up to {LARGEST_PLANAR} links, and this one has {links}")
    return released(rods_of(scene, np.ones(links)), times)


def rods_of(scene: Scene, length: np.ndarray) -> Rods:
    """Read masses, inertias and starting angles from the bodies; lengths (n,) in m."""
    mass, inertia, angle = (np.array([getattr(b, key) for b in scene.bodies]) for key in ("mass", "inertia", "angle"))
    return Rods(length, mass, inertia, -scene.gravity[1], angle)


def released(rods: Rods, times: np.ndarray) -> Truth:
    """Return the truth of rods released from rest."""
    extended = len(rods.length) <= rod_chain.EXTENDED_UP_TO
    how = f"Hamilton's equations in absolute angles by extrapolation in {_precision(extended)} precision"
    both = rod_chain.lagrange(rods), rod_chain.hamilton(rods)
    return agree(*both, times, ("Lagrange's by DOP853", how), extended=extended)


def _precision(extended: bool) -> str:
    return "extended" if extended else "double"


def double_pendulum(scene: Scene, times: np.ndarray) -> Truth:
    """Converge the chain's equations for two rods."""
    length = np.array([scene.parameters["length_1"], scene.parameters["length_2"]], dtype=float)
    return released(rods_of(scene, length), times)


def spatial_chain(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Newton's and Euler's equations by DOP853 against Hamilton's by extrapolation."""
    bodies = len(scene.bodies)
    if bodies > LARGEST_SPATIAL:
        return NoTruth(f"the chain's truth is converged up to {LARGEST_SPATIAL} links, and this one has {bodies}")
    tree, extended = spherical_tree.spherical_tree(scene), bodies <= spherical_tree.EXTENDED_UP_TO
    how = f"Hamilton's equations in absolute orientations by extrapolation in {_precision(extended)} precision"
    both, ways = (
        (spherical_tree.newton_euler(tree), spherical_tree.hamilton(tree)),
        ("Newton's and Euler's by DOP853", how),
    )
    return agree(*both, times, ways, extended=extended, is_costly=True)


TRUTHS = {"double_gyroscope": spatial_chain}
