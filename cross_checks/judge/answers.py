"""Every method on every scene, side by side: truths, and answers that are provisional while a truth is refined."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Caller
from cross_checks.isolation.workers import BRIEF, Late, Pool, Report
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.cell import judged, refusal_of, tasks
from cross_checks.judge.consensus import ENOUGH, Consensus, Request
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.record import Record
from cross_checks.truths.truth import ONE_FIGURE, NoTruth, Truth
from mbs_ref import Scene

USEFUL = TARGETS[0] / ONE_FIGURE  # of the scene: a truth that is known so well shows which methods reach that target
SEARCH = 1.0  # s that a search is expected to take, compared with the levels of a consensus
PREPARATION = 2.0  # s, likewise: other engines come first


@dataclass(frozen=True, eq=False)
class Question:
    """A method on a scene."""

    scene: Scene
    engine: str
    method: Method | None  # None where the engine is not installed

    def __str__(self) -> str:
        return " ".join(filter(None, (self.scene.name, self.engine, self.method and self.method.name)))


class Answer(NamedTuple):
    """A cell with the runs that it was judged from, coarse to fine."""

    question: Question
    cell: Cell
    records: tuple[Record, ...]
    truth: Truth | NoTruth | None  # None where the method cannot run the scene
    is_settled: bool  # else provisional: the truth is being refined


@dataclass(frozen=True, eq=False)
class _Sought:
    """The name of the task that makes a scene's certified truth."""

    scene: Scene

    def __str__(self) -> str:
        return f"truth of {self.scene.name}"


@dataclass(frozen=True, eq=False)
class Preparation:
    """What the questions to an engine wait for, such as the compilation of its code; others are answered meanwhile."""

    engine: str
    name: str
    work: Callable[[Caller], Any]

    def __str__(self) -> str:
        return self.name


type _Task = Question | Request | _Sought | Preparation


def questions(scenes: Sequence[Scene], offered: Sequence[tuple[str, Method | None]]) -> list[Question]:
    """Return a question for every scene and method offered."""
    return [Question(scene, *task) for scene in scenes for task in offered]


def answers(
    runs: Runs, requested: Sequence[Question], targets: Sequence[float] = TARGETS, progress: Report | None = None,
    patient: bool = True, preparations: Sequence[Preparation] = (),
) -> Iterator[Answer]:  # fmt: skip
    """Yield answers as they come; a later one to the same question replaces the earlier one.

    Runs use all processors, where `runs` computes them in processes of their own; answers are provisional first
    where the truth is what engines agree on. A method with a run that computes longer than BRIEF is answered after all
    others; unless `patient`, not at all. The questions to an engine begin once its `preparations` have ended. After
    `runs.time_left` no run is begun: every question is answered by the runs so far, and cells state what is missing.
    """
    settled, scenes, waited_for = 0, dict[int, _OfScene](), list(preparations)

    def tick(running: list[tuple[_Task, float]]) -> None:
        if progress is not None:
            progress(settled, len(requested), ", ".join(f"{name} ({seconds:.0f} s)" for name, seconds in running))

    with Pool[_Task, Any](runs.call, 0, BRIEF, runs.time_left, tick) as pool:
        for scene, group in groupby(requested, key=lambda question: id(question.scene)):
            scenes[scene] = _OfScene(pool, runs, targets, patient, waited_for)
            for answer in scenes[scene].begin(list(group)):
                settled += 1
                yield answer
        for task in preparations:
            pool.add(task, partial(_prepared, task), PREPARATION)
        for task, result in pool:
            if isinstance(task, Preparation):
                waited_for.remove(task)
                for of in scenes.values():
                    of.begin_searches(task.engine)
                continue
            of = scenes[id(task.scene)]
            if isinstance(task, Question):
                answer = of.receive(task, result)
                settled += answer is not None and answer.is_settled
                yield from filter(None, [answer])
            elif isinstance(task, Request):
                task.consensus.receive(task, result)
                of.follow(task.consensus)
            else:
                of.start(task.scene, result)  # type: ignore[arg-type] - a truth has all the time it takes
    tick([])


