"""What is measured of a crash."""

from __future__ import annotations

from dataclasses import dataclass

from reports.facts.curves import Curves, Film
from reports.studies.study import Study


@dataclass(frozen=True)
class Whiplash:
    """The cervical torques, and when each changes sign."""

    torques: Curves  # N m
    largest: dict[str, float]  # vertebra -> N m
    least: dict[str, float]
    changes: dict[str, tuple[float, ...]]  # s


@dataclass(frozen=True)
class Crash:
    """One android in one impact, with the forces and measures of the paper."""

    android: str
    impact: str
    description: str
    bodies: int
    rhs_calls: int
    loop_s: float
    compliance: float  # m, largest |C| of the steps
    imbalance: float  # of the pulse's work: energy less all works
    peak_seat_force: float  # N
    peak_belt_force: float  # N
    head_excursion: float  # m along x, furthest, with its sign
    hip_excursion: float  # m
    measures: dict[str, float]
    film: Film
    forces: dict[str, Curves]  # the paper's Figs. 3 to 5: generalized forces per body
    plots: dict[str, Curves]
    compared: dict[str, Curves]  # one line each, drawn with that of the other android
    whiplash: Whiplash | None  # None without cervical vertebrae

    @property
    def label(self) -> str:
        return f"{self.android}, {self.impact}"


@dataclass(frozen=True)
class CrashFacts:
    """Both androids in both impacts."""

    crashes: tuple[Crash, ...]


STUDY = Study("androids.html", "The crash androids", CrashFacts)
