"""Joint stops: what keeps an android's joints within a person's range of motion.

Like the ligaments that do so, a stop is a pair of strings across the joint that are slack within the range and pull
beyond it. Each is tied to levers that stand at a right angle, or wider where the range asks it, as it becomes taut.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbs_ref.crash.places import Places, Point
from mbs_ref.observables.attachment import Motion, length_of, pull_of
from mbs_ref.scene import SpringDamper

STOP = "stop."
MARGIN = math.radians(10.0)  # of the taut levers' angle over half the range: the other end of it stays slack


def joint_stops(joints: list[dict[str, Any]], stops: dict[str, Any], places: Places) -> Iterator[SpringDamper]:
    """Yield two strings for each of an android's joints whose range is known."""
    ranges = {entry["joint"]: entry for entry in (*stops["ranges"], *stops["spine"])}
    for joint in joints:
        entry = ranges.get(f"{joint['body_i']}-{joint['body_j']}")
        if entry is not None:
            yield from _strings(joint, bounds(joint, entry, places), stops, places)


def bounds(joint: dict[str, Any], entry: dict[str, Any], places: Places) -> tuple[float, float]:
    """Return how far (rad) theta_j - theta_i may fall and rise from its value at t = 0."""
    now = places.pose(joint["body_j"])[1] - places.pose(joint["body_i"])[1]
    if "from_posture" in entry:
        low, high = (math.radians(x) for x in entry["from_posture"])
    else:
        low, high = (math.radians(x) - now for x in entry["range"])
    if not low <= 0.0 <= high:
        raise ValueError(f"joint {entry['joint']} is at {math.degrees(now):.1f} deg, beyond its range {entry}")
    return low, high


def _strings(joint: dict[str, Any], limits: tuple[float, float], stops: dict[str, Any], places: Places):
    low, high = limits
    long, short = stops["lever"], stops["lever"] * stops["lever_ratio"]
    taut = max(0.5 * math.pi, 0.5 * (high - low) + MARGIN)
    rest = math.sqrt(long**2 + short**2 - 2.0 * long * short * math.cos(taut))
    arm = long * short * math.sin(taut) / rest  # m, of the pull about the joint as it sets in
    i, j = joint["body_i"], joint["body_j"]
    hinge = places.point(i, joint["point_i"])
    for side, angle in (("most", taut - high), ("least", -taut - low)):
        yield SpringDamper(
            name=f"{STOP}{i}-{j}.{side}", body_a=i, body_b=j, point_a=_at(hinge, long, 0.0),
            point_b=_at(hinge, short, angle), stiffness=stops["stiffness_factor"] * joint["torsion_k"] / arm**2,
            damping=joint["torsion_c"] / arm**2, rest_length=rest, tension_only=True,
        )  # fmt: skip


def _at(hinge: Point, lever: float, angle: float) -> Point:
    return hinge[0] + lever * math.cos(angle), hinge[1] + lever * math.sin(angle)


def tension(motion: Motion, string: SpringDamper) -> np.ndarray:
    """Return the pull (n_t,), N, of a spring."""
    return pull_of(string, *length_of(motion, string)[1:])[0]


def stop_load(motion: Motion, hinge: tuple[float, ...], upper: str, lower: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the force (n_t, 2), N, of a joint's stops on its upper body, and the moment (n_t,), N m, about `hinge`."""
    force, moment = np.zeros((len(motion.times), 2)), np.zeros(len(motion.times))
    at, _ = motion.point(upper, hinge)
    for string in motion.scene.loads:
        if not (isinstance(string, SpringDamper) and string.name.startswith(STOP)):
            continue
        marks = {string.body_a: string.point_a, string.body_b: string.point_b}
        if marks.keys() != {upper, lower}:
            continue
        here, there = (motion.point(body, marks[body])[0] for body in (upper, lower))
        along = (there - here) / np.linalg.norm(there - here, axis=1)[:, None]
        pull = tension(motion, string)[:, None] * along
        force += pull
        moment += (here - at)[:, 0] * pull[:, 1] - (here - at)[:, 1] * pull[:, 0]
    return force, moment
