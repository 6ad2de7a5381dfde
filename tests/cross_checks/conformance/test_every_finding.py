"""A whole examination of made-up methods on made-up scenes: every finding and row follows from the random runs."""

from __future__ import annotations

import random
from statistics import median
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.conformance import examine, repeatability
from cross_checks.conformance import symmetry as violation
from cross_checks.conformance.apart import Apart, Called, Wrapped
from cross_checks.conformance.finding import Finding, Row
from cross_checks.conformance.questions import STEPS
from cross_checks.engine import Engine
from cross_checks.engine.method import Method, Refusal
from mbs_ref import scenes
from mbs_ref.scene.traits import traits
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Timing, Trajectory

SCENES = [scenes.make(name) for name in ("pendulum", "double_pendulum", "slider_crank", "n_four_bar", "kepler")]
LOOPS = frozenset({"closed-loop"})
METHODS = (
    Method("third", "fixed", 3, "of order 3", (0.1, 0.01)),
    Method("soft", "fixed", 2, "of order 2", (0.1,), wrong_limit="springs hold its loops", weak_on=LOOPS),
    Method("free", "adaptive", None, "of no order", (1e-3,)),
)


def ended(message: str = "", status: Status = Status.SUCCESS) -> Any:
    """Return a call whose run has two samples."""
    still = np.zeros((2, 1))
    path = Trajectory(np.arange(2.0), still[..., None], still, still[..., None], still, status=status, message=message)
    return SimpleNamespace(path=path)


@pytest.mark.parametrize("seed", range(12))
def test_an_examination(monkeypatch, seed):
    chance = random.Random(seed)
    questions: list[Any] = [SimpleNamespace(scene=scene, times=np.linspace(0.0, 1.0, 3)) for scene in SCENES]
    taken = {(m.name, s.name): chance.random() < 0.8 for m in METHODS for s in SCENES}
    rows, lost = {}, {}
    for m in METHODS:
        for s in SCENES:
            if taken[m.name, s.name]:
                order = chance.choice((None, (m.order or 3) + chance.uniform(-0.6, 0.6))) if m.order else None
                error = chance.choice((None, None, 10 ** chance.uniform(-9, 0)))
                rows[m.name, s.name] = Row(m.name, s.name, order, m.order, error, chance.random())
                if chance.random() < 0.2:
                    lost[m.name, s.name] = f"lost {m.name} {s.name}"
    engine: Any = object.__new__(Apart)
    engine.__dict__ |= {"name": "made", "package": "p", "lost": lost, "part_types": frozenset()}
    refused = {pair: [] if is_taken else [Refusal("no", True)] for pair, is_taken in taken.items()}
    monkeypatch.setattr(Apart, "methods", lambda self: METHODS)
    monkeypatch.setattr(Apart, "version", lambda self: "7")
    monkeypatch.setattr(Apart, "refusals", lambda self, scene: [])
    monkeypatch.setattr(Apart, "method_refusals", lambda self, scene, method: refused[method.name, scene.name])
    monkeypatch.setattr(examine, "questions", lambda given: [one for one in questions if given.able(one.scene)])
    monkeypatch.setattr(examine, "uncovered", lambda *given: ("belt",))
    monkeypatch.setattr(examine, "_whole", lambda *given: iter([Finding("identity", "", "", "passed")]))
    monkeypatch.setattr(examine, "called", lambda *given: ended("why", Status.TOO_MANY_STEPS))
    counted: list[tuple[str, float]] = []
    monkeypatch.setattr(examine, "uncounted_work", lambda given, question, settings: counted.append(
        (question.scene.name, settings.step or settings.rtol or 0.0)) or f"slow {question.scene.name}")  # fmt: skip
    monkeypatch.setattr(
        examine,
        "climb",
        lambda given, method, question: (
            [Finding("runs", method.name, question.scene.name, "passed")],
            rows[method.name, question.scene.name],
        ),
    )
    reported: list[str] = []
    report = examine.examine(engine, "made", reported.append)
    assert reported == [f"{s.name} by {m.name}" for m in METHODS for s in SCENES if taken[m.name, s.name]]
    assert (report.engine, report.version, report.uncovered) == ("made", "7", ("belt",))
    assert list(report.rows) == [rows[m.name, s.name] for m in METHODS for s in SCENES if taken[m.name, s.name]]
    of = {(f.question, f.method, f.scene): f for f in report.findings}
    assert len(of) == len(report.findings)
    assert of["identity", "", ""].outcome == "passed"
    for m in METHODS:
        mine = [s for s in SCENES if taken[m.name, s.name]]
        if mine:
            assert of.pop(("hopeless step", m.name, mine[0].name)).outcome == "passed"
            clock = of.pop(("clock", m.name, mine[0].name))
            assert (clock.outcome, clock.detail) == ("failed", f"slow {mine[0].name}")
        for s in mine:
            assert of.pop(("runs", m.name, s.name)).outcome == "passed"
            back = of.pop(("comes back", m.name, s.name))
            assert (back.outcome, back.detail) == (
                ("failed", lost[m.name, s.name]) if (m.name, s.name) in lost else ("passed", ""))  # fmt: skip
        strong = [rows[m.name, s.name].order for s in mine if not (m.weak_on & traits(s))]
        seen = [order for order in strong if order is not None]
        if m.order and seen:
            found, order = of.pop(("order", m.name, "")), median(seen)
            assert found.outcome == ("failed" if abs(order - m.order) > 0.35 else "passed")
            assert found.detail == f"order {order:.2f} observed over {len(seen)} scenes, {m.order} documented"
    for s in SCENES:
        able = [m for m in METHODS if taken[m.name, s.name]]
        if not able:  # it is not asked about
            continue
        found = of.pop(("something runs", "", s.name))
        is_exempt = all(m.weak_on & traits(s) for m in able)
        if any(rows[m.name, s.name].error is not None for m in able):
            assert found.outcome == "passed"
        else:
            assert (found.outcome, found.exemption) == (
                ("exempt", "springs hold its loops") if is_exempt else ("failed", ""))  # fmt: skip
    assert list(of) == [("identity", "", "")]
    coarse = {"third": 1.0 / 50, "soft": 1.0 / 50, "free": 1e-4}
    assert [size for _, size in counted] == [
        coarse[m.name] for m in METHODS if any(taken[m.name, s.name] for s in SCENES)]  # fmt: skip


