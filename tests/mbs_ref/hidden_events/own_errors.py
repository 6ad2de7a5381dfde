"""The errors of a fixed step itself: what decides on less of the extent, a run with that step cannot know."""

from __future__ import annotations

from dataclasses import replace
from math import factorial

import numpy as np
from scipy.spatial.transform import Rotation

from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from tests.mbs_ref.hidden_events.exact import history, take_off
from tests.mbs_ref.hidden_events.world import THIRD, Body, Contact, Length, Level, World
from tests.mbs_ref.hidden_events.write_scene import Units, write_scene


def flight_error(world: World, units: Units, settings: Settings) -> float:
    """Return how far a run leaves marks and centres of mass off the exact motion where nothing is watched."""
    bodies = tuple(replace(body, kind="free") if body.kind == "point" else body for body in world.bodies)  # one core
    run = simulate(write_scene("unwatched", replace(world, bodies=bodies, watches=()), units), settings)
    flights, times = take_off(world), run.times / units.time
    marks = [m for watch in world.watches if not isinstance(watch, Level) for m in (watch.a, watch.b)]
    worst = 0.0
    for k, body in enumerate(world.bodies):
        if body.kind == "driven":  # prescribed
            continue
        for arm in (body.offset, *(mark.arm for mark in marks if mark.body == body.name)):
            off = _points(run, k, body, arm, units.length) - flights[body.name].point(arm, times)
            worst = max(worst, float(np.max(np.linalg.norm(off, axis=1))))
    return worst / world.extent


def _points(run: Trajectory, k: int, body: Body, arm: np.ndarray, length: float) -> np.ndarray:
    """Return where a point of body k is, by its arm from the body's place (n_t, 3)."""
    place = run.position[:, k] / length
    place = np.pad(place, ((0, 0), (0, 3 - place.shape[1])))
    lever = arm - body.offset
    if not np.any(lever):
        return place
    if run.orientation.ndim == 2:
        return place + Rotation.from_rotvec(run.orientation[:, k, None] * THIRD).apply(lever)
    return place + Rotation.from_quat(run.orientation[:, k], scalar_first=True).apply(lever)


def spring_error(world: World, order: int, angle: float) -> float:
    """Return what a method leaves out of the series of exp(i pi angle) in all steps of all stiff contacts."""
    held = [s.impact for s in history(world) if isinstance(s.impact, Contact | Length) and s.impact.hold > 0.0]
    return len(held) / angle * (np.pi * angle) ** (order + 1) / factorial(order + 1)
