"""What an extreme is: a scene driven along an axis, and how far an answer is from right, over the motion's own size."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.metrics.drifts import compliance
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings, Trajectory, observables
from mbs_ref.observables.distance import Partial, farthest, largest, point_distances

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
