"""What an examination states of runs, computed again from made-up runs and rows."""

from __future__ import annotations

import os
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.conformance import clock, examine, ladder, loading, questions, repeatability
from cross_checks.conformance.apart import Apart, Called
from cross_checks.conformance.cases import LABORATORY, LOOSER, RELATIVE, SKY, SKY_STEPS, STEP, cases
from cross_checks.conformance.finding import Finding, Report, Row, verdict
from cross_checks.conformance.probes import LAWS, bounces
from cross_checks.conformance.questions import SAMPLES, SPANS, STEPS, Question
from cross_checks.conformance.repeatability import WAYS, by_method, difference
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Timing, Trajectory

SCENE = scenes.make("double_pendulum", length_1=0.7, length_2=2.9)
METHODS = {method.name: method for method in engines.get("mbs_ref").methods()}
RK4, DOP853, GAUSS = METHODS["rk4"], METHODS["dop853"], METHODS["gauss"]


def motion(rng: np.random.Generator, n: int = 9, **more: Any) -> Trajectory:
    times = np.linspace(0.0, 1.0, n)
    return Trajectory(times, rng.normal(size=(n, 2, 2)), rng.normal(size=(n, 2)), rng.normal(size=(n, 2, 2)),
                      rng.normal(size=(n, 2)), **more)  # fmt: skip


def runs(errors: list[float], loops: list[float]) -> ladder._Rungs:
    """Return runs whose places are off by so much, and their truth."""
    true = motion(np.random.default_rng(1))
    truth = Truth(true.position, true.orientation, 0.0, "exact", "", velocity=true.velocity,
                  angular_velocity=true.angular_velocity, rate_uncertainty=np.zeros(9))  # fmt: skip
    made = []
    for k, (error, loop) in enumerate(zip(errors, loops, strict=True)):
        off = np.zeros((9, 2, 2))
        off[4, 1, 0] = error * scales_of(SCENE).length
        path = Trajectory(true.times, true.position + off, true.orientation, true.velocity, true.angular_velocity,
                          steps=50 * 2**k, timing=Timing(loop_s=loop))  # fmt: skip
        made.append(Called(Settings(method="rk4", step=0.1 / 2**k), path))
    return ladder._Rungs(RK4, Question(SCENE, true.times, truth), tuple(made))


def test_the_row_of_a_ladder_is_that_of_its_best_run():
    rising = runs([1e-2, 3e-5, 4e-4], [0.1, 0.7, 0.2])
    assert rising.errors == pytest.approx([1e-2, 3e-5, 4e-4])
    row = rising.row()
    assert (row.method, row.scene, row.documented) == ("rk4", SCENE.name, 4)
    assert (row.error, row.loop_s) == (pytest.approx(3e-5), 0.7)
    falling = runs([1e-3 / 16**k for k in range(4)], [1.0] * 4)
    assert falling.row().order == pytest.approx(4.0, abs=0.1)
    empty = ladder._Rungs(RK4, rising.question, ())
    assert (empty.row().error, empty.row().loop_s, empty.row().order) == (None, None, None)


def test_a_deviation_that_stays_is_stated_and_one_that_vanishes_or_is_small_is_not():
    rising = runs([1e-3 / 16**k for k in range(4)], [1.0] * 4)
    stays = [np.full(3, 1e-3 * (1.0 + 0.0625**k)) for k in range(4)]
    text = rising.deviation("joints open by", stays, 1e-8)
    assert text.startswith("joints open by 2.0e-03 1.1e-03 1.0e-03 1.0e-03, coarse to fine, ")
    assert not rising.deviation("x", [curve * 16.0**-k for k, curve in enumerate(stays)], 1e-8)
    assert not rising.deviation("x", stays, 1.01e-3)
    assert not rising.deviation("x", stays, float(np.abs(stays[-1]).max()))
    assert not rising.deviation("x", [*stays[:-1], None], 1e-8)
    assert ladder._peak(np.array([1.0, -3.0, 2.0])) == 3.0


@pytest.mark.parametrize(("errors", "is_explained"), [
    ([9e-3, 4.5e-3, 4e-3], True), ([4.5e-3, 9e-3, 4e-3], True), ([4.5e-3, 4.4e-3, 4e-3], False),
    ([9e-3, 4.5e-3, 4.4e-3, 4e-3], False), ([4e-3, 4e-3, 9e-4], True), ([0.5, 0.4, 0.2], False),
])  # fmt: skip
def test_contacts_may_be_off_by_twice_the_way_from_the_two_runs_before(errors, is_explained):
    """Runs before those do not count, an error within the first target needs no reason, and a large one has none."""
    found = ladder._contact(runs(errors, [1.0] * len(errors)))
    assert bool(found) != is_explained
    assert is_explained or f"as they must: error {errors[-1]:.1e} of the scene" in found


