"""The papers' claims, measured: the crash, the track, the planets, forms of the equations, relative coordinates."""

import math
from time import process_time
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import Sample, compare
from mbs_ref import Scene, Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import jit
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Value
from reports.studies.crash import RAN
from reports.studies.papers.crash_figures import measure_crash, outline_pictures
from reports.studies.papers.formulations import euler_angles, multipliers
from reports.studies.papers.lessons import measure_lessons
from reports.studies.papers.track_figures import measure_track
from reports.studies.sky import observed

FINE = 1e-11  # rtol
CALLS = 2000  # of bodies' right-hand sides in one sample: about a millisecond
TILTS = (0.1, 1e-3, 1e-8)  # rad, by which an axis misses the pole
INDICES = ("dassl_index1", "dassl_index2", "dassl", "dassl_index3")


@jit
def _repeat(model, work, y, dy, count):
    for _ in range(count):
        derivative(model, work, 0.0, y, dy)


def coordinates() -> dict[str, float | str]:
    """Return how far apart the motions are (m), the time relative to Cartesian, and the numbers of coordinates."""
    figures: dict[str, float | str] = {}
    for name, tree in RAN["trees"].items():
        scene = scenes.make(tree["scene"], **tree["parameters"])
        cartesian, relative = (_loop(scene, coordinates) for coordinates in ("cartesian", "relative"))
        settings = Settings(rtol=FINE, t_end=tree["t_end"], samples=21, estimate="off", reactions=False)
        runs = [
            simulate(scene, settings.model_copy(update={"coordinates": kind})) for kind in ("cartesian", "relative")
        ]
        failed = next((run.message for run in runs if not run.ok), None)
        figures[f"coordinates.{name}.apart"] = failed or farthest(scene, *runs)[0]
        figures[f"coordinates.{name}.time"] = compare(cartesian, relative).ratio
        for coordinates in ("cartesian", "relative"):
            figures[f"coordinates.{name}.{coordinates}"] = compile_scene(scene, coordinates).n_positions
    return figures


def _loop(scene: Scene, coordinates: Coordinates):
    """Return what times CALLS right-hand sides of a body, in processor time."""
    system = compile_scene(scene, coordinates)
    system.set_mode_time(0.0)
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    dy, count = np.empty_like(y), max(1, CALLS // len(scene.bodies))
    _repeat(system.model, system.work, y, dy, 1)

    def timed() -> Sample:
        began = process_time()
        _repeat(system.model, system.work, y, dy, count)
        return Sample(process_time() - began)

    return timed


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
RIGID: dict[str, Any] = {"formulation": "euler_parameters", "spin": True}


def measure_sky() -> dict[str, float | str]:
    """Return the figures of all bodies' least exact one, and |theta^T theta - 1|."""
    figures: dict[str, float | str] = {}
    for days in DAYS:
        for method, more in RAN["methods"]["sky"].items():
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
