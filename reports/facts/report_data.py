"""Everything the page shows, as plain data: the page reads this and nothing else. `mbs-ref report --render` reads it
from the file that the last report left."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from cross_checks.extremes.cell import Cell as ExtremeCell
from cross_checks.judge.ladder import label
from cross_checks.records.record import MISSING, Record
from mbs_ref.settings import Settings
from reports.facts.truth_facts import TruthFacts
from reports.reproduce import scene_label

OURS = "mbs_ref"  # shown apart from the ranking of engines


@dataclass(frozen=True)
class Target:
    """What became of one target error."""

    target: float  # over the scene's scales
    answer: str  # reached | not-reached | not-tried | cannot | unjudged
    reason: str = ""
    setting: str = ""  # of the cheapest run that reached it


@dataclass(frozen=True)
class Cell:
    """One method on one scene. Errors are over the scene's scales. Numbers are finite or None."""

    scene: str  # label, with parameters
    engine: str
    method: str
    verdict: str
    reason: str
    error: float | None
    compliance: float | None  # m, rad
    order: float | None  # observed
    excuse: str = ""  # why the method is known to go wrong on such a scene
    documented_order: int | None = None
    setting: str = ""  # of the run that speaks for the method
    targets: tuple[Target, ...] = ()

    @property
    def name(self) -> str:
        """How `mbs-ref rerun` calls it."""
        return f"{self.scene.replace(' ', ',')}/{self.engine}/{self.method}"


@dataclass(frozen=True)
class Capability:
    """What an engine can do with a part type or a trait."""

    engine: str
    kind: str  # part | trait
    name: str
    answer: str  # can | never | not-yet | missing
    reason: str = ""


@dataclass(frozen=True)
class ReportData:
    """One report's contents."""

    cells: tuple[Cell, ...]
    records: tuple[Record, ...]
    capabilities: tuple[Capability, ...] = ()
    environment: dict[str, str] = field(default_factory=dict)
    quick: bool = False
    incomplete: str = ""  # why it holds less than asked; empty where it holds all
    truths: tuple[TruthFacts, ...] = ()  # what the errors are measured from
    extremes: tuple[ExtremeCell, ...] = ()  # read from a file beside the page, or a few cells
    studies: dict[str, Any] = field(default_factory=dict)  # facts by the study's name; none in a quick report

    @property
    def absence(self) -> str:
        """Return why a section that is not there is not."""
        return "The full report measures this; a quick one does not." if self.quick else f"Missing: {self.incomplete}."

    def study[Facts](self, kind: type[Facts]) -> Facts | None:
        """Return the facts of a kind; None where that study is not there."""
        return next((facts for facts in self.studies.values() if isinstance(facts, kind)), None)

    @cached_property
    def scenes(self) -> list[str]:
        """Return the labels of every scene, in the order they were run."""
        return _unique([*(c.scene for c in self.cells), *self._by_scene])

    @cached_property
    def engines(self) -> list[str]:
        """Return every engine met, the reference solver first, those that are not installed last."""
        met = _unique([*(c.engine for c in self.cells), *(r.engine for r in self.records)])
        missing = {c.engine for c in self.cells if c.verdict == MISSING}
        return sorted(met, key=lambda name: (name != OURS, name in missing, name))

    def of_scene(self, label: str) -> list[Record]:
        """Return the records of one scene."""
        return self._by_scene.get(label, [])

    def cells_of(self, scene: str, engine: str) -> list[Cell]:
        """Return the cells of an engine's methods on one scene."""
        return self._by_place.get((scene, engine), [])

    def once[Answer](self, key: tuple, make: Callable[[], Answer]) -> Answer:
        """Return what was made of these data under a key before, else what `make` returns."""
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def record(self, cell: Cell, setting: str) -> Record | None:
        """Return a cell's run at a setting."""
        return self._by_run.get((cell.scene, cell.engine, cell.method, setting))

    def only(self, scene: str | None = None, engine: str | None = None) -> ReportData:
        """Return what concerns one scene or one engine."""
        here = [c for c in self.cells if scene in (None, c.scene) and engine in (None, c.engine)]
        runs = self.records if scene is None else self.of_scene(scene)
        return replace(
            self, cells=tuple(here), records=tuple(r for r in runs if engine in (None, r.engine)),
            truths=tuple(t for t in self.truths if scene in (None, t.scene)),
            capabilities=tuple(c for c in self.capabilities if engine in (None, c.engine)),
            extremes=tuple(c for c in self.extremes if engine in (None, c.engine)),
        )  # fmt: skip

    @cached_property
    def _made(self) -> dict[tuple, Any]:
        return {}

    @cached_property
    def _by_place(self) -> dict[tuple[str, str], list[Cell]]:
        found: dict[tuple[str, str], list[Cell]] = defaultdict(list)
        for cell in self.cells:
            found[(cell.scene, cell.engine)].append(cell)
        return dict(found)

    @cached_property
    def _by_scene(self) -> dict[str, list[Record]]:
        found: dict[str, list[Record]] = defaultdict(list)
        for record in self.records:
            found[scene_label(record.scene, record.parameters)].append(record)
        return dict(found)

    @cached_property
    def _by_run(self) -> dict[tuple[str, str, str, str], Record]:
        return {
            (scene, r.engine, r.method, setting_label(r)): r for scene, runs in self._by_scene.items() for r in runs
        }


def setting_label(record: Record) -> str:
    """Return the accuracy setting of a record as the judge names it: step=0.001, rtol=1e-06."""
    given = record.settings
    if given.get("step") is None and given.get("rtol") is None:
        return "defaults"
    return label(Settings(step=given.get("step"), rtol=given.get("rtol")))


def _unique(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))
