"""What an extreme is: a scene driven along an axis, and how its answer is measured."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, Method
from mbs_ref import Scene, Settings, Trajectory

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
