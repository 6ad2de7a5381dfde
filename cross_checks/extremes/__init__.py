"""Extreme scenes along an axis from mild to hopeless, as `extremes.toml` describes them.

An entry with a `case` describes the places of its axis, too: a scene of the library with `parameters`, its end `t_end`
(s), and its `measure`: "invariants", or a solver in cross_checks.truths with the motion's `size` (m; how far its own
bodies go unless given). `step`, `rtol` and `max_steps` are those of a Case, `samples` and `every` (s) of its times. A
text that begins with "=" is a formula of `value`, the place on the axis; "none" leaves out what there is by default.
Other entries belong to the file of `families` under which they stand, whose CASES have them.

An extreme is a scene driven along an axis, and how far its answer is from right, over the motion's own size.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.metrics.drifts import compliance
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings, Trajectory, observables, scenes
from mbs_ref.files import package_data
from mbs_ref.observables.distance import Partial, farthest, largest, point_distances
from mbs_ref.scene.base.expression import evaluate
from mbs_ref.scene.parameters import FORMULA

STEP, RTOL = 1e-3, 1e-8  # s and relative: the settings of a run, unless an axis changes them
MAX_STEPS = 1_000_000  # of a run: several times what a second of wall time allows
UNCHECKED = 1e9  # m, m/s: an inconsistency that the suite's own check lets pass, so that the engine's answer shows


class Measured(NamedTuple):
    """The error of a run in units of the motion's size, 1 being all of it, and the truth's uncertainty."""

    error: float
    uncertainty: float = 0.0


Measure = Callable[[Scene, Trajectory], Measured]


@dataclass(frozen=True)
class Axis:
    """What is driven to the extreme, mild first."""

    name: str
    unit: str
    values: tuple[float, ...]
    labels: tuple[str, ...] = ()  # where the values merely number kinds
    full: tuple[float, ...] = ()  # further values that take too long for a quick look

    def label(self, value: float) -> str:
        """Return the value as a reader would write it."""
        return self.labels[int(value)] if self.labels else f"{value:.6g}"


@dataclass(frozen=True)
class Case:
    """One place on the axis, ready to run."""

    scene: Scene
    times: np.ndarray  # (n_t,) s, output times: multiples of the step
    measure: Measure
    step: float | None = STEP  # s; None where the axis does not concern fixed-step methods
    rtol: float | None = RTOL  # None where the axis does not concern adaptive methods
    must_stop: bool = False  # there is no right answer but a refusal
    may_stop: bool = False  # a refusal is as right as an answer
    unchecked: bool = False  # let an inconsistent start pass to engines that do not look by themselves
    max_steps: int = MAX_STEPS


@dataclass(frozen=True)
class Extreme:
    """A scene along an axis."""

    name: str
    family: str
    title: str  # one sentence: what happens, and why it is hard
    axis: Axis
    case: Callable[[float], Case]
    engine: Callable[[str], Engine] = engines.get  # by name; raises EngineMissing

    def values(self, full: bool = False) -> tuple[float, ...]:
        """Return the axis, mild first."""
        return self.axis.values + (self.axis.full if full else ())

    def takes(self, method: Method) -> bool:
        """Return whether the axis is about methods of this kind."""
        case = self.case(self.axis.values[0])
        return (case.step if method.kind == "fixed" else case.rtol) is not None


def settings_for(case: Case, method: Method) -> Settings:
    """Return the case's step or tolerances for a method."""
    common = {"method": method.name, "reactions": False, "max_steps": case.max_steps}
    if method.kind == "fixed":
        return Settings(step=case.step, **common)
    return Settings(rtol=case.rtol, atol=case.rtol, **common)


def grid(t_end: float, step: float = STEP, samples: int = 21) -> np.ndarray:
    """Return output times from 0 to t_end (s), as even as multiples of the step allow."""
    whole = max(1, round(t_end / step))
    return np.unique(np.linspace(0, whole, min(samples, whole + 1)).round()) * step


Positions = Callable[[np.ndarray], np.ndarray]  # times (n_t,) s -> centres of mass (n_t, n_bodies, dimension) m


def in_plane(*xy: np.ndarray | float) -> np.ndarray:
    """Return vectors (n_t, n, 2) of n bodies from x and y of each in turn."""
    columns = np.stack(np.broadcast_arrays(*xy), axis=-1)
    return columns.reshape(*columns.shape[:-1], -1, 2)


def by_positions(exact: Positions, size: float = 1.0) -> Measure:
    """Judge centres of mass by their exact places; `size` of the motion in m."""

    def measure(scene: Scene, path: Trajectory) -> Measured:
        # sizes whose squares overflow are scaled first
        return Measured(farthest(scene, Partial(path.position / size), Partial(exact(path.times) / size))[0])

    return measure