def _prepared(task: Preparation, call: Caller) -> None:
    """Prepare an engine. Where that fails its runs fail likewise, and their cells state why."""
    with suppress(Exception):
        task.work(call)


class _OfScene:
    """The truth of a scene and the searches against it."""

    def __init__(
        self, pool: Pool, runs: Runs, targets: Sequence[float], patient: bool, waited_for: Sequence[Preparation]
    ) -> None:
        self._pool, self._runs, self._targets, self._patient = pool, runs, targets, patient
        self._waited_for = waited_for  # of the engines that are not searched yet
        self._able: list[Question] = []
        self._busy: set[Question] = set()  # whose search waits or runs
        self._late: dict[Question, int] = {}  # tries that computed for too long
        self._truth: tuple[Truth | NoTruth, float, bool] | None = None  # known to, of the scene, and whether settled

    def begin(self, requested: Sequence[Question]) -> Iterator[Answer]:
        """Seek the truth; yield the answers that need none, of methods that cannot run the scene."""
        for question in requested:
            cell = refusal_of(question.scene, question.engine, question.method, self._targets)
            if cell is None:
                self._able.append(question)
            else:
                yield Answer(question, cell, (), None, True)
        if self._able:
            scene = self._able[0].scene
            self._pool.add(_Sought(scene), lambda call: replace(self._runs, call=call).truth(scene))

    def start(self, scene: Scene, truth: Truth | NoTruth) -> None:
        """Search against a certified truth; where there is none, begin a consensus."""
        if isinstance(truth, Truth):
            self._judge_by(truth, 0.0, True)
        else:
            enough = max(ENOUGH, min(self._targets) / ONE_FIGURE)
            self.follow(Consensus(self._pool, self._runs, scene, truth.reason, enough))

    def follow(self, consensus: Consensus) -> None:
        """Search against what engines agree on: once that is useful, and once it is settled."""
        known_to = np.inf if consensus.pair is None else consensus.pair.known_to
        if consensus.is_settled or (known_to <= USEFUL and self._truth is None):
            self._judge_by(consensus.truth, known_to, consensus.is_settled)

    def _judge_by(self, truth: Truth | NoTruth, known_to: float, is_settled: bool) -> None:
        self._truth = truth, known_to, is_settled
        for engine in dict.fromkeys(question.engine for question in self._able):
            self.begin_searches(engine)

    def begin_searches(self, engine: str) -> None:
        """Search every method of an engine that is prepared, once there is a truth."""
        if self._truth is None or any(one.engine == engine for one in self._waited_for):
            return
        for question in self._able:
            if question.engine == engine and question not in self._busy:
                self._search(question)

    def _search(self, question: Question) -> None:
        if question not in self._late or self._patient:
            self._busy.add(question)
            self._pool.add(question, partial(self._searched, question), SEARCH, self._late.get(question, 0))

    def _searched(self, question: Question, call: Caller) -> Answer:
        """Search and judge by the best truth there is when the task begins."""
        assert self._truth is not None
        (truth, known_to, is_settled), runs = self._truth, replace(self._runs, call=call)
        targets = self._targets if is_settled else sorted({max(one, ONE_FIGURE * known_to) for one in self._targets})
        result = judged(runs, question.scene, question.engine, question.method, truth, targets)
        return Answer(question, *result, truth, is_settled)

    def receive(self, question: Question, result: Answer | Late) -> Answer | None:
        """Return an answer; search again where it came too late, or the truth is better known by now."""
        assert self._truth is not None
        self._busy.remove(question)
        if isinstance(result, Late):
            self._late[question] = self._late.get(question, 0) + 1
        if self._truth[2] and (isinstance(result, Late) or not result.is_settled):
            self._search(question)
        return None if isinstance(result, Late) else result


def check(runs: Runs, scenes: Sequence[Scene], engines: Sequence[str] | None = None) -> list[Cell]:
    """Return the cell of every scene, engine and method. ValueError where an engine is unknown."""
    requested = questions(scenes, tasks(engines or registry.names()))
    settled = {answer.question: answer.cell for answer in answers(runs, requested)}
    return [settled[question] for question in requested]
