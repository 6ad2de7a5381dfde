"""Everything the page shows, as plain data with indices: the page reads this and nothing else.

`mbs-ref report --render` reads it from the file that the last report wrote. Cost at equal error follows from it: each
engine's cheapest run at a target, and the ranks, factors and performance profiles of engines over all scenes.
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import median
from typing import Any

from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.capabilities import Capability
from cross_checks.judge.vocabulary import ANSWERS, OURS, Answer, Cell, Verdict
from cross_checks.records.record import Record, loop_time
from mbs_ref.files import package_data
from reports.facts.curves import Measured
from reports.facts.scene_facts import SceneFacts, TruthFacts

GROWING, INTERRUPTED = "growing", "interrupted"  # more is being computed, and pages reload; Ctrl-C ended it


@dataclass(frozen=True)
class ReportData:
    """One report's contents."""

    cells: tuple[Cell, ...]
    records: tuple[Record, ...]
    capabilities: tuple[Capability, ...] = ()
    environment: dict[str, str] = field(default_factory=dict)
    quick: bool = False
    targets: tuple[float, ...] = TARGETS  # errors over the scene's scales
    incomplete: str = ""  # why it holds less than requested; empty where it holds all
    state: str = ""  # GROWING, INTERRUPTED, or nothing once every stage has ended
    mechanisms: tuple[SceneFacts, ...] = ()
    truths: tuple[TruthFacts, ...] = ()  # what the errors are measured from
    extremes: tuple[ExtremeCell, ...] = ()  # read from a file beside the page, or a few cells
    studies: dict[str, Measured] = field(default_factory=dict)  # by name; in a quick report those that run nothing

    @property
    def absence(self) -> str:
        """Return why a section that is not there is not."""
        return "The full report measures this; a quick one does not." if self.quick else f"Missing: {self.incomplete}."

    @cached_property
    def scenes(self) -> list[str]:
        """Return the labels of every scene, in the order they were run."""
        return list(dict.fromkeys([*(c.label for c in self.cells), *self._by_scene]))

    @cached_property
    def engines(self) -> list[str]:
        """Return every engine met, the reference solver first, those that are not installed last."""
        met = {c.engine for c in self.cells} | {r.engine for r in self.records}
        return sorted(met, key=lambda name: (name != OURS, name in self.missing, name))

    @cached_property
    def missing(self) -> set[str]:
        """Return the engines that are not installed."""
        return {c.engine for c in self.cells if c.verdict is Verdict.ENGINE_MISSING}

    @property
    def installed(self) -> list[str]:
        """Return the engines that are installed, the reference solver first."""
        return [name for name in self.engines if name not in self.missing]

    def of_scene(self, label: str) -> list[Record]:
        """Return the records of one scene."""
        return self._by_scene.get(label, [])

    def cells_of(self, scene: str, engine: str) -> list[Cell]:
        """Return the cells of an engine's methods on one scene."""
        return self._by_place.get((scene, engine), [])

    def modelled(self, engine: str) -> list[str]:
        """Return the scenes that some method of the engine takes."""
        return [s for s in self.scenes if any(not cell.is_refused for cell in self.cells_of(s, engine))]

    def once[Answer](self, key: tuple, compute: Callable[[], Answer]) -> Answer:
        """Return what was computed from these data under a key before, else what `compute` returns."""
        if key not in self._computed:
            self._computed[key] = compute()
        return self._computed[key]

    def measured(self, record: Record) -> Record:
        """Return the record of the same run among these data, whose loop may have been timed alone."""
        return self._by_run.get(_key(record), record)

    def only(
        self, scenes: Collection[str] = (), engines: Collection[str] = (), targets: Collection[float] = ()
    ) -> "ReportData":
        """Return what concerns some scenes, engines and target errors; all where none is named."""
        scene, engine = (lambda name, chosen=chosen: not chosen or name in chosen for chosen in (scenes, engines))
        runs = [r for label in scenes for r in self.of_scene(label)] if scenes else self.records
        return replace(
            self, cells=tuple(c for c in self.cells if scene(c.label) and engine(c.engine)),
            records=tuple(r for r in runs if engine(r.engine)),
            truths=tuple(t for t in self.truths if scene(t.scene)),
            mechanisms=tuple(m for m in self.mechanisms if scene(m.scene)),
            capabilities=tuple(c for c in self.capabilities if engine(c.engine)),
            extremes=tuple(c for c in self.extremes if engine(c.engine)),
            targets=tuple(target for target in self.targets if not targets or target in targets),
        )  # fmt: skip

    @cached_property
    def _computed(self) -> dict[tuple, Any]:
        return {}

    @cached_property
    def _by_place(self) -> dict[tuple[str, str], list[Cell]]:
        groups: dict[tuple[str, str], list[Cell]] = defaultdict(list)
        for cell in self.cells:
            groups[(cell.label, cell.engine)].append(cell)
        return dict(groups)

    @cached_property
    def _by_scene(self) -> dict[str, list[Record]]:
        groups: dict[str, list[Record]] = defaultdict(list)
        for record in self.records:
            groups[record.label].append(record)
        return dict(groups)

    @cached_property
    def _by_run(self) -> dict[tuple[Any, ...], Record]:
        return {_key(record): record for record in self.records}


def _key(record: Record) -> tuple[Any, ...]:
    setting = record.settings
    return (record.label, record.engine, record.method, setting.get("step"), setting.get("rtol"))


@dataclass(frozen=True)
class Finding:
    """What went wrong: a sentence with its title, the cell with the largest error, and its tone (fair | bad)."""

    tone: str
    title: str
    text: str
    error: float = 0.0  # over the scene's scales, delivered with success reported; 0 where nothing wrong was
    scene: str = ""
    command: str = ""  # that repeats the runs
    why: str = ""  # what the verdict rests on


@dataclass(frozen=True)
class Section:
    """A titled part of the page. `context` makes the template's variables from the data."""

    name: str  # the anchor
    title: str
    context: Callable[[ReportData], dict[str, Any]]
    lead: str = ""  # one sentence in plain words, where the template does not state it
    template: str = ""  # where it is not <name>.html


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
    if runs := reaching(data, scene, engine, target):
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
