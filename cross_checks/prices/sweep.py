"""Work against precision: the settings that meet a row of target errors, each with its loop timed alone."""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import nullcontext

from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Isolated
from cross_checks.isolation.workers import Report
from cross_checks.judge.answers import Answer, Question, answers, questions
from cross_checks.judge.cell import tasks
from cross_checks.judge.one_run import without_run
from cross_checks.judge.runs import Runs
from cross_checks.prices.timing import timed
from cross_checks.records.record import Record
from mbs_ref import Scene, Settings

DECADES = tuple(10.0**-k for k in range(2, 11))  # targets of a sweep, over the scene's scales
Worth = Callable[[Sequence[Record]], Collection[Record]]  # those of all runs that are timed


def sweep(
    runs: Runs, scene: Scene, engines: Collection[str] | None = None, methods: Collection[str] | None = None,
    progress: Report = lambda done, total, what: None, targets: Sequence[float] = DECADES,
    seen: Callable[[list[Record]], None] = lambda records: None, worth: Worth | None = None,
) -> Iterator[Record]:  # fmt: skip
    """Yield every run of every method's search for the targets, judged and timed, coarse to fine.

    Runs use all processors, or those of a cluster, where `runs` executes them in processes of their own, and
    then timed one at a time on this machine.
    `seen` receives all runs so far, not timed yet. With `worth` only those are timed that it returns, and slow methods
    are left out where it returns any. Without a certified truth, errors are from what engines agree on. ValueError
    where an engine or a method is unknown.
    """
    wanted = questions([scene], _offered(engines, methods))
    result: dict[Question, list[Record]] = {}
    settled: set[Question] = set()  # answered by the settled truth; what a rougher one answered counts no more
    for patient in (worth is None, True):
        for answer in answers(runs, wanted, targets, progress, patient):
            result[answer.question] = _records(answer)
            settled |= {answer.question} if answer.is_settled else set()
            seen([record for question in wanted for record in result.get(question, [])])
        records = [record for question in wanted if question in settled for record in result[question]]
        chosen = [id(record) for record in (records if worth is None else worth(records))]
        if patient or chosen:
            break
    with runs.call.here() if isinstance(runs.call, Isolated) else nullcontext(runs.call) as call:
        for number, record in enumerate(records):
            progress(number, len(records), f"timing {record.engine} {record.method}")
            yield timed(runs.store, call, scene, record) if id(record) in chosen else record


def _offered(engines: Collection[str] | None, methods: Collection[str] | None) -> list[tuple[str, Method | None]]:
    offered = tasks(registry.names() if engines is None else engines)
    unknown = sorted(set(methods or ()) - {method.name for _, method in offered if method is not None})
    if unknown:
        raise ValueError(f"method = {', '.join(unknown)} is offered by none of the engines")
    return [(engine, method) for engine, method in offered if methods is None or (method and method.name in methods)]


def _records(answer: Answer) -> list[Record]:
    """Return the runs of an answer; where the method cannot run, a record that states why."""
    cell, scene = answer.cell, answer.question.scene
    status = str(cell.verdict)
    refused = without_run(scene, cell.engine, Settings(method=cell.method or None), status, cell.reason)
    return list(answer.records) or [refused]
