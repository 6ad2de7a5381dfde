"""What is measured of the sky."""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from cross_checks.records.record import Record
from reports.studies.study import Study


@dataclass(frozen=True)
class Lap:
    """One scene of a race."""

    scene: str
    ratio: float  # the rival's loop time over ours
    apart: float | None  # m, the largest distance between the two at the end; None where one did not get there


@dataclass(frozen=True)
class Race:
    """Paired ratios over several scenes."""

    rival: str
    ours: str
    laps: tuple[Lap, ...]
    low: float  # 95 % bootstrap interval of the median ratio
    high: float

    @property
    def ratio(self) -> float:
        """The median of the laps."""
        return statistics.median(lap.ratio for lap in self.laps)


@dataclass(frozen=True)
class Splitting:
    """WHFast at one day with the Moon as a body of its own."""

    energy: float | None  # relative error, largest of the year; None without rebound
    moon_figures: float | None


@dataclass(frozen=True)
class SkyFacts:
    """Everything measured."""

    ladder: tuple[Record, ...]  # the solar system over 360 days at each level of physics
    formulations: tuple[Record, ...]  # point masses and rigid bodies over 200 and 360 days
    spread: dict[str, dict[str, float]]  # ephemeris -> body -> figures that it shares with DE440, after 360 days
    races: tuple[Race, ...]
    splitting: Splitting
    year: dict[str, tuple[tuple[float, float, float], ...]]  # body -> places over a year (n_t), m, equatorial axes


STUDY = Study("sky.html", "The sky", SkyFacts, alone=True)