@pytest.mark.parametrize("order", [3.6, 3.7, 4.3, 4.4])
def test_an_order_far_from_the_documented_one_is_wrong_either_way(order):
    (found,) = examine._order(RK4, [Row("rk4", str(k), x, 4, 1.0, 1.0) for k, x in enumerate((order, None, order))])
    assert found.outcome == ("passed" if 3.65 <= order <= 4.35 else "failed")
    assert found.detail == f"order {order:.2f} observed over 2 scenes, 4 documented"


def test_an_engine_is_called_by_its_name_and_its_ladders_fall():
    method = SimpleNamespace(name="m", description="d", ladder=(1e-1, 1e-2))
    good: Any = SimpleNamespace(name="a", package="p", version=lambda: "1", methods=lambda: (method,))
    assert examine._identity(good, "a") == ""
    assert "its name is 'a'" in examine._identity(good, "b")
    for bad, words in (({"ladder": (1e-2, 1e-1)}, "the ladder of m must go from coarse to fine"),
                       ({"description": ""}, "m has no description")):  # fmt: skip
        method_2 = SimpleNamespace(**{**vars(method), **bad})
        assert words == examine._identity(SimpleNamespace(**{**vars(good), "methods": lambda m=method_2: (m,)}), "a")
    twice = SimpleNamespace(**{**vars(good), "methods": lambda: (method, method)})
    assert "two of one name" in examine._identity(twice, "a")  # type: ignore[arg-type]
    for lacking in ({"package": ""}, {"version": lambda: ""}):
        assert "no package" in examine._identity(SimpleNamespace(**{**vars(good), **lacking}), "a")  # type: ignore[arg-type]


def test_findings_are_sorted_by_outcome_and_exempt_ones_do_not_fail():
    found = [verdict("q", "m", "s", wrong, seen="seen", exemption=exemption)
             for wrong, exemption in (("", ""), ("", "weak"), ("bad", "weak"), ("bad", ""))]  # fmt: skip
    assert [(f.outcome, f.detail, f.exemption) for f in found] == [
        ("passed", "seen", ""), ("passed", "seen", ""), ("exempt", "bad", "weak"), ("failed", "bad", "")]  # fmt: skip
    assert found[0] == Finding("q", "m", "s", "passed", "seen")
    reports = [Report("e", "1", tuple(found[:k]), ()) for k in (3, 4)]
    assert [report.conforms for report in reports] == [True, False]
    assert reports[1].to_dict()["conforms"] is False
    assert [len(reports[1].of(word)) for word in ("passed", "exempt", "failed")] == [2, 1, 1]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("status", "message", "bad", "wrong"),
    [(Status.SUCCESS, "", None, ""), (Status.SUCCESS, "", "position", "no numbers"),
     (Status.SUCCESS, "", "times", "other times"),
     (Status.TOO_MANY_STEPS, "why", None, ""), (Status.TOO_MANY_STEPS, "", None, "without a sentence")],
)  # fmt: skip
def test_a_hopeless_step_must_not_end_in_silence(monkeypatch, status, message, bad, wrong):
    seen: list[Settings] = []

    def called(engine, scene, settings, times):
        seen.append(settings)
        path = motion(np.random.default_rng(2), 3, status=status, message=message)
        given = {"times": np.array(times), "position": path.position}
        if bad:
            given[bad] = given[bad] + (np.nan if bad == "position" else 1e-9)
        return SimpleNamespace(path=Trajectory(given["times"], given["position"], path.orientation, path.velocity,
                                               path.angular_velocity, status=status, message=message))  # fmt: skip

    monkeypatch.setattr(examine, "called", called)
    question: Any = SimpleNamespace(scene=SCENE)
    found = [examine._hopeless(None, method, question) for method in (RK4, DOP853)]  # type: ignore[arg-type]
    assert all((one.outcome == "passed") == (not wrong) and wrong in one.detail for one in found)
    assert (seen[0].step, seen[1].rtol) == (SCENE.duration / 2.0, 1e-2)


def test_joints_open_over_the_scenes_length():
    path = motion(np.random.default_rng(3))
    found = ladder.joint_gaps(SCENE, path)
    assert found is not None
    assert found * scales_of(SCENE).length == pytest.approx(constraint_residual(SCENE, path))
    assert scales_of(SCENE).length != 1.0
    assert ladder.joint_gaps(scenes.make("kepler"), path) is None


