"""What an extreme is: a scene driven along an axis, and how its answer is measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cross_checks.engine import Method
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

GOOD = 1e-3  # of the motion's size: as good as the eye can tell
WRONG = 0.1  # of the motion's size: another motion
MAX_STEPS = 1_000_000  # what a run of a second of wall time may need; more is work without end
UNCHECKED = 1e9  # m, m/s: an inconsistency that the suite's own check lets pass, so that the engine's answer shows

Measure = Callable[[Scene, Trajectory], float]  # error in units of the motion's size: 1 is all of it


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
    step: float | None = None  # s; None where fixed-step methods have no say
    rtol: float | None = None  # None where adaptive methods have no say
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
    good: float = GOOD  # error that still counts as survived
    wrong: float = WRONG  # error beyond which a success is a lie

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


def grid(t_end: float, step: float | None = None, samples: int = 21) -> np.ndarray:
    """Return output times from 0 to t_end (s), even, or as even as multiples of the step allow."""
    if step is None:
        return np.linspace(0.0, t_end, samples)
    whole = max(1, round(t_end / step))
    return np.unique(np.linspace(0, whole, min(samples, whole + 1)).round()) * step


def decades(first: float, last: float, each: float = 1.0) -> tuple[float, ...]:
    """Return powers of ten from first to last, `each` decades apart."""
    a, b = math.log10(first), math.log10(last)
    count = round(abs(b - a) / each)
    return tuple(float(f"{10.0 ** (a + (b - a) * k / count):.6g}") for k in range(count + 1))
