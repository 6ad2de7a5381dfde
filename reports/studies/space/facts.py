"""What is measured of Euler parameters."""

from __future__ import annotations

from dataclasses import dataclass

from reports.studies.study import Study


@dataclass(frozen=True)
class NormDrift:
    """A steady spin by RK4 without projection, against N (w h / 2)^6 / 144, and the same run normalised."""

    half_angle: float  # rad, w h / 2 of a step
    steps: int
    measured: float  # 1 - |theta|
    formula: float
    error_free: float  # rad, orientation error without ...
    error_normalised: float  # rad, ... and with projection of the norm


@dataclass(frozen=True)
class LongSteps:
    """A spin that makes 10 rad a step."""

    radians_a_step: float
    energy_error: float  # relative, largest
    orientation_error: float  # rad, largest


@dataclass(frozen=True)
class SpaceFacts:
    """Everything measured."""

    drift: tuple[NormDrift, ...]
    long_steps: LongSteps
    cost_ratio: float  # loop time of rigid bodies over point masses on the same free fall, paired in one run
    states: tuple[int, int]  # numbers in the state of one: rigid, point mass


STUDY = Study("space.html", "Euler parameters", SpaceFacts, alone=True)