def by_truth(solve: Callable[[Scene, np.ndarray], Truth | NoTruth], size: float | None = 1.0) -> Measure:
    """Judge world points by a truth's solver; `size` in m, or None for how far the truth's own bodies go."""

    def measure(scene: Scene, path: Trajectory) -> Measured:
        truth = solve(scene, path.times)
        if not isinstance(truth, Truth):
            raise LookupError(f"{scene.name} has no truth here: {truth}")
        start = Partial(np.broadcast_to(truth.position[:1], truth.position.shape))
        unit = size or farthest(scene, truth, start)[0]
        return Measured(float(largest(point_distances(scene, path, truth)[..., 0])) / unit, truth.uncertainty / unit)

    return measure


def by_rates(exact: Positions, size: float) -> Measure:
    """Judge velocities; `size` in m/s."""
    return lambda scene, path: Measured(farthest(scene, path, Partial(velocity=exact(path.times)))[2] / size)


def open_joints(size: float = 1.0) -> Measure:
    """Judge by how far joints and rods open, of `size` (m)."""
    return lambda scene, path: Measured(float(np.max(compliance(scene, path)[0], initial=0.0)) / size)


def energy(scene: Scene, path: Trajectory) -> Measured:
    """Judge the energy's drift over the largest kinetic energy."""
    balance = observables.energy_balance(scene, path)
    if not np.isfinite(balance.energy).all():
        return Measured(np.inf)
    if balance.drift is None:
        raise LookupError(f"{scene.name} has no energy balance: {balance.reason}")
    swing = float(np.max(observables.kinetic_energy(scene, path)))
    return Measured(float(np.max(np.abs(balance.drift))) / swing if swing > 0.0 else np.inf)


def worst(*measures: Measure) -> Measure:
    """Judge by the worst of several."""
    return lambda scene, path: max(one(scene, path) for one in measures)


invariants = worst(energy, open_joints())  # which every right motion keeps


def unjudged(scene: Scene, path: Trajectory) -> Measured:
    """Return that no answer can be right: for cases that must stop."""
    return Measured(float("inf"))


DATA = package_data(__name__, "extremes.toml")
LISTED, QUICK = DATA["extremes"], DATA["quick"]
MAP = Path(str(files(__name__))) / "data" / "map.jsonl"  # the cells of the last dated runs


@cache
def every() -> tuple[Extreme, ...]:
    """Return all extremes in the order of the file."""
    modules = {family: import_module(f"{__name__}.families.{family}") for family in LISTED}
    return tuple(_described(modules[family], entry) for family, entries in LISTED.items() for entry in entries)


def _described(module: ModuleType, entry: dict[str, Any]) -> Extreme:
    """Return an extreme; an axis of labels has their numbers for values."""
    labels, full, name = tuple(entry.get("labels", ())), tuple(entry.get("full", ())), entry["name"]
    values = tuple(entry.get("values", map(float, range(len(labels)))))
    axis = Axis(entry["axis"], entry.get("unit", ""), values, labels, full)
    case = partial(_case, entry["case"]) if "case" in entry else module.CASES[name]
    engine = getattr(module, "ENGINES", {}).get(name, engines.get)
    return Extreme(name, entry["family"], entry["title"], axis, case, engine)


def _case(described: dict[str, Any], value: float) -> Case:
    """Return the case of an entry at a place on its axis."""
    given: dict[str, Any] = {"step": STEP, "samples": 21} | _filled(described, value)
    scene, step = scenes.make(given["scene"], **given.get("parameters", {})), given["step"]
    times = grid(given["t_end"], given.get("every", step or STEP), given["samples"])
    solver, measure = given["measure"], invariants
    if solver != "invariants":
        parameters = tuple(scene.parameters.items())
        measure = by_truth(lambda _, at: _solved(solver, scene.name, parameters, (*at,)), given.get("size"))
    more = {name: given[name] for name in ("rtol", "max_steps") if name in given}
    return Case(scene, times, measure, step, **more)


def _filled(described: Any, value: float) -> Any:
    """Return an entry with numbers in place of formulas, and None in place of "none"."""
    if isinstance(described, dict):
        return {name: _filled(part, value) for name, part in described.items()}
    if isinstance(described, str) and described.startswith(FORMULA):
        return evaluate(described.removeprefix(FORMULA), {"value": value})
    return None if described == "none" else described


@lru_cache(maxsize=4)
def _solved(solver: str, name: str, parameters: tuple, times: tuple[float, ...]) -> Truth | NoTruth:
    """Solve a scene of the library once where an axis asks the same at every place."""
    module, _, function = solver.rpartition(".")
    solve = getattr(import_module(f"cross_checks.truths.{module}"), function)
    return solve(scenes.make(name, **dict(parameters)), np.array(times))


def named(name: str) -> Extreme:
    """Return the extreme of that name; ValueError lists what there is."""
    for extreme in every():
        if extreme.name == name:
            return extreme
    raise ValueError(f"extreme = {name!r} is unknown; allowed: {', '.join(e.name for e in every())}")
