"""The least model of a scene's family that reaches an error, from the ladders of this study."""

import math
from dataclasses import dataclass

from cross_checks.records.numbers import duration, short
from reports.facts.curves import Row


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
    reference: str = ""  # the rung that the others are compared with, where no truth is known

    def cheapest(self) -> list[str]:
        """Return the cheapest model of each whole figure of accuracy, where it changes."""
        reached = [rung.accuracy for rung in self.rungs if rung.accuracy is not None]
        most: dict[str, int] = {}
        for figures in range(1, math.floor(max(reached, default=0)) + 1):
            rung = self.least(figures)
            if rung is not None:
                most[rung.name] = figures
        return [f"up to {figures}: {name}" for name, figures in most.items()]

    def rows(self) -> tuple[Row, ...]:
        """Return what a page shows of each model."""
        return tuple(self._row(rung) for rung in self.rungs)

    def _row(self, rung: Rung) -> Row:
        accuracy = {} if rung.accuracy is None else {self.measure: f"{rung.accuracy:.1f}"}
        shown = {name: short(rung.shown.get(name), 3) for name in self.rungs[0].shown}
        return {
            "model": rung.name, "time": duration(rung.loop_s),
            "over the first": f"{rung.loop_s / self.rungs[0].loop_s:.3g}", "right-hand sides": str(rung.work),
            self.measure: None, **accuracy, **shown,
        }  # fmt: skip

    def least(self, accuracy: float) -> Rung | None:
        """Return the cheapest model that is at least so accurate, the reference included; None where none is."""
        exact = {self.reference: math.inf} if self.reference else {}
        reached = [exact.get(rung.name, rung.accuracy) for rung in self.rungs]
        enough = [rung for rung, has in zip(self.rungs, reached, strict=True) if has is not None and has >= accuracy]
        return min(enough, key=lambda rung: rung.loop_s, default=None)


@dataclass(frozen=True)
class ModelChoice:
    """What is enough, and why nothing less is."""

    error: float  # largest, relative, as requested
    ladder: Ladder
    best: Rung | None
    lesser: Rung | None  # the most accurate of the cheaper models, none of which is enough
    sentence: str


def choose(ladder: Ladder, error: float) -> ModelChoice:
    """Return the cheapest model of a ladder whose relative error is at most `error`."""
    wanted = -math.log10(error)
    best = ladder.least(wanted)
    if best is None:
        known = [rung for rung in ladder.rungs if rung.accuracy is not None]
        nearest = max(known, key=lambda rung: rung.accuracy or 0.0, default=None)
        least = "" if nearest is None else f"; {nearest.name!r} comes closest with {_error(nearest)}"
        return ModelChoice(error, ladder, None, nearest, f"{ladder.title}: no model reaches {error:.3g}{least}.")
    cheaper = [rung for rung in ladder.rungs if rung.loop_s < best.loop_s]
    lesser = max(cheaper, key=lambda rung: rung.accuracy or -math.inf, default=None)
    less = "" if lesser is None else f"; of the cheaper ones {lesser.name!r} comes closest with {_error(lesser)}"
    text = f"{ladder.title}: {best.name!r} is enough for {error:.3g}: {_error(best)}, {duration(best.loop_s)}{less}."
    by = f" Errors are counted from {ladder.reference!r}, which is no truth." if ladder.reference else ""
    return ModelChoice(error, ladder, best, lesser, text + by)


def _error(rung: Rung) -> str:
    return "the model that the others are compared with" if rung.accuracy is None else f"{10.0**-rung.accuracy:.2g}"
