"""Facts and judged cells that the store of runs holds as JSON, by the dataclass that they fill."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from cross_checks import engines as registry
from cross_checks.isolation.parent import Isolated
from cross_checks.isolation.workers import TIMEOUT, Report
from cross_checks.judge.answers import Answer, Preparation, Question, answers
from cross_checks.judge.bounds import TARGETS, longest
from cross_checks.judge.ladder import grid
from cross_checks.judge.runs import PASSING, Runs
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.lines import adapter
from cross_checks.records.record import Record
from cross_checks.records.store import Store, code_of, digest_of, engine_key, truth_name
from cross_checks.truths.stored_poses import physics_of
from mbs_ref import Scene, scenes


def recall[Fact](store: Store, key: str, kind: type[Fact]) -> Fact | None:
    """Return the facts stored under a key; None without any."""
    held = store.arrays(key)
    return None if held is None else adapter(kind).validate_python(held[0]["facts"])


def keep[Fact](store: Store, key: str, kind: type[Fact], result: Fact) -> Fact:
    """Store facts under a key; ValueError where they hold NaN or infinity."""
    plain = adapter(kind).dump_python(result, mode="json")
    json.dumps(plain, allow_nan=False)
    store.keep_arrays(key, {"facts": plain}, {})
    return result


def remembered[Fact](store: Store, key: str, kind: type[Fact], make: Callable[[], Fact]) -> Fact:
    """Return the facts stored under a key, else what `make` returns, which is stored."""
    held = recall(store, key, kind)
    return keep(store, key, kind, make()) if held is None else held


JUDGING = "cross_checks.judge.cell"  # whose changes make cells anew


@dataclass(frozen=True)
class Stored:
    """A cell with the runs that it was judged from."""

    cell: Cell
    records: tuple[Record, ...] = ()


def truth_key(scene: Scene) -> str:
    """Return the key of the facts of a scene's truth."""
    code = code_of("reports.facts.scene_facts")
    return digest_of(["truth facts", *_physics(scene), engine_keys(), _judge(), code])


def scene_key(scene: Scene) -> str:
    """Return the key of the facts of a scene."""
    return digest_of(["scene facts", *_physics(scene), code_of("reports.facts.scene_facts")])


def _question_key(question: Question, full: bool) -> str:
    method = None if question.method is None else question.method.name
    return digest_of(["cell", *_physics(question.scene), question.engine, method, engine_keys(), _judge(), full])


def _physics(scene: Scene) -> list[str]:
    return [scenes.label(scene.name, scene.parameters), physics_of(scene), truth_name(scene, grid(scene))]


def stored_answers(store: Store, wanted: list[Question], full: bool) -> dict[Question, Stored]:
    """Return the answers that the store holds."""
    held = {question: recall(store, _question_key(question, full), Stored) for question in wanted}
    return {question: answer for question, answer in held.items() if answer is not None}


def settled_answers(
    store: Store, wanted: list[Question], report: Report, call: Isolated | None, full: bool,
    preparations: Sequence[Preparation] = (),
) -> Iterator[Answer]:  # fmt: skip
    """Yield the settled answer to every question; the store keeps those in which the machine had no part.

    Unless `full`, no run for a target alone takes longer than LONGEST where the verdict is neither open nor wrong.
    """
    runs = Runs(store, call or Isolated(TIMEOUT), longest=longest(full))
    for answer in answers(runs, wanted, progress=report, preparations=preparations):
        if answer.is_settled:
            if not any(record.status in PASSING for record in answer.records):
                keep(store, _question_key(answer.question, full), Stored, Stored(answer.cell, answer.records))
            yield answer


@cache
def engine_keys() -> list[list[str]]:
    """Return what results of several engines depend on; a verdict compares with every engine of the registry."""
    keys = []
    for name in registry.names():
        try:
            keys.append(engine_key(registry.get(name)))
        except registry.EngineMissing as missing:
            keys.append([name, str(missing)])
    return keys


@cache
def _judge() -> list[Any]:
    """Return what else an answer hangs on: the code that judges, the targets, and what a cell holds."""
    return [code_of(JUDGING), list(TARGETS), [part.name for part in fields(Cell)]]
