"""Truths of the crash occupants, converged in the angles of their bodies with forces of their own."""

from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.truths.made_by.agreement import agree
from cross_checks.truths.made_by.mechanisms.hinged_tree import formulations
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.observables.signal_values import motion
from mbs_ref.scene import CoordinateDrive, Scene


def android_simplified(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Hamilton's equations by extrapolation from event to event against Lagrange's by DOP853.

    The occupant moves on a driven seat as on a fixed one under the forces m a: the seat's own motion is added.
    """
    fixed = scenes.make(scene.name, **(scene.parameters | {"seat": "fixed"}))
    ways = "Lagrange's by DOP853", "Hamilton's equations in body angles by extrapolation from event to event"
    seen: Any = agree(*formulations(fixed), times, ways, extended=False)
    way, speed = _seat_motion(scene, times)
    return replace(seen, position=seen.position + way[:, None], velocity=seen.velocity + speed[:, None])


def _seat_motion(scene: Scene, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a driven seat is from its place at t = 0 (n_t, 2), m, and its velocity; all its parts alike."""
    drives = (joint for joint in scene.joints if isinstance(joint, CoordinateDrive) and joint.coordinate == "x")
    drive = next(drives, None)
    along = np.zeros((2, len(times))) if drive is None else motion(drive.motion, drive.level, np.asarray(times))
    way, speed = (np.outer(part, (1.0, 0.0)) for part in along)
    return way, speed


def android_vertebral(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Converge the vertebral android."""
    truth = android_simplified(scene, times)
    return truth if isinstance(truth, NoTruth) else replace(truth, is_costly=True)


def android_spatial(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Lift the planar android's motion, which a pulse from straight ahead gives by symmetry."""
    parameters = dict(scene.parameters)
    if parameters.pop("oblique"):
        return NoTruth("an oblique pulse moves the android out of the plane of its truth")
    flat = android_simplified(scenes.make("android_simplified", **parameters), times)
    if isinstance(flat, NoTruth):
        return flat
    half, speed, turning = 0.5 * flat.orientation, np.asarray(flat.velocity), np.asarray(flat.angular_velocity)
    none = np.zeros_like(half)
    return replace(
        flat, position=np.insert(flat.position, 2, 0.0, axis=2), velocity=np.insert(speed, 2, 0.0, axis=2),
        orientation=np.stack((np.cos(half), none, none, np.sin(half)), axis=2),
        angular_velocity=np.stack((none, none, turning), axis=2),
    )  # fmt: skip
