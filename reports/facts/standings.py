"""How engines stand at one target error over all scenes: the one source of ranks, factors and performance profiles."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

from cross_checks.judge.vocabulary import OURS
from reports.facts.cheapest import Entry, entries, loop_time
from reports.facts.report_data import ReportData

MIDDLE = 1e-6  # over the scene's scales: the target at which engines are compared in words


@dataclass(frozen=True)
class Standing:
    """An engine at one target, each engine at its cheapest setting. Our own solver is ranked nowhere."""

    engine: str
    reached: int  # scenes
    cheapest: int  # scenes on which it is the cheapest ranked engine
    factors: dict[str, float]  # scene -> its loop time over that of the cheapest ranked engine
    problems: int  # scenes on which some ranked engine reaches the target

    @property
    def median(self) -> float | None:
        """The median of the factors; None without any."""
        return median(self.factors.values()) if self.factors else None

    def share(self, tau: float) -> float:
        """Return rho(tau): the share of problems solved within tau times the best time (Dolan & More 2002, eq 1)."""
        return sum(factor <= tau for factor in self.factors.values()) / self.problems


def over_cheapest(listed: list[Entry]) -> dict[str, float]:
    """Return each engine's loop time over that of the cheapest ranked engine, by engine; empty where none is ranked."""
    times = {entry.engine: loop_time(entry.best) for entry in listed if entry.best is not None}
    least = min((time for engine, time in times.items() if engine != OURS), default=None)
    return {} if least is None else {engine: time / least for engine, time in times.items()}


def standings(data: ReportData, target: float) -> list[Standing]:
    """Return the ranked engines that reach the target somewhere, the most often cheapest first; then ours."""
    return data.once(("standings", target), lambda: _standings(data, target))


def _standings(data: ReportData, target: float) -> list[Standing]:
    listed = {scene: entries(data, scene, target) for scene in data.scenes}
    factors = {scene: over_cheapest(own) for scene, own in listed.items()}
    first = [min((f, e) for e, f in own.items() if e != OURS)[1] for own in factors.values() if own]

    def standing(engine: str) -> Standing:
        reached = sum(e.engine == engine and e.best is not None for own in listed.values() for e in own)
        own = {scene: ratios[engine] for scene, ratios in factors.items() if engine in ratios}
        return Standing(engine, reached, first.count(engine), own, len(first))

    every = [one for engine in data.engines if (one := standing(engine)).reached or engine == OURS]
    return sorted(every, key=lambda one: (one.engine == OURS, -one.cheapest, -one.reached, one.median or float("inf")))


def standing_of(data: ReportData, engine: str, target: float) -> Standing | None:
    """Return an engine's standing; None where it reaches the target nowhere."""
    return next((one for one in standings(data, target) if one.engine == engine), None)
