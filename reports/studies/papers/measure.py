"""The papers' claims, measured: the crash, the track, the planets, and two forms of the equations."""

import math
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from mbs_ref import Settings, scenes
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Value
from reports.studies.papers.coordinates import coordinates
from reports.studies.papers.crash_figures import measure_crash, outline_pictures
from reports.studies.papers.formulations import euler_angles, multipliers
from reports.studies.papers.lessons import measure_lessons
from reports.studies.papers.track_figures import measure_track
from reports.studies.sky.measure import observed

TILTS = (0.1, 1e-3, 1e-8)  # rad, by which an axis misses the pole
INDICES = ("dassl_index1", "dassl_index2", "dassl", "dassl_index3")


def measure() -> Measured:
    """Run everything; two minutes with compiled code at hand."""
    parts = measure_crash(), measure_track(), *measure_lessons()
    figures, drawn, films = (
        {name: value for part in parts for name, value in getattr(part, kind).items()}
        for kind in ("figures", "curves", "films")
    )
    figures |= measure_sky() | multipliers() | coordinates() | satellites() | _indices()
    for tilt in TILTS:
        figures |= {f"angles.{tilt:g}.{name}": value for name, value in euler_angles(tilt).items()}
    return Measured(figures, outline_pictures(), drawn, films)


def _indices() -> dict[str, Value]:
    """Return |C| of a slider-crank by DASSL at index 1, 2, stabilised 2 and 3, without help."""
    figures: dict[str, Value] = {}
    for method in INDICES:
        path = simulate(scenes.make("slider_crank"), Settings(method=method, rtol=1e-4, stabilization="none"))
        stored = path.step_compliance
        figures[f"{method}.compliance"] = float(stored[:, 1].max()) if path.ok and stored is not None else path.message
    return figures


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


DAYS = (200.0, 360.0)
DAY = 86_400.0  # s
METHODS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("euler", {"step": 0.1 * DAY}), ("rk4", {"step": DAY}), ("lsodar", {"rtol": 1e-9}), ("dop853", {"rtol": 1e-12}),
)  # fmt: skip
RIGID: dict[str, Any] = {"formulation": "euler_parameters", "spin": True}


def measure_sky() -> dict[str, float | str]:
    """Return the figures of all bodies' least exact one, and |theta^T theta - 1|."""
    figures: dict[str, float | str] = {}
    for days in DAYS:
        for method, more in METHODS:
            settings = Settings(method=method, samples=2, estimate="off", max_steps=10**6, **more)
            figures[f"sky.{method}.{days:g}"] = _figures("lumped", days, settings)
        for model in ("lumped", "full"):
            figures[f"sky.{model}.{days:g}"] = _figures(model, days, Settings(method="gauss", rtol=1e-16, samples=2))
    for stabilization in ("none", "projection"):
        scene = scenes.make("solar_system", model="newton", days=DAYS[1], **RIGID)
        path = simulate(scene, Settings(method="dop853", rtol=1e-12, samples=2, stabilization=stabilization))
        norm = np.linalg.norm(path.orientation[-1], axis=1)
        figures[f"sky.norm.{stabilization}"] = float(np.abs(norm**2 - 1.0).max())
    return figures


def _figures(model: str, days: float, settings: Settings) -> float | str:
    record = observed(scenes.make("solar_system", model=model, days=days), "mbs_ref", settings)
    return min(record.figures.values()) if record.status == "success" else record.message
