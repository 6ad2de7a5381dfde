"""The tracked vehicle: ever faster, ever tighter, and on ever steeper slopes. No truth is converged for it.

Without ground and gravity nothing acts from outside: whatever the track does, momentum and angular momentum stay zero,
and so they are judged, by the poses alone. On a slope energy may only fall, and no faster than the fall allows.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from cross_checks.extremes import Case, Measured, grid, open_joints, worst
from cross_checks.extremes.parts import GRAVITY
from mbs_ref import Trajectory, scenes
from mbs_ref.observables import kinetic_energy
from mbs_ref.observables.momentum import angular_momentum, linear_momentum, spins
from mbs_ref.scene import Scene, SpringDamper

END, STEP, RTOL = 0.03, 1e-4, 1e-7  # s, s
OPEN = open_joints(0.154)  # m: the track's pitch


def _afloat(torque: float, *ties: Any) -> Case:
    """The vehicle without ground and weight; torque (N m) on its sprocket."""
    scene = scenes.make("tracked_vehicle", model="paper", torque=torque, ramp=0.01)
    contacts = tuple(part for part in scene.contacts if part.body_b != "ground")
    scene = scene.model_copy(
        update={"name": "track_afloat", "parameters": {}, "gravity": (0.0, 0.0), "contacts": contacts,
                "loads": (*scene.loads, *ties)},
    )  # fmt: skip
    return Case(scene, grid(END, STEP, 6), worst(momentum, OPEN), step=STEP, rtol=RTOL)


def _tight(force: float) -> Case:
    """Springs draw the upper run towards the lower one with `force` (N)."""
    scene = scenes.make("tracked_vehicle", model="paper")
    upper, lower = (_middle(scene, choose) for choose in (max, min))
    ends = [tuple(scene.bodies[k].position) for k in (upper, lower)]
    length = math.dist(*ends)
    tie = SpringDamper(
        name="tie", body_a=scene.body_names[upper], body_b=scene.body_names[lower], point_a=ends[0], point_b=ends[1],
        stiffness=2.0 * force / length, damping=0.0, rest_length=0.5 * length,
    )  # fmt: skip
    return _afloat(0.0, tie)


def _middle(scene: Scene, choose: Callable) -> int:
    """Return the index of the link in the middle of the upper (max) or the lower (min) run."""
    links = [k for k, body in enumerate(scene.bodies) if body.name.startswith("link")]
    x = np.array([scene.bodies[k].position for k in links])
    run = [k for k, place in zip(links, x, strict=True) if abs(place[1] - choose(x[:, 1])) < 1e-6]
    centre = x[:, 0].mean()
    return min(run, key=lambda k: abs(scene.bodies[k].position[0] - centre))


def momentum(scene: Scene, path: Trajectory) -> Measured:
    """Return the largest momentum over sum m |v|, and angular momentum over its own sum of sizes."""
    mass = np.array([body.mass for body in scene.bodies])
    speed, arm = np.linalg.norm(path.velocity, axis=2), np.linalg.norm(path.position, axis=2)
    linear, angular = np.linalg.norm(linear_momentum(scene, path), axis=1), np.abs(angular_momentum(scene, path))
    turning = (speed * arm) @ mass + np.abs(spins(scene, path)).sum(axis=1)
    return Measured(max(_share(linear, speed @ mass), _share(angular, turning)))


def _share(part: np.ndarray, whole: np.ndarray) -> float:
    return float(np.max(part)) / max(float(np.max(whole)), 1e-300)


def _slope(degrees: float) -> Case:
    """The vehicle at rest, let go without drive."""
    angle = math.radians(degrees)
    scene = scenes.make("tracked_vehicle", model="paper", torque=0.0)
    pull = (GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle))
    scene = scene.model_copy(update={"name": "track_on_slope", "parameters": {}, "gravity": pull})
    return Case(scene, grid(END, STEP, 6), worst(_downhill, OPEN), step=STEP, rtol=RTOL)


def _downhill(scene: Scene, path: Trajectory) -> Measured:
    """Judge by what no passive mechanism does: gain energy, or fall faster than freely; over the fall's own size."""
    mass = np.array([body.mass for body in scene.bodies])
    pull, total = np.array(scene.gravity), mass.sum()
    strength = float(np.linalg.norm(pull))
    way = np.einsum("b,tbi->ti", mass, path.position - path.position[:1]) / total
    gained = kinetic_energy(scene, path) - total * (way @ pull)  # no spring is strained at the start
    free = 0.5 * strength * path.times**2
    ahead = way @ pull / strength - free
    longest = float(free[-1])
    return Measured(max(float(np.max(gained)) / (total * strength * longest), float(np.max(ahead)) / longest))


CASES = {"track-speed": _afloat, "track-tension": _tight, "track-slope": _slope}