class Refusing(Engine):
    """An engine that refuses every scene for its reasons, if it has any."""

    def __init__(self, *reasons: str) -> None:
        self.reasons = reasons

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def refusals(self, scene: Any) -> list[Refusal]:
        return [Refusal(reason, True) for reason in self.reasons]


@pytest.mark.parametrize("status", [Status.REFUSED, Status.SUCCESS, Status.INCONSISTENT])
@pytest.mark.parametrize("words", ["no ropes; no wings", "no ropes", ""])
def test_an_engine_refuses_with_all_its_reasons_and_names_what_it_cannot_start(monkeypatch, status, words):
    engine = Refusing("no ropes", "no wings")
    answer = ended(words, status)
    asked: list[Settings] = []
    monkeypatch.setattr(examine, "called", lambda engine, scene, chosen, times: asked.append(chosen) or answer)
    assert "with 2 samples" in examine._refusal(engine)
    answer.path = Trajectory(*(np.zeros((0, 1, 2)),) * 5, status=status, message=words)
    wrong = examine._refusal(engine)
    if status is not Status.REFUSED:
        assert wrong.startswith(f"a scene that it cannot model ends as {status}")
    else:
        missing = [one for one in ("no ropes", "no wings") if one not in words]
        assert wrong == (f"the refusal leaves out: {missing}" if missing else "")
    engine = Refusing()
    assert examine._refusal(engine) == ""
    is_named = status is Status.INCONSISTENT and bool(words)
    assert (examine._inconsistent(engine) == "") == is_named
    assert asked[-1].step == pytest.approx(examine.open_pendulum().duration / STEPS[-1])  # the finest
    assert examine._inconsistent(Refusing("it has no rods")) == ""


@pytest.mark.parametrize("seed", range(20))
def test_a_symmetry_is_broken_by_thirty_times_what_roundoff_does(seed):
    """Of a way back, what the method errs is allowed, too; a size of no more than 30 errors does not exceed them."""
    chance = random.Random(seed)
    noise, error, size = (10 ** chance.uniform(-3, 0) for _ in range(3))
    for name in violation.SYMMETRIES:
        found = violation.Violation(name, size, noise, error)
        allowed = 30.0 * (max(noise, error) if name == "there and back" else noise)
        assert found.is_broken == (size > allowed)
        assert found.exceeds_error == (size > allowed and size > 30.0 * error)
        assert not violation.Violation(name, None, noise, error, "why").is_broken


