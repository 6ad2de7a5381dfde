"""What is measured of the pairs that the project names: a solver of its own and a peer on the same scenes."""

from __future__ import annotations

from dataclasses import dataclass

from reports.facts.cheapest import Entry
from reports.studies.study import Study


@dataclass(frozen=True)
class Row:
    """One engine at one target error, by its cheapest method, or the reason why it does not reach it."""

    scene: str
    target: float | None  # over the scene's scales; None where the scene is refused
    entry: Entry  # its loop time is the least of interleaved runs
    constrained: bool = False  # whether the scene has joints
    ratio: float | None = None  # loop time over that of our cheapest at the same target


@dataclass(frozen=True)
class Pair:
    """The scenes of one pair."""

    title: str
    note: str
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Places:
    """Places in the sky by two sources."""

    what: str
    days: float  # since 1998-01-01, or J2000 for the satellites' Sun and Moon
    apart: dict[str, float]  # body -> m or rad, as `unit`
    unit: str
    figures: dict[str, float]  # body -> significant figures that they share


@dataclass(frozen=True)
class PairsFacts:
    """Everything measured."""

    pairs: tuple[Pair, ...]
    astropy: tuple[Places, ...]  # of the default installation's built-in ephemeris; empty without astropy


STUDY = Study("pairs.html", "Every pair at equal error", PairsFacts, alone=True)
