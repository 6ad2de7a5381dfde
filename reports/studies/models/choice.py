"""The least model of a scene's family that reaches an error, from the ladders of this study."""

from __future__ import annotations

import math
from dataclasses import dataclass

from reports.drawing.numbers import duration
from reports.studies.models.facts import Ladder, Rung


@dataclass(frozen=True)
class ModelChoice:
    """What is enough, and why nothing less is."""

    error: float  # largest, relative, as asked
    ladder: Ladder
    best: Rung | None
    lesser: Rung | None  # the most accurate of the cheaper models, none of which is enough
    sentence: str


def choose(ladder: Ladder, error: float) -> ModelChoice:
    """Return the cheapest model of a ladder whose relative error is at most `error`."""
    asked = -math.log10(error)
    best = ladder.least(asked)
    if best is None:
        known = [rung for rung in ladder.rungs if rung.accuracy is not None]
        nearest = max(known, key=lambda rung: rung.accuracy or 0.0, default=None)
        least = "" if nearest is None else f"; {nearest.name!r} comes closest with {_error(nearest)}"
        return ModelChoice(error, ladder, None, nearest, f"{ladder.title}: no model reaches {error:.3g}{least}.")
    cheaper = [rung for rung in ladder.rungs if rung.loop_s < best.loop_s]
    lesser = max(cheaper, key=lambda rung: rung.accuracy or -math.inf, default=None)
    less = "" if lesser is None else f"; of the cheaper ones {lesser.name!r} comes closest with {_error(lesser)}"
    told = f"{ladder.title}: {best.name!r} is enough for {error:.3g}: {_error(best)}, {duration(best.loop_s)}{less}."
    by = f" Errors are counted from {ladder.reference!r}, which is no truth." if ladder.reference else ""
    return ModelChoice(error, ladder, best, lesser, told + by)


def _error(rung: Rung) -> str:
    return "the model that the others are held against" if rung.accuracy is None else f"{10.0**-rung.accuracy:.2g}"