def test_the_clocks_of_a_call_are_its_own(monkeypatch):
    from cross_checks.conformance import apart

    for clock, times in (("perf_counter", (10.0, 17.0)), ("process_time", (1.0, 4.0))):
        monkeypatch.setattr(apart, clock, iter(times).__next__)
    path, settings = ended().path, Settings(rtol=1e-3)
    engine: Any = SimpleNamespace(run=lambda *given: path)
    found = apart.called(engine, SCENES[0], settings, None)
    assert (found.wall_s, found.cpu_s, found.path) == (7.0, 3.0, path)
    assert found.setting == "rtol=0.001"
    assert Called(Settings(step=0.25), path).setting == "step=0.25"


@pytest.mark.parametrize("seed", range(4))
def test_a_lost_run_is_named_and_its_method_is_not_tried_on_that_scene_again(seed):
    from cross_checks.isolation.parent import Lost

    chance, asked = random.Random(seed), []

    def ask(function: Any, name: str, scene: Any, settings: Settings, times: Any) -> Called:
        asked.append((settings.method, scene.name))
        if settings.method == "third":
            raise Lost("timeout", "gave no answer")
        return Called(settings, ended().path, 2.0, 1.0)

    engine: Any = SimpleNamespace(name="made", package="p", part_types=frozenset())
    apart, wanted = Apart(engine, ask), []
    for _ in range(12):
        scene, method = chance.choice(SCENES), chance.choice(("third", "soft"))
        wanted.append((method, scene.name))
        found = apart.call(scene, Settings(method=method, step=0.1), None)
        assert found.path.ok == (method == "soft")
        again = wanted.count((method, scene.name)) > 1
        assert found.path.message.startswith("not tried: before, step=0.1: gave no answer") == (
            again and method == "third")  # fmt: skip
        assert method == "soft" or found.path.unreported
    failing = [pair for pair in dict.fromkeys(wanted) if pair[0] == "third"]
    assert asked == [pair for k, pair in enumerate(wanted) if pair[0] == "soft" or pair not in wanted[:k]]
    assert apart.lost == dict.fromkeys(failing, "step=0.1: gave no answer")


def test_repeatability_counts_for_every_engine_in_its_turn(monkeypatch):
    """Cases of two engines come mixed; progress counts the rows that are there, and outcomes are those of the run."""
    made = [
        SimpleNamespace(name=f"{e}{k}", engine=e, method="m", scene=f"s{k}", setting="h")
        for k in range(2)
        for e in "ba"
    ]
    reported: list[tuple[int, int, str]] = []
    monkeypatch.setattr(repeatability, "_made", lambda cases, function, threads=1: {
        one.name: ("stops",) * 2 if function is repeatability.twice else "stops" for one in cases})  # fmt: skip
    rows = repeatability.measured(made, lambda *given: reported.append(given))  # type: ignore[arg-type]
    assert reported == [(0, 4, "b"), (2, 4, "a")]
    assert [(row["engine"], row["scene"], row["stopped"]) for row in rows] == [
        ("b", "s0", "stops"), ("b", "s1", "stops"), ("a", "s0", "stops"), ("a", "s1", "stops")]  # fmt: skip
    run = ended().path
    case: Any = SimpleNamespace(engine="e", built=lambda: None, settings=None)
    monkeypatch.setattr(repeatability.engines, "get", lambda name: SimpleNamespace(run=lambda *given: run))
    found = repeatability.outcome(case)
    assert isinstance(found, dict)
    assert {name.replace(" ", "_"): value.tolist() for name, value in found.items()} == {
        name: getattr(run, name).tolist()
        for name in ("times", "position", "orientation", "velocity", "angular_velocity")
    }
    assert Timing().loop_s == 0.0


def test_a_wrapped_engine_answers_as_the_one_inside():
    inner: Any = SimpleNamespace(
        name="toy", package="toy-package", part_types=frozenset({"weld"}), methods=lambda: ("m",), version=lambda: "7",
        refusals=lambda scene: [f"no {scene}"], method_refusals=lambda scene, method: [f"{method} no {scene}"],
        run=lambda *given: given,
    )  # fmt: skip
    made: Any = Wrapped(inner)
    assert (made.name, made.package, made.part_types) == ("toy", "toy-package", {"weld"})
    assert (made.methods(), made.version()) == (("m",), "7")
    assert (made.refusals("scene"), made.method_refusals("scene", "m")) == (["no scene"], ["m no scene"])
    assert made.run("scene", "settings", "times") == ("scene", "settings", "times")
