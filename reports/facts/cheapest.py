"""Cost at equal error: each engine's cheapest run at a target, and the ranks, factors and performance
profiles of engines over all scenes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, OURS, Answer, Cell
from cross_checks.records.record import Record, loop_time
from mbs_ref.files import package_data
from reports.facts.report_data import ReportData

NEAR = 1.5  # times the cheapest first run: settings that near are timed, too, since first runs are noisy


@dataclass(frozen=True)
class Entry:
    """What an engine offers at a target error."""

    engine: str
    answer: Answer
    best: Record | None = None  # its cheapest run, where it reached the target
    reason: str = ""
    method: str = ""


def reaching(data: ReportData, scene: str, engine: str, target: float) -> list[Record]:
    """Return the cheapest run of each of an engine's methods that reaches a target on a scene, cheapest first."""
    results = [result for cell in data.cells_of(scene, engine) if (result := cell.result(target)) is not None]
    return sorted((data.measured(result.record) for result in results if result.record is not None), key=loop_time)


def entries(data: ReportData, scene: str, target: float) -> list[Entry]:
    """Return one entry an engine, the cheapest first, those that missed the target last."""
    return data.once(("entries", scene, target), lambda: sorted(
        (_entry(data, scene, engine, target) for engine in data.engines),
        key=lambda e: loop_time(e.best) if e.best else float("inf"),
    ))  # fmt: skip


def _entry(data: ReportData, scene: str, engine: str, target: float) -> Entry:
    runs = reaching(data, scene, engine, target)
    if runs:
        return Entry(engine, "reached", runs[0], method=runs[0].method)
    results = [(cell, result) for cell in data.cells_of(scene, engine) if (result := cell.result(target)) is not None]
    if not results:
        return Entry(engine, "cannot", reason="none of its methods was run for this target")
    cell, result = min(results, key=lambda item: (list(ANSWERS).index(item[1].answer), _error(item[0])))
    return Entry(engine, result.answer, None, result.reason or cell.reason, cell.method)


def _error(cell: Cell) -> float:
    return float("inf") if cell.error is None else cell.error


def contenders(data: ReportData) -> list[Record]:
    """Return the runs that may be an engine's cheapest at a target."""
    every = (run for s in data.scenes for e in data.engines for t in TARGETS for run in near(reaching(data, s, e, t)))
    return list({id(run): run for run in every}.values())


def near(runs: Sequence[Record]) -> list[Record]:
    """Return the runs, sorted by loop time, that may be the cheapest when they are timed again."""
    return [run for run in runs if loop_time(run) <= NEAR * loop_time(runs[0])]


INSIDE: dict[str, str] = package_data(__name__, "inside.toml")
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
    least = least_time(listed)
    return {} if least is None else {one.engine: loop_time(one.best) / least for one in listed if one.best is not None}


def least_time(listed: list[Entry]) -> float | None:
    """Return the loop time (s) of the cheapest ranked engine; None where none is ranked."""
    ranked = (one.best for one in listed if one.engine != OURS)
    return min((loop_time(best) for best in ranked if best is not None), default=None)


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
