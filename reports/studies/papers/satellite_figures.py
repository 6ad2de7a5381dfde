"""A rigid satellite under the gravity gradient: against the linear theory and against its truth."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.metrics.metric import off_truth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

SMALL, LARGE = 0.05, 50.0  # degrees of pitch
SETTINGS = Settings(rtol=1e-12, samples=201, estimate="off")


def satellites() -> dict[str, float | str]:
    """Return the ratio of the libration's frequency to sqrt(3 k) n, and how far (rad) a large one is off its truth."""
    scene = scenes.make("librating_satellite", pitch=SMALL)
    run = simulate(scene, SETTINGS)
    body = scene.parameters
    share = 3.0 * (float(body["roll_inertia"]) - float(body["yaw_inertia"])) / float(body["pitch_inertia"])
    turns = 2.0 * math.pi * float(body["orbits"]) * math.sqrt(share)  # of the libration's phase, by the linear theory
    angle = 2.0 * np.unwrap(np.arctan2(run.orientation[:, 1, 3], run.orientation[:, 1, 0]), period=np.pi)
    place = run.position[:, 1]
    pitch = np.mod(angle - np.unwrap(np.arctan2(place[:, 1], place[:, 0])) + np.pi, 2.0 * np.pi) - np.pi
    crossings = np.flatnonzero(np.diff(np.sign(pitch)))
    k = crossings[-1]
    at = run.times[k] - pitch[k] * (run.times[k + 1] - run.times[k]) / (pitch[k + 1] - pitch[k])
    ratio = (len(crossings) - 0.5) * math.pi / (turns * at / run.times[-1])
    large = scenes.make("librating_satellite", pitch=LARGE)
    path = simulate(large, SETTINGS)
    _, off, *_ = off_truth(large, path) or (0.0, "no truth")
    norm = float(np.abs(np.sum(path.orientation**2, axis=2) - 1.0).max())
    return {"satellite.frequency": ratio, "satellite.off": off, "satellite.norm": norm}
