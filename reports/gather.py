"""What the report shows, read from the store of runs: what it lacks is computed on all cores, then timed alone."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from cross_checks import engines
from cross_checks.extremes import MAP
from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.extremes.fate import read as read_cells
from cross_checks.isolation.parent import Isolated
from cross_checks.isolation.workers import Report
from cross_checks.judge.answers import questions
from cross_checks.judge.capabilities import Capability, capabilities
from cross_checks.judge.cell import tasks
from cross_checks.prices.timing import timed_all
from cross_checks.records.store import Store, code_of, digest_of
from mbs_ref import Scene, scenes
from mbs_ref.files import package_data
from reports import inputs
from reports.facts import stored as facts
from reports.facts.compiling import preparations
from reports.facts.environment import environment
from reports.facts.report_data import GROWING, INTERRUPTED, ReportData, contenders
from reports.facts.scene_facts import SceneFacts, TruthFacts, scene_facts, truth_facts
from reports.studies.study import every, measure_all, stored

LISTS = package_data(__name__, "scenes.toml")
SCENES, QUICK = LISTS["report"], LISTS["quick"]


def chosen_scenes(quick: bool = False, wanted: Sequence[str] = ()) -> dict[str, Scene]:
    """Return the scenes of the report by their labels: those that are wanted, by label, name or file, else all."""

    def named(built: Iterable[Scene]) -> dict[str, Scene]:
        return {scenes.label(scene.name, scene.parameters): scene for scene in built}

    every = named(scenes.make(name, **parameters) for name, parameters in (QUICK if quick else SCENES))
    met = {one: [scene for label, scene in every.items() if one in (label, scene.name)] for one in wanted}
    met = {one: own or [inputs.comparable(one.split()[0], one.split()[1:])] for one, own in met.items()}
    return named(scene for own in met.values() for scene in own) or every


@dataclass(frozen=True)
class Gathering:
    """How the data of a report are brought up to date.

    Effort is bounded by the work that a search may do and, unless `full`, by the predicted processor time of a run that
    serves a target alone; what is left out states its cost. `quick` takes few scenes; `scenes` and
    `engines` name others, without the studies; `again` times anew what the store has timed. The extremes are those of
    `files`, else of the last run that the source tree holds. Callers alike `call` execute the runs; times and studies
    are always measured on this machine.
    """

    store: Store
    quick: bool = False
    progress: Report | None = None
    files: Sequence[Path] = ()
    again: bool = False
    call: Isolated | None = None
    scenes: Sequence[str] = ()
    engines: Sequence[str] = ()
    full: bool = False

    @property
    def is_part(self) -> bool:
        """Whether the report shows less than all."""
        return bool(self.quick or self.scenes or self.engines)

    @cached_property
    def shown(self) -> dict[str, Scene]:
        """The scenes by their labels."""
        return chosen_scenes(self.quick, self.scenes)

    def report(self, done: int, total: int, what: str) -> None:
        """Report progress where it is requested."""
        if self.progress is not None:
            self.progress(done, total, what)

    def stages(self) -> Generator[Callable[[], ReportData]]:
        """Yield what returns the data there are: after each cell, after each stage, and at last of all of them.

        `incomplete` states what is still being computed; after Ctrl-C, what was interrupted.
        """
        data = ReportData((), (), environment=environment(), quick=self.is_part, studies=stored())
        data = yield from self.judged(data)
        for waited_for, stage in STAGES[:-1] if self.is_part else STAGES:
            if data.state == INTERRUPTED:
                break
            yield partial(replace, data, incomplete=f"still being computed: {waited_for}", state=GROWING)
            data = stage(self, data)
        self.report(1, 1, "writing the page")
        yield lambda: data

    def judged(self, data: ReportData) -> Generator[Callable[[], ReportData], None, ReportData]:
        """Judge every method on every scene, and yield the data so far; after Ctrl-C unfinished ones are missing."""

        def there() -> ReportData:
            held = [result[question] for question in wanted if question in result]
            records, missing = tuple(record for answer in held for record in answer.records), len(wanted) - len(held)
            incomplete = f"still being computed: {missing} of {len(wanted)} verdicts"
            cells = tuple(one.cell for one in held)
            return replace(data, cells=cells, records=records, incomplete=incomplete, state=GROWING)

        wanted = questions(list(self.shown.values()), tasks(self.engines or engines.names()))
        result = facts.stored_answers(self.store, wanted, self.full)
        missing = [question for question in wanted if question not in result]
        reasons: list[str] = []
        truths: dict[str, TruthFacts] = {}
        with _interruptible(reasons, lambda: f"{len(result)} of {len(wanted)} cells"):
            if missing:
                asked = {question.engine for question in missing}
                needed = [one for one in preparations(self.store) if one.engine in asked]
                for answer in facts.settled_answers(self.store, missing, self.report, self.call, self.full, needed):
                    if answer.truth is not None and answer.cell.label not in truths:
                        truths[answer.cell.label] = truth_facts(answer.cell.label, answer.question.scene, answer.truth)
                        facts.keep(
                            self.store, facts.truth_key(answer.question.scene), TruthFacts, truths[answer.cell.label]
                        )
                    result[answer.question] = facts.Stored(answer.cell, answer.records)
                    yield there
        return _ended(there(), reasons)

    def timed(self, data: ReportData) -> ReportData:
        """Time what is ranked, alone."""
        reasons: list[str] = []
        result: dict[int, Any] = {}
        with _interruptible(reasons, lambda: "the accuracy runs, before all was timed"):
            result = timed_all(self.store, contenders(data), self.report, self.again)
        records = tuple(result.get(id(record), record) for record in data.records)
        return _ended(replace(data, records=records), reasons)

    def beyond(self, data: ReportData) -> ReportData:
        """Add what engines can model, the facts of the truths, and the extremes."""
        chosen = self.shown
        held = [facts.recall(self.store, facts.truth_key(scene), TruthFacts) for scene in chosen.values()]
        filmed = [self.mechanism(label, scene) for label, scene in chosen.items()]
        data = replace(data, truths=tuple(facts for facts in held if facts is not None), mechanisms=tuple(filmed))
        parts = ["capabilities", *facts.engine_keys(), list(chosen), code_of("cross_checks.judge.capabilities")]
        kind: Any = tuple[Capability, ...]
        able = facts.remembered(self.store, digest_of(parts), kind, lambda: capabilities(chosen))
        return _ended(replace(data, capabilities=able, extremes=self.extreme_cells()).only(engines=self.engines), ())

    def mechanism(self, label: str, scene: Scene) -> SceneFacts:
        """Return a scene's facts."""
        self.report(0, 1, f"filming {label}")
        return facts.remembered(self.store, facts.scene_key(scene), SceneFacts, partial(scene_facts, scene))

    def extreme_cells(self) -> tuple[ExtremeCell, ...]:
        """Return the cells that files hold, full ones before quick ones; without a file those of the source tree."""
        cells = (cell for file in self.files or (MAP,) for cell in read_cells(file)[0])
        return tuple({(c.extreme, c.engine, c.method): c for c in sorted(cells, key=lambda cell: cell.full)}.values())

    def studied(self, data: ReportData) -> ReportData:
        """Add the studies; one that fails costs its own page only."""
        reasons: list[str] = []
        result = dict(data.studies)
        with _interruptible(reasons, lambda: f"{len(result)} of {len(every())} studies"):
            reasons += measure_all(self.store, result, facts.engine_keys(), self.report, self.full)
        return _ended(replace(data, studies=result), reasons)


STAGES: tuple[tuple[str, Callable[[Gathering, ReportData], ReportData]], ...] = (  # each with what a page waits for
    ("times taken alone", Gathering.timed), ("capabilities and extremes", Gathering.beyond),
    ("studies", Gathering.studied),
)  # fmt: skip


def _ended(data: ReportData, reasons: Sequence[str]) -> ReportData:
    """Return the data of a stage that has ended, with the reasons for what is missing."""
    interrupted = any(reason.startswith(INTERRUPTED) for reason in reasons)
    return replace(data, incomplete="; ".join(reasons), state=INTERRUPTED if interrupted else "")


@contextmanager
def _interruptible(reasons: list[str], what: Callable[[], str]) -> Iterator[None]:
    """Turn Ctrl-C into a sentence."""
    try:
        yield
    except KeyboardInterrupt:
        reasons.append(f"{INTERRUPTED} after {what()}")
