"""What is measured of the papers' own claims."""

from __future__ import annotations

from dataclasses import dataclass

from reports.facts.curves import Curves, Film
from reports.studies.study import Study


@dataclass(frozen=True)
class PapersFacts:
    """Numbers and words by name, and the papers' pictures drawn from our runs."""

    figures: dict[str, float | str]  # name -> SI number, or a status's sentence
    films: dict[str, Film]  # figures of pictures
    curves: dict[str, Curves]  # figures of forces over time


STUDY = Study("papers.html", "The papers and we", PapersFacts)
