"""Everything the page shows, as plain data: the page reads this and nothing else."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from cross_checks.extremes.cell import Cell as ExtremeCell
from cross_checks.records.record import Record
from mbs_ref import scenes
from reports.page.truth_facts import TruthFacts
from reports.studies.androids.measure import AndroidFacts
from reports.studies.contact.measure import ContactFacts
from reports.studies.crashes.measure import Crash
from reports.studies.sky.measure import SkyFacts
from reports.studies.space.measure import SpaceFacts


@dataclass(frozen=True)
class Cell:
    """One cell of the validation matrix. Numbers are finite or None."""

    scene: str  # label, with parameters
    engine: str
    method: str
    verdict: str
    reason: str
    error: float | None  # m
    compliance: float | None  # m, rad
    order: float | None  # observed


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
    orders: dict[tuple[str, str], int] = field(default_factory=dict)  # (engine, method) -> documented order
    quick: bool = False
    incomplete: str = ""  # why it holds less than asked; empty where it holds all
    sky: SkyFacts | None = None  # digits against physics, races, formulations; None in a quick report
    crashes: tuple[Crash, ...] = ()  # the androids; empty in a quick report
    androids: AndroidFacts | None = None  # under many methods and engines; None in a quick report
    seconds: float = 0.0  # s, spent on the runs
    contact: ContactFacts | None = None  # the ball and the tracked vehicle; None in a quick report
    truths: tuple[TruthFacts, ...] = ()  # what the errors are measured from
    extremes: tuple[ExtremeCell, ...] = ()  # read from a file beside the page, or a few cells
    space: SpaceFacts | None = None  # measured on spatial bodies; None in a quick report

    @property
    def absence(self) -> str:
        """Return why a section that is not there is not."""
        return "The full report measures this; a quick one does not." if self.quick else f"Missing: {self.incomplete}."

    @property
    def scenes(self) -> list[str]:
        """Return the labels of every scene, in the order they were run."""
        return _unique([*(c.scene for c in self.cells), *(scene_label(r.scene, r.parameters) for r in self.records)])

    @property
    def engines(self) -> list[str]:
        """Return every engine met, the reference solver first."""
        met = _unique([*(c.engine for c in self.cells), *(r.engine for r in self.records)])
        return sorted(met, key=lambda name: (name != "mbs_ref", name))

    def of_scene(self, label: str) -> list[Record]:
        """Return the records of one scene."""
        return [r for r in self.records if scene_label(r.scene, r.parameters) == label]


def scene_label(name: str, parameters: dict[str, Any]) -> str:
    """Return a scene's name with its counts and whatever else was chosen, as the command line takes them."""
    chosen = chosen_parameters(name, parameters)
    shown = {key: value for key, value in parameters.items() if isinstance(value, int) or key in chosen}
    return " ".join([name, *(f"{key}={value}" for key, value in shown.items())])


def chosen_parameters(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters that differ from the scene's defaults."""
    defaults = scenes.describe(name).parameters if name in scenes.names() else {}
    return {key: value for key, value in parameters.items() if defaults.get(key) != value}


def _unique(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))
