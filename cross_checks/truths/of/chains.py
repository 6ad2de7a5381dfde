"""Truths of trees, converged in absolute coordinates: rods, bodies on spherical joints, and the crash occupants."""

from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.truths.made_by import agree
from cross_checks.truths.made_by.mechanisms import spherical_tree
from cross_checks.truths.made_by.mechanisms.hinged_tree import formulations
from cross_checks.truths.made_by.mechanisms.rod_chain import EXTENDED_UP_TO, Rods, hamilton, lagrange
from cross_checks.truths.truth import NoTruth, Truth, in_space
from mbs_ref import scenes
from mbs_ref.scene import CoordinateDrive, Scene
from mbs_ref.scene.signals import prescribed

# Links. The dense mass matrix, in absolute angles or orientations, takes too long beyond.
LARGEST_PLANAR, LARGEST_SPATIAL = 200, 40
PRECISION = {True: "extended", False: "double"}


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
    extended = len(rods.length) <= EXTENDED_UP_TO
    how = f"Hamilton's equations in absolute angles by extrapolation in {PRECISION[extended]} precision"
    both = lagrange(rods), hamilton(rods)
    return agree(*both, times, ("Lagrange's by DOP853", how), extended=extended)


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
    how = f"Hamilton's equations in absolute orientations by extrapolation in {PRECISION[extended]} precision"
    both, ways = (
        (spherical_tree.newton_euler(tree), spherical_tree.hamilton(tree)),
        ("Newton's and Euler's by DOP853", how),
    )
    return agree(*both, times, ways, extended=extended, is_costly=True)


def android_simplified(scene: Scene, times: np.ndarray) -> Truth:
    """Hamilton's equations by extrapolation from event to event against Lagrange's by DOP853.

    The occupant moves on a driven seat as on a fixed one under the forces m a: the seat's own motion is added.
    """
    fixed = scenes.make(scene.name, **(scene.parameters | {"seat": "fixed"}))
    ways = "Lagrange's by DOP853", "Hamilton's equations in body angles by extrapolation from event to event"
    costly = scene.name == "android_vertebral"
    seen: Any = agree(*formulations(fixed), times, ways, extended=False, is_costly=costly)
    drives = (joint for joint in scene.joints if isinstance(joint, CoordinateDrive) and joint.coordinate == "x")
    drive = next(drives, None)
    along = np.zeros((2, len(times))) if drive is None else prescribed(drive.motion, drive.level, np.asarray(times))
    way, speed = (np.outer(part, (1.0, 0.0))[:, None] for part in along)  # of the seat, all of whose parts move alike
    return replace(seen, position=seen.position + way, velocity=seen.velocity + speed)


def android_spatial(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Lift the planar android's motion, which a pulse from straight ahead gives by symmetry."""
    parameters = dict(scene.parameters)
    if parameters.pop("oblique"):
        return NoTruth("an oblique pulse moves the android out of the plane of its truth")
    return in_space(android_simplified(scenes.make("android_simplified", **parameters), times))


TRUTHS = {"double_gyroscope": spatial_chain, "android_vertebral": android_simplified}
