"""The search against full ladders: what each finds on every default scene, and in how many runs.

    python -m tests.cross_checks.judge.search_against_ladders [SCENE ...] [--store FILE]

Prints a line a method with what it missed, and the sums; runs are kept in the store.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.isolation.parent import Isolated
from cross_checks.judge.bounds import MOST_STEPS, TARGETS, WINDOW
from cross_checks.judge.cell import refusal_of, tasks, truth_of
from cross_checks.judge.ladder import label, rungs
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.records.record import Record
from cross_checks.records.store import Store, default_path
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from reports.gather import SCENES

BOUND = 1.01 * MOST_STEPS  # of a rung that the search could choose: a step is shortened to divide the outputs


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
    for engine, method in tasks(engines.names()):
        if method is not None and not refusal_of(scene, engine, method):
            yield _compared(runs, scene, engine, method, truth)


def _compared(runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth) -> Compared:
    tried, answers = search(runs, scene, engine, method, truth)
    climbed = list(_climbed(runs, scene, engine, method, truth))
    within = [record for record in climbed if _is_within(record)]
    chosen = [answer.record for answer in answers]
    runnable = [knob for knob in tried.knobs if tried.records[knob].status == "success"]
    return Compared(
        scenes.label(scene.name, scene.parameters), engine, method.name, len(climbed), len(tried.records),
        tuple(_told(next((r for r in within if _reaches(r, target)), None)) for target in TARGETS),
        tuple(_told(record) for record in chosen),
        tuple(f"{answer.answer} {answer.reason}" for answer in answers),
        tuple(r.error.value / t if r is not None and r.error else 0.0 for r, t in zip(chosen, TARGETS, strict=True)),
        tuple(r is not None and knob(r) >= 0.99 * max(runnable) for r in chosen),
    )  # fmt: skip


def _climbed(runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth) -> Iterator[Record]:
    """Yield the ladder's runs, coarse to fine, up to the bound on work; a tolerance that passes it is the last."""
    for settings in rungs(method, scene):
        if settings.step is not None and scene.duration / settings.step > BOUND:
            return
        record = runs.judged(scene, engine, settings, truth)
        yield record
        if not _is_within(record):
            return


def _is_within(record: Record) -> bool:
    """Whether a run keeps to the search's bound on work: of a tolerance that is known once it ran."""
    return "step" in record.settings or record.steps <= BOUND


def knob(record: Record) -> float:
    settings = Settings(**record.settings)
    return settings.step or settings.rtol or 0.0


def _reaches(record: Record, target: float) -> bool:
    error = record.error
    return record.status == "success" and error is not None and error.bound <= target


def _told(record: Record | None) -> str:
    if record is None or record.error is None:
        return ""
    return f"{label(Settings(**record.settings))} {record.error.value:.1e}"


@dataclass(frozen=True)
class Summary:
    """Sums over methods and scenes."""

    searched: int  # runs
    climbed: int
    targets: int  # that a rung reaches
    choices: int
    missed: tuple[str, ...]
    far: tuple[str, ...]


def summary(cells: Iterable[Compared]) -> Summary:
    """Add up what was compared."""
    every = list(cells)
    return Summary(
        sum(cell.searched for cell in every), sum(cell.climbed for cell in every),
        sum(bool(rung) for cell in every for rung in cell.ladder),
        sum(bool(choice) for cell in every for choice in cell.choice),
        tuple(text for cell in every for text in cell.missed), tuple(text for cell in every for text in cell.far),
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description="The search against full ladders.")
    parser.add_argument("scenes", nargs="*", help="default scenes of the page; all unless given")
    parser.add_argument("--store", type=Path, default=default_path())
    asked = parser.parse_args()
    cells = []
    with Store(asked.store) as store, Isolated() as call:
        runs = Runs(store, call)
        for name, parameters in SCENES:
            if asked.scenes and name not in asked.scenes:
                continue
            for cell in compared(runs, name, parameters):
                cells.append(cell)
                lost = "; ".join((*cell.missed, *cell.far))
                print(f"{cell.name:50} {cell.searched:3} of {cell.climbed:3} {lost}", flush=True)
    found = summary(cells)
    share = found.searched / max(1, found.climbed)
    print(f"{found.searched} runs of {found.climbed} ({share:.1%}); {len(found.missed)} of {found.targets} targets "
          f"missed, {len(found.far)} of {found.choices} choices too far below")  # fmt: skip


if __name__ == "__main__":
    main()
