"""The examination of an engine: who it is, what it refuses, how it fails, and every method on every quick scene."""

from collections.abc import Callable, Iterator
from statistics import median

import numpy as np

from cross_checks.conformance.apart import Apart, called
from cross_checks.conformance.clock import uncounted_work
from cross_checks.conformance.finding import Finding, Report, Row, verdict
from cross_checks.conformance.ladder import climb
from cross_checks.conformance.questions import Question, impossible, open_pendulum, questions, rungs, uncovered
from cross_checks.engine import Engine
from cross_checks.engine.method import Method
from mbs_ref import Settings, Status

ENGINE_WIDE = ""  # the method or scene of what concerns the whole engine
QUESTIONS = (
    "identity", "something runs", "refusals", "unknown method", "inconsistent start", "hopeless step", "comes back",
    "runs", "asked times", "start", "velocities", "clock", "truth", "energy", "joints", "contact", "same end", "order",
)  # fmt: skip
ORDER_OFF = 0.35  # how far an observed order may be from the documented one
Progress = Callable[[str], None]


def examine(engine: Engine, name: str, progress: Progress = lambda text: None) -> Report:
    """Ask everything of the engine that is known by `name`."""
    questioned = questions(engine)
    findings, rows = [*_whole(engine, name, questioned)], []
    for method in engine.methods():
        mine = [question for question in questioned if not engine.refusal(question.scene, method)]
        if mine:
            findings.append(_hopeless(engine, method, mine[0]))
            clock = uncounted_work(engine, mine[0], rungs(method, mine[0].times)[0])
            findings.append(verdict("clock", method.name, mine[0].scene.name, clock))
        for question in mine:
            progress(f"{question.scene.name} by {method.name}")
            of_scene, row = climb(engine, method, question)
            findings += of_scene
            rows.append(row)
        strong = {question.scene.name for question in mine if not method.exemption(question.scene)}
        findings += _order(method, [row for row in rows if row.method == method.name and row.scene in strong])
        findings += _lost(engine, method, mine)
    findings += [_runs(engine, question, rows) for question in questioned]
    return Report(engine.name, engine.version(), tuple(findings), tuple(rows), uncovered(engine, questioned))


def _whole(engine: Engine, name: str, questioned: list[Question]) -> Iterator[Finding]:
    def finding(question: str, wrong: str) -> Finding:
        return verdict(question, ENGINE_WIDE, ENGINE_WIDE, wrong)

    yield finding("identity", _identity(engine, name))
    yield finding("something runs", "" if questioned else "it refuses every scene with a known truth")
    yield finding("refusals", _refusal(engine))
    if questioned:
        yield finding("unknown method", _unknown_method(engine, questioned[0]))
    yield finding("inconsistent start", _inconsistent(engine))


def _runs(engine: Engine, question: Question, rows: list[Row]) -> Finding:
    """Judge whether one of the methods at least ends a run of a scene that the engine takes."""
    scene = question.scene
    ended = any(row.scene == scene.name and row.error is not None for row in rows)
    exemptions = [method.exemption(scene) for method in engine.able(scene)]
    wrong = "" if ended else "it takes the scene, and none of its methods ends a run"
    return verdict("something runs", ENGINE_WIDE, scene.name, wrong, exemption=exemptions[0] if all(exemptions) else "")


def _identity(engine: Engine, name: str) -> str:
    methods = engine.methods()
    wrong = []
    if engine.name != name:
        wrong.append(f"its name is {engine.name!r}, and its file or entry point says {name!r}")
    if not engine.package or not engine.version():
        wrong.append("it has no package or no version")
    if not methods or len({m.name for m in methods}) < len(methods):
        wrong.append("it has no method, or two of one name")
    wrong += [f"{m.name} has no description" for m in methods if not m.description]
    unsorted = [m.name for m in methods if list(m.ladder) != sorted(m.ladder, reverse=True)]
    wrong += [f"the ladder of {name} must go from coarse to fine" for name in unsorted]
    return "; ".join(wrong)


def _refusal(engine: Engine) -> str:
    scene = impossible()
    reasons = [refusal.reason for refusal in engine.refusals(scene)]
    if not reasons:
        return ""
    result = called(engine, scene, Settings(), None).path
    if result.status is not Status.REFUSED or len(result.times):
        return f"a scene that it cannot model ends as {result.status} with {len(result.times)} samples"
    missing = [reason for reason in reasons if reason not in result.message]
    return f"the refusal leaves out: {missing}" if missing else ""


def _unknown_method(engine: Engine, question: Question) -> str:
    try:
        engine.run(question.scene, Settings(method="no_such_method"))
    except ValueError as error:
        return "" if "no_such_method" in str(error) else f"the error does not name the method: {error}"
    return "an unknown method is accepted"


def _inconsistent(engine: Engine) -> str:
    scene = open_pendulum()
    method = next(iter(engine.able(scene)), None)
    if method is None:
        return ""
    result = called(engine, scene, rungs(method, np.array([0.0, scene.duration]))[-1], None).path
    named = result.status is Status.INCONSISTENT and result.message
    return "" if named else "a velocity along the rod is accepted or changed without a word"


def _hopeless(engine: Engine, method: Method, question: Question) -> Finding:
    """Absurd accuracy must end in a status, a refusal or finite poses; a NaN or a lost clock is not success."""
    scene, times = question.scene, np.array([0.0, 0.5, 1.0]) * question.scene.duration
    half = scene.duration / 2
    loose = {"step": half} if method.kind == "fixed" else {"rtol": 1e-2}
    wrong = ""
    try:
        settings = Settings.model_validate({"method": method.name, "estimate": "off", **loose})
        result = called(engine, scene, settings, times).path
    except ValueError:  # it refuses the setting, aloud
        return verdict("hopeless step", method.name, scene.name, "")
    if result.ok and not (np.isfinite(result.position).all() and np.array_equal(result.times, times)):
        wrong = "it reports success with poses that are no numbers, or at other times"
    if not result.ok and not result.message:
        wrong = f"it ends as {result.status} without a sentence"
    return verdict("hopeless step", method.name, scene.name, wrong)


def _lost(engine: Engine, method: Method, questioned: list[Question]) -> list[Finding]:
    """Judge whether every run came back, in time and with its process alive."""
    lost = engine.lost if isinstance(engine, Apart) else {}
    names = [question.scene.name for question in questioned]
    return [verdict("comes back", method.name, name, lost.get((method.name, name), "")) for name in names]


def _order(method: Method, rows: list[Row]) -> list[Finding]:
    """Judge the median over the smooth scenes: one alone may be better or worse than the method by its symmetry."""
    seen = [row.order for row in rows if row.order is not None]
    if method.order is None or not seen:
        return []
    order = median(seen)
    text = f"order {order:.2f} observed over {len(seen)} scenes, {method.order} documented"
    wrong = text if abs(order - method.order) > ORDER_OFF else ""
    return [verdict("order", method.name, ENGINE_WIDE, wrong, seen=text)]