def test_slopes_of_a_known_motion_and_of_a_wrong_one():
    times = np.linspace(0.0, 1.0, 61)
    turn = np.stack((np.sin(3.0 * times), 0.5 * np.cos(2.0 * times)), axis=1)
    spin = np.stack((3.0 * np.cos(3.0 * times), -np.sin(2.0 * times)), axis=1)
    place, speed = turn[..., None] * (0.4, 0.3), spin[..., None] * (0.4, 0.3)
    misses, sure = ladder.slope_misses(SCENE, Trajectory(times, place, turn, speed, spin), 1e-16)
    assert np.abs(misses).max() < 1e-6
    assert sure < 1e-5
    length = scales_of(SCENE).length
    fastest = max(np.abs(spin).max(), np.abs(speed).max() / length)
    for off, size in ((speed + 0.1, 0.1 / length), (speed, 0.0)):
        misses, _ = ladder.slope_misses(SCENE, Trajectory(times, place, turn, off, spin), 1e-16)
        assert ladder.typical(misses) == pytest.approx(size / fastest, rel=0.1, abs=1e-6)
    _, rough = ladder.slope_misses(SCENE, Trajectory(times, place, turn, speed, spin), 1e-7)
    assert rough == pytest.approx(1e-7 * 1.0 * 60.0 / fastest, rel=0.2)
    assert len(misses) == 61 - 2 * ladder.EDGE
    assert ladder.typical(np.array([[1.0, -5.0], [2.0, 0.0], [3.0, 0.0]])) == 3.0


def test_every_method_is_asked_for_repeatability_at_its_own_setting():
    found = list(cases(["mbs_ref"]))
    assert {case.method for case in found} == METHODS.keys()
    stated = {"laboratory": LABORATORY, "sky": SKY, "relative": RELATIVE}
    ends = {(group, scene, str(parameters)): t_end for group, own in stated.items() for scene, parameters, t_end in own}
    for case in found:
        groups = [g for g in stated if (g, case.scene, str(case.parameters)) in ends]
        end = ends[groups[0], case.scene, str(case.parameters)] or case.built().duration
        settings, method = case.settings, METHODS[case.method]
        assert settings.t_end == end
        assert settings.method == case.method
        if method.kind == "fixed":
            assert settings.step == (STEP if groups[0] == "laboratory" else end / SKY_STEPS)
            assert case.setting == f"step {settings.step:.3g} s"
        else:
            assert settings.rtol == LOOSER * method.ladder[-1]
            assert case.setting == f"rtol {settings.rtol:.3g}"
        assert case.name.startswith(f"mbs_ref-{case.method}-{case.scene}")
    relative = {case.method for case in found if (case.scene, case.parameters) in [(s, p) for s, p, _ in RELATIVE]}
    assert relative == {"gauss"}


def test_each_way_runs_the_cases_it_is_named_after(monkeypatch):
    made = [SimpleNamespace(name=str(k), engine="e", method="m", scene=str(k), setting="s") for k in range(3)]
    asked: list[tuple[Any, ...]] = []

    def outcomes(cases, function, threads=1):
        asked.append(([case.name for case in cases], function, threads))
        plain = {case.name: {"x": np.array([float(case.name) + len(asked)])} for case in cases}
        return {k: (v, v) for k, v in plain.items()} if function is repeatability.twice else plain

    monkeypatch.setattr(repeatability, "_made", outcomes)
    rows = repeatability.measured(made)  # type: ignore[arg-type]
    names = ["0", "1", "2"]
    assert asked == [(names, repeatability.twice, 1), (names, repeatability.outcome, 1),
                     (names[::-1], repeatability.outcome, 1), (names, repeatability.outcome, 2)]  # fmt: skip
    assert [[row["differs"][way] for way in WAYS] for row in rows] == [
        pytest.approx([0.0, 1.0 / (k + 1.0), 2.0 / (k + 1.0), 3.0 / (k + 1.0)]) for k in range(3)]  # fmt: skip


def test_what_differs_is_counted_and_the_largest_shown():
    one = {"a": np.array([1.0, -4.0]), "b": np.array([0.0])}
    assert difference(one, {"a": np.array([1.0, -3.0]), "b": np.array([0.0])}) == 0.25
    assert difference(one, {"a": np.array([1.0, -4.0]), "b": np.array([-0.0])}) == float(np.finfo(float).tiny)
    assert difference(one, {"a": np.array([1.0]), "b": np.array([0.0])}) is None
    assert difference("same", "same") == 0.0
    assert difference(one, "lost") is None
    given = ("m", "", 0.0), ("m", "", 0.5), ("m", "", None), ("m", "stops", 9.0), ("n", "", 0.1)
    rows = [{"engine": "e", "method": m, "stopped": s, "differs": dict.fromkeys(WAYS, x) if not s else {}}
            for m, s, x in given]  # fmt: skip
    first, second = by_method(rows)
    assert (first["method"], first["runs"], second["runs"]) == ("m", 3, 1)
    assert first["ways"][1] == {"way": WAYS[1], "differ": 2, "largest": 0.5, "other_end": 1}
    assert second["ways"][0]["largest"] == 0.1


