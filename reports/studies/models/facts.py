"""What is measured of the ladders of models, from least to most."""

from __future__ import annotations

import math
from dataclasses import dataclass

from reports.studies.study import Study


@dataclass(frozen=True)
class Rung:
    """One model of a scene."""

    name: str
    loop_s: float  # least of interleaved runs
    work: int  # right-hand sides
    shown: dict[str, float]  # what the model changes: words with a unit -> value
    accuracy: float | None = None  # what a reader asks for: significant figures, or -log10 of a relative error


@dataclass(frozen=True)
class Ladder:
    """The models of one family, from least to most."""

    title: str
    note: str
    method: str  # and its setting, the same on every rung
    measure: str  # what `accuracy` counts
    rungs: tuple[Rung, ...]
    reference: str = ""  # the rung that the others are held against, where no truth is known

    def least(self, accuracy: float) -> Rung | None:
        """Return the cheapest model that is at least so accurate, the reference included; None where none is."""
        exact = {self.reference: math.inf} if self.reference else {}
        reached = [exact.get(rung.name, rung.accuracy) for rung in self.rungs]
        enough = [rung for rung, has in zip(self.rungs, reached, strict=True) if has is not None and has >= accuracy]
        return min(enough, key=lambda rung: rung.loop_s, default=None)


@dataclass(frozen=True)
class ModelsFacts:
    """Everything measured."""

    ladders: tuple[Ladder, ...]


STUDY = Study("models.html", "What a model costs", ModelsFacts, alone=True)
