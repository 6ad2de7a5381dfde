"""The search against full ladders: it finds what they find, at the error asked, in fewer runs.

Bounds are as measured on the nine planar scenes: 720 runs against 1360, two targets of 321 missed, four choices of 319
further below their target than asked. Both misses hang on single steps: an implicit iteration that fails at steps
on either side of one that works, and errors that rise and fall as a loop passes near a singular pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.isolation.parent import Isolated
from cross_checks.judge.cell import refused, tasks, truth_of
from cross_checks.judge.ladder import label, rungs
from cross_checks.judge.runs import Runs
from cross_checks.judge.search import MOST_STEPS, TARGETS, WINDOW, search
from cross_checks.records.record import Record
from cross_checks.records.store import Store, default_path
from cross_checks.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from reports.gather import SCENES
from reports.reproduce import scene_label

FEWER = 0.55  # of the ladders' runs
MISSED = 0.01  # of the targets that a rung reaches
FAR = 0.02  # of the choices


@dataclass(frozen=True)
class Compared:
    """One method on one scene: the cheapest rung of the ladder and the search's choice for each target."""

    scene: str
    engine: str
    method: str
    climbed: int  # runs of the ladder
    searched: int  # runs of the search
    ladder: tuple[str, ...]  # setting and error by target; empty where no rung reaches it
    choice: tuple[str, ...]
    answers: tuple[str, ...]
    shares: tuple[float, ...]  # chosen error over the target; 0 where nothing was chosen
    ends: tuple[bool, ...]  # whether the choice is the coarsest setting that runs

    @property
    def missed(self) -> list[str]:
        """Targets that a rung reaches and the search does not."""
        both = zip(TARGETS, self.ladder, self.choice, self.answers, strict=True)
        lost = [(target, rung, answer) for target, rung, choice, answer in both if rung and not choice]
        return [f"{self.name} {target:g}: {rung}, but {answer}" for target, rung, answer in lost]

    @property
    def far(self) -> list[str]:
        """Choices whose error is more than WINDOW below the target, though a coarser setting runs."""
        all_of_it = zip(TARGETS, self.choice, self.shares, self.ends, strict=True)
        return [
            f"{self.name} {target:g}: {choice}"
            for target, choice, share, end in all_of_it
            if choice and share < 1.0 / WINDOW and not end
        ]

    @property
    def name(self) -> str:
        return f"{self.scene} {self.engine} {self.method}"


def compared(runs: Runs, name: str, parameters: dict) -> Iterator[Compared]:
    """Yield a comparison for every method that is not refused."""
    scene = scenes.make(name, **parameters)
    truth = truth_of(runs, scene)
    for engine, method in tasks(scene, engines.names()):
        if method is not None and not refused(scene, engine, method)[1]:
            yield _compared(runs, scene, engine, method, truth)


def _compared(runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth) -> Compared:
    tried, answers = search(runs, scene, engine, method, truth)
    climbed = [
        runs.judged(scene, engine, settings, truth)
        for settings in rungs(method, scene)
        if settings.step is None or scene.duration / settings.step <= 1.01 * MOST_STEPS
    ]
    chosen = [answer.record for answer in answers]
    runnable = [knob for knob in tried.knobs if tried.records[knob].status == "success"]
    return Compared(
        scene_label(scene.name, scene.parameters), engine, method.name, len(climbed), len(tried.records),
        tuple(_told(next((r for r in climbed if _reaches(r, target)), None)) for target in TARGETS),
        tuple(_told(record) for record in chosen),
        tuple(f"{answer.answer} {answer.reason}" for answer in answers),
        tuple(r.error.value / t if r is not None and r.error else 0.0 for r, t in zip(chosen, TARGETS, strict=True)),
        tuple(r is not None and knob(r) >= 0.99 * max(runnable) for r in chosen),
    )  # fmt: skip


def knob(record: Record) -> float:
    settings = Settings(**record.settings)
    return settings.step or settings.rtol or 0.0


def _reaches(record: Record, target: float) -> bool:
    error = record.error
    return record.status == "success" and error is not None and error.value <= target and error.floor <= target


def _told(record: Record | None) -> str:
    if record is None or record.error is None:
        return ""
    return f"{label(Settings(**record.settings))} {record.error.value:.1e}"


@pytest.mark.slow
def test_the_search_finds_what_full_ladders_find_in_about_half_the_runs():
    with Store(default_path()) as store, Isolated() as call:
        runs = Runs(store, call)
        cells = [cell for name, parameters in SCENES for cell in compared(runs, name, parameters)]
    missed, far = [text for cell in cells for text in cell.missed], [text for cell in cells for text in cell.far]
    assert len(missed) <= MISSED * sum(bool(rung) for cell in cells for rung in cell.ladder), missed
    assert len(far) <= FAR * sum(bool(choice) for cell in cells for choice in cell.choice), far
    assert sum(cell.searched for cell in cells) <= FEWER * sum(cell.climbed for cell in cells)
