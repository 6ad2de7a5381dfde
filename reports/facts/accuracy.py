"""The cells of the validation matrix with their runs: read from the store, or computed on all cores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from cross_checks import engines as registry
from cross_checks.certify.kept_poses import physics_of
from cross_checks.engine import Method
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import each
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.cell import judged, tasks, truth_of
from cross_checks.judge.ladder import grid
from cross_checks.judge.runs import PASSING, Runs
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.naming import code_of, digest_of, truth_name
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from reports.facts.kept import keep, recall

JUDGING = "cross_checks.judge.cell"  # whose changes make cells anew
Truths = dict[str, Truth | NoTruth]  # by the scene's label
Report = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Question:
    """A method on a scene."""

    key: str  # of its answer in the store
    label: str
    scene: Scene
    engine: str
    method: Method | None  # None where the engine is not installed


@dataclass(frozen=True)
class Answer:
    """A cell with the runs that it was judged from."""

    cell: Cell
    records: tuple[Record, ...] = ()


def questions(chosen: dict[str, Scene]) -> list[Question]:
    """Return every method of every engine on every labelled scene."""
    found, asked = [], tasks(registry.names())
    for label, scene in chosen.items():
        physics = _physics(label, scene)
        for engine, method in asked:
            key = digest_of(["cell", *physics, _engine_key(engine), None if method is None else method.name, _judge()])
            found.append(Question(key, label, scene, engine, method))
    return found


def truth_key(label: str, scene: Scene) -> str:
    """Return what the facts of a scene's truth are kept under."""
    return digest_of(["truth facts", *_physics(label, scene), _judge(), code_of("reports.facts.truth_facts")])


def _physics(label: str, scene: Scene) -> list[str]:
    return [label, physics_of(scene), truth_name(scene, grid(scene))]


def truths(store: Store, chosen: dict[str, Scene], report: Report) -> Truths:
    """Return every scene's truth, certified or agreed."""
    found: Truths = {}
    asked = list(chosen.items())
    for (label, _), truth in each(asked, lambda call, item: truth_of(Runs(store, call), item[1])):
        found[label] = truth
        report(len(found), len(asked), f"truth of {label}")
    return {label: found[label] for label in chosen}


def kept_answers(store: Store, asked: list[Question]) -> dict[Question, Answer]:
    """Return the answers that the store holds."""
    held = {question: recall(store, question.key, Answer) for question in asked}
    return {question: answer for question, answer in held.items() if answer is not None}


def answers(store: Store, asked: list[Question], known: Truths) -> Iterator[tuple[Question, Answer]]:
    """Yield an answer to every question as it is found; the store keeps them."""
    return each(asked, lambda call, question: _answer(store, call, question, known[question.label]))


def _answer(store: Store, call: Caller, question: Question, truth: Truth | NoTruth) -> Answer:
    found, passing = answer(Runs(store, call), question, truth)
    return found if passing else keep(store, question.key, Answer, found)


def answer(runs: Runs, question: Question, truth: Truth | NoTruth) -> tuple[Answer, bool]:
    """Return the answer, and whether the machine had a part in it: such a one is not stored."""
    cell, records = judged(runs, question.scene, question.engine, question.method, truth)
    return Answer(cell, records), any(record.status in PASSING for record in records)


@cache
def _engine_key(name: str) -> list[str]:
    try:
        engine = registry.get(name)
    except registry.EngineMissing as missing:
        return [name, str(missing)]
    return [name, engine.version(), code_of(type(engine).__module__)]


@cache
def _judge() -> list[Any]:
    """Return what else an answer hangs on: the code that judges, the targets, and what a cell holds."""
    return [code_of(JUDGING), list(TARGETS), [part.name for part in fields(Cell)]]
