"""The cells of the validation matrix with their runs: read from the store, or computed on all cores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from cross_checks import engines as registry
from cross_checks.isolation.parent import Isolated
from cross_checks.isolation.workers import TIMEOUT
from cross_checks.judge.answers import Answer, Question, answers
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.ladder import grid
from cross_checks.judge.runs import PASSING, Runs
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.naming import code_of, digest_of, truth_name
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from cross_checks.truths.stored_poses import physics_of
from mbs_ref import scenes
from mbs_ref.scene import Scene
from reports.facts.kept import keep, recall

JUDGING = "cross_checks.judge.cell"  # whose changes make cells anew
Report = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Stored:
    """A cell with the runs that it was judged from."""

    cell: Cell
    records: tuple[Record, ...] = ()


def truth_key(scene: Scene) -> str:
    """Return the key of the facts of a scene's truth."""
    return digest_of(["truth facts", *_physics(scene), _judge(), code_of("reports.facts.truth_facts")])


def _key(question: Question) -> str:
    method = None if question.method is None else question.method.name
    return digest_of(["cell", *_physics(question.scene), _engine_key(question.engine), method, _judge()])


def _physics(scene: Scene) -> list[str]:
    return [scenes.label(scene.name, scene.parameters), physics_of(scene), truth_name(scene, grid(scene))]


def stored_answers(store: Store, asked: list[Question]) -> dict[Question, Stored]:
    """Return the answers that the store holds."""
    held = {question: recall(store, _key(question), Stored) for question in asked}
    return {question: answer for question, answer in held.items() if answer is not None}


def settled_answers(store: Store, asked: list[Question], report: Report) -> Iterator[Answer]:
    """Yield the settled answer to every question; the store keeps those in which the machine had no part."""
    for answer in answers(Runs(store, Isolated(TIMEOUT)), asked, progress=report):
        if answer.is_settled:
            if not any(record.status in PASSING for record in answer.records):
                keep(store, _key(answer.question), Stored, Stored(answer.cell, answer.records))
            yield answer


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