def test_settings_and_spans_of_an_examination():
    times = np.linspace(0.0, 2.0, SAMPLES)
    shared = {"estimate": "off", "refuse_unstable": False}
    assert questions.rungs(RK4, times) == [Settings(method="rk4", step=2.0 / n, **shared) for n in STEPS]
    assert questions.rungs(DOP853, times) == [
        Settings(method="dop853", rtol=rtol, estimate="off") for rtol in questions.RTOLS]  # fmt: skip
    for method in (*METHODS.values(), replace(DOP853, locates_events=False)):
        few = method.kind == "adaptive" and not method.locates_events
        assert len(questions.rungs(method, times, jumps=True)) == (2 if few else 4)
    question = questions.question_of("pendulum")
    assert question
    assert (len(question.times), question.times[-1]) == (SAMPLES, SPANS["pendulum"])


@pytest.mark.parametrize("share", [0.45, 0.5, 0.55, 0.65, 0.7])
def test_a_clock_must_report_six_tenths(share):
    def call(work: float) -> Called:
        path = motion(np.random.default_rng(1), timing=Timing(build_s=1.0, loop_s=share * work))
        return Called(Settings(), path, wall_s=1.0 + work, cpu_s=1.0 + work)

    assert clock._leaves_out(call(0.1), call(1.0)) == (share < 0.6)


def test_times_must_fit_into_their_call():
    def seen(build: float, first: float, loop: float, wall: float, steps: int = 1, calls: int = 1) -> str:
        timing = Timing(build_s=build, first_call_s=first, loop_s=loop)
        path = motion(np.random.default_rng(1), timing=timing, steps=steps, rhs_calls=calls)
        return clock.impossible_time([Called(Settings(step=0.1), path, wall_s=wall)])

    assert not seen(0.3, 0.3, 0.4, 1.0)
    assert all(
        "are reported of a call" in seen(*parts, 1.0) for parts in ((0.8, 0.1, 0.2), (0.1, 0.8, 0.2), (0.1, 0.2, 0.8))
    )
    assert not seen(0.0, 0.0, 1e-3, 1.0, steps=100_000)
    assert "beyond any processor" in seen(0.0, 0.0, 1e-3, 1.0, steps=300_000)
    assert "beyond any processor" in seen(0.0, 0.0, 1e-3, 1.0, calls=300_000)
    assert "not timed" in seen(0.0, 0.0, 0.0, 1.0)


def test_every_law_bounces_in_the_plane_and_all_but_those_that_hold_in_space():
    found = list(bounces())
    kinds = [(kind, scene.dimension) for kind, scene in found]
    assert len(set(kinds)) == len(kinds)
    assert {kind for kind, dimension in kinds if dimension == 2} >= {law.type for law in LAWS}
    assert {kind for kind, dimension in kinds if dimension == 3} >= {law.type for law in LAWS if not law.HOLDS}
    for _, scene in found:
        body = scene.bodies[0]
        radius = getattr(scene.contacts[0], "radius", None) or scene.contacts[0].radius_a  # type: ignore[union-attr]
        assert body.gyration_radius == pytest.approx(radius * 0.4**0.5)


def test_an_adapter_is_announced_once_beside_those_before(monkeypatch, tmp_path):
    files = [tmp_path / name for name in ("a_.py", "b_.py")]
    monkeypatch.setenv(engines.ADAPTERS, "")
    for file in (*files, files[0]):
        file.write_text("")
        loading.announce(file)
    assert os.environ[engines.ADAPTERS] == os.pathsep.join(map(str, files))


def test_runs_that_were_lost_are_named_by_method_and_scene():
    engine = Apart(engines.get("mbs_ref"), None)  # type: ignore[arg-type]
    engine.lost["rk4", "b"] = "it hangs"
    asked: Any = [SimpleNamespace(scene=SimpleNamespace(name=name)) for name in "ab"]
    found = examine._lost(engine, RK4, asked)
    assert [(one.scene, one.outcome, one.detail) for one in found] == [("a", "passed", ""), ("b", "failed", "it hangs")]


def test_a_wrapped_engine_is_the_inner_one():
    inner = engines.get("mbs_ref")
    outer = Apart(inner, None)  # type: ignore[arg-type]
    for name in ("name", "package", "part_types"):
        assert getattr(outer, name) == getattr(inner, name)
    assert (outer.methods(), outer.version()) == (inner.methods(), inner.version())
    assert outer.refusals(SCENE) == inner.refusals(SCENE)
    assert outer.method_refusals(SCENE, RK4) == inner.method_refusals(SCENE, RK4)
