"""The papers' claims, measured: the crash, the track, the planets, forms of the equations, relative coordinates.

Two forms that the papers name have small solvers of their own, of plain arrays, on a pendulum and a top: mu' = lambda
("index 0"), and Euler's angles. What is shown belongs to the forms, not to this project's solver.
"""

import math
from time import process_time
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import Sample, compare
from mbs_ref import Scene, Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import jit
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.euler_parameters import product
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Value
from reports.studies.crash import RAN
from reports.studies.papers.crash_figures import measure_crash, outline_pictures
from reports.studies.papers.lessons import measure_lessons
from reports.studies.papers.track_figures import measure_track
from reports.studies.sky import observed

GRAVITY, LENGTH = 9.81, 1.0  # m/s^2, m; a unit mass
STEPS = (1e-2, 1e-3, 1e-4)  # s, of RK4, and of the difference that turns mu into lambda
GIMBAL = 1e-5  # |sin of the middle angle| below which Euler's angles have no rates
SINGULAR = "singular"


def multipliers() -> dict[str, float | str]:
    """Return the error of lambda: solved for at index 1, and as the derivative of a computed mu (Fox 1999 eqs 16-17).

    RK4 in double and in single precision: a difference of mu is of order two where the solution is of order four, and
    divides mu's roundoff by the step, so that single precision soon grows worse as steps get shorter.
    """
    figures: dict[str, float | str] = {}
    for h in STEPS:
        times = h * np.arange(round(1.0 / h) + 1)
        exact = _exact_multiplier(times)
        for precision in ("float64", "float32"):
            path = _rk4(h, len(times), np.dtype(precision))
            solved = np.array([_multiplier(y) for y in path])
            differences = (path[2:, 4] - path[:-2, 4]) / path.dtype.type(2.0 * h)
            figures[f"multiplier.index1.{precision}.{h:g}"] = _worst(solved, exact)
            figures[f"multiplier.mu.{precision}.{h:g}"] = _worst(differences, exact[1:-1])
    return figures


def _worst(result: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(result - exact).max() / np.abs(exact).max())


def _rk4(h: float, count: int, precision: np.dtype) -> np.ndarray:
    """Return x, y, their rates and mu (count, 5)."""
    step = precision.type(h)
    half, sixth = precision.type(0.5), precision.type(1.0 / 6.0)
    path = np.zeros((count, 5), dtype=precision)
    path[0, 0] = LENGTH
    for n in range(count - 1):
        k1 = _pendulum(path[n])
        k2 = _pendulum(path[n] + half * step * k1)
        k3 = _pendulum(path[n] + half * step * k2)
        k4 = _pendulum(path[n] + step * k3)
        path[n + 1] = path[n] + sixth * step * (k1 + k2 + k2 + k3 + k3 + k4)
    return path


def _multiplier(y: np.ndarray):
    """lambda of C = (x^2 + y^2 - L^2) / 2 from the augmented system."""
    return (y[2] ** 2 + y[3] ** 2 - y.dtype.type(GRAVITY) * y[1]) / (y[0] ** 2 + y[1] ** 2)


def _pendulum(y: np.ndarray) -> np.ndarray:
    """Slopes of x, y, their rates, and mu with mu' = lambda."""
    pull = _multiplier(y)
    return np.array([y[2], y[3], -pull * y[0], -y.dtype.type(GRAVITY) - pull * y[1], pull], dtype=y.dtype)


def _exact_multiplier(times: np.ndarray) -> np.ndarray:
    """By the angle phi from the horizontal, at rest at phi = 0: L w^2 = 2 g sin(phi), lambda = 3 g sin(phi) / L."""
    swing = solve_ivp(
        lambda _, s: [s[1], GRAVITY / LENGTH * np.cos(s[0])], (0.0, float(times[-1])), [0.0, 0.0], t_eval=times,
        rtol=1e-13, atol=1e-14, method="DOP853",
    )  # fmt: skip
    return 3.0 * GRAVITY / LENGTH * np.sin(swing.y[0])


def euler_angles(tilt: float) -> dict[str, float | str]:
    """Turn a free body whose axis passes the pole within `tilt` (rad), in z-x-z angles and in Euler parameters."""
    spin = np.array([1.0, 0.0, 0.0])  # rad/s, world; the body's third axis starts at -1 rad from the pole

    def rates(_: float, angles: np.ndarray) -> np.ndarray:
        return _rate_matrix(angles[0], angles[1]) @ spin

    def pole(_: float, angles: np.ndarray) -> float:
        return abs(np.sin(angles[1])) - GIMBAL

    pole.terminal = True  # type: ignore[attr-defined]
    axis = np.array([np.sin(tilt), np.sin(1.0) * np.cos(tilt), np.cos(1.0) * np.cos(tilt)])
    start = [np.arctan2(axis[0], -axis[1]), np.arccos(axis[2]), 0.0]
    path = solve_ivp(rates, (0.0, 2.0), start, rtol=1e-8, atol=1e-10, events=pole)
    stopped = len(path.t_events[0]) > 0 or not path.success
    turned = solve_ivp(
        lambda _, p: 0.5 * product(np.append(0.0, spin), p), (0.0, 2.0), [1.0, 0.0, 0.0, 0.0], rtol=1e-8, atol=1e-10
    )
    return {
        "status": SINGULAR if stopped else "success", "until": float(path.t[-1]), "calls": float(path.nfev),
        "parameters_calls": float(turned.nfev), "parameters_norm": float(abs(np.linalg.norm(turned.y[:, -1]) - 1.0)),
    }  # fmt: skip


def _rate_matrix(precession: float, nutation: float) -> np.ndarray:
    """Return the matrix (3, 3) from the world's angular velocity to the angles' rates; infinite at nutation = 0."""
    c, s, sn, cn = np.cos(precession), np.sin(precession), np.sin(nutation), np.cos(nutation)
    return np.array([[-s * cn / sn, c * cn / sn, 1.0], [c, s, 0.0], [s / sn, -c / sn, 0.0]])


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
