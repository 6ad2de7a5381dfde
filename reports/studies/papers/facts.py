"""What is measured of the papers' own claims."""

from __future__ import annotations

from dataclasses import dataclass

from reports.facts.curves import Curves, Film
from reports.studies.study import Study


@dataclass(frozen=True)
class Outline:
    """A part or a surface at one moment: a line with round ends."""

    kind: str  # body | arm | seat
    start: tuple[float, float]  # m
    end: tuple[float, float]  # m
    radius: float  # m


@dataclass(frozen=True)
class Moment:
    """All that is drawn of a crash at one time."""

    time: float  # s
    shapes: tuple[Outline, ...]


@dataclass(frozen=True)
class PapersFacts:
    """Numbers and words by name, and the papers' pictures drawn from our runs."""

    figures: dict[str, float | str]  # name -> SI number, or a status's sentence
    films: dict[str, Film]  # figures of pictures
    curves: dict[str, Curves]  # figures of forces over time
    outlines: dict[str, tuple[Moment, ...]]  # crashes as bodies with their outlines


STUDY = Study("papers.html", "The papers and we", PapersFacts)
