"""Figures of an examination on runs and rows whose figures are known."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import asdict, replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks import engines
from cross_checks.conformance import broken_engines, ladder, repeatability, symmetry
from cross_checks.conformance.apart import Called
from cross_checks.conformance.broken_engines import _moved_inertia, _taken, self_test
from cross_checks.conformance.cases import Case
from cross_checks.conformance.examine import _order
from cross_checks.conformance.finding import Row
from cross_checks.conformance.ladder import _Rungs, climb, energy_drift
from cross_checks.conformance.probes import _turning, probe_truth, probes
from cross_checks.conformance.questions import Question
from cross_checks.conformance.repeatability import WAYS, by_method, difference, outcome
from cross_checks.isolation.parent import Lost
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import POSES, Status, Trajectory

RK4 = next(method for method in engines.get("mbs_ref").methods() if method.name == "rk4")


@pytest.mark.parametrize(("orders", "outcome"), [((3.9, 4.1, 1.0), "passed"), ((1.0, 1.1, 4.0), "failed")])
def test_the_median_order_counts(orders, outcome):
    rows = [Row("rk4", f"scene {k}", order, 4, 1e-6, 1.0) for k, order in enumerate(orders)]
    (finding,) = _order(RK4, rows)
    assert finding.outcome == outcome
    assert f"order {sorted(orders)[1]:.2f} observed" in finding.detail


def test_energy_counts_over_the_largest_kinetic_energy():
    """A free body of 3 kg is speeded up from 1 to 2 m/s: 4.5 J of 6 J."""
    body = PlanarBody(name="a", mass=3.0, inertia=1.0, position=(0.0, 0.0), velocity=(1.0, 0.0))
    scene = Scene(name="free", bodies=(body,), gravity=(0.0, 0.0), duration=2.0)
    still, speed = np.zeros((3, 1)), np.array([1.0, 2.0, 1.5])[:, None, None] * (1.0, 0.0)
    drift = energy_drift(scene, Trajectory(np.arange(3.0), 0.0 * speed, still, speed, still))
    assert drift == pytest.approx([0.0, 0.75, 1.875 / 6.0])


def test_a_row_shows_the_best_run():
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 41)
    truth = seek_truth(scene, times)
    assert isinstance(truth, Truth)
    found, row = climb(engines.get("mbs_ref"), RK4, Question(scene, times, truth))
    assert row.error is not None
    assert row.error < 1e-9
    seen = {one.question: one.detail for one in found if one.outcome == "passed"}
    assert seen["truth"] == seen["energy"] == seen["joints"] == f"error {row.error:.1e}"
    assert seen["runs"] == seen["start"] == seen["clock"] == ""


@pytest.mark.parametrize(("kind", "dimension"), [("force", 2), ("circle_on_circle", 2), ("sphere_on_sphere", 3)])
def test_the_truth_of_a_probe_is_the_solvers_motion(kind, dimension):
    scene = probes()[kind, dimension]
    run = simulate(scene, Settings(rtol=1e-10, estimate="off", samples=61))
    truth = probe_truth(scene, run.times)
    assert np.abs(run.position - truth.position).max() < 1e-8


def test_runs_that_end_otherwise_differ_and_equal_ones_by_nothing():
    assert difference("it stopped", "it crashed") is None
    rows = [{"engine": "a", "method": "b", "stopped": "", "differs": dict.fromkeys(WAYS, x)} for x in (0.0, 0.0)]
    assert [way["largest"] for way in by_method(rows)[0]["ways"]] == [0.0] * len(WAYS)


def test_adaptive_methods_show_no_order_and_an_unknown_distance_is_infinite():
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 41)
    truth = seek_truth(scene, times)
    assert isinstance(truth, Truth)
    settings = [Settings(method="rk4", step=step, estimate="off") for step in (0.02, 0.01, 0.005)]
    question, runs = Question(scene, times, truth), tuple(Called(one, simulate(scene, one, times)) for one in settings)
    fixed, adaptive = (_Rungs(method, question, runs) for method in (RK4, replace(RK4, kind="adaptive")))
    assert fixed.row().order == pytest.approx(4.0, abs=0.3)
    vars(adaptive)["shown"] = SimpleNamespace(observed_order=4.0)
    assert adaptive.row().order is None
    vars(adaptive)["errors"] = [3e-3, 1e-3, 2e-3]
    assert adaptive.row().error == 1e-3
    nothing = _taken(runs[0].path, slice(0))
    assert _Rungs(RK4, question, (replace(runs[0], path=nothing),)).errors == [np.inf]


def test_a_sample_that_is_taken_is_taken_of_every_array():
    rng = np.random.default_rng(0)
    path = Trajectory(np.arange(5.0), *(rng.normal(size=shape) for shape in ((5, 2, 2), (5, 2), (5, 2, 2), (5, 2))))
    for part in POSES:
        assert np.array_equal(getattr(_taken(path, [3, 0, 1]), part), getattr(path, part)[[3, 0, 1]])


def test_a_failure_without_a_mistake_is_a_false_alarm():
    first, *others = self_test(engines.get("mbs_ref"), lambda engine, name: SimpleNamespace(of=lambda word: ()))  # type: ignore[arg-type,return-value]
    assert not first.applies
    assert all(one.applies for one in others)


def test_repeatability_lists_the_cases_of_every_engine(monkeypatch):
    cases: list[Any] = [SimpleNamespace(engine=engine, name=k) for k, engine in enumerate("abacb")]
    monkeypatch.setattr(repeatability, "_of_engine", lambda own: [{"case": case.name} for case in own])
    assert [row["case"] for row in repeatability.measured(cases)] == [0, 2, 1, 4, 3]


@pytest.mark.parametrize("threads", [1, 2])
def test_cases_are_run_one_after_the_other_in_one_process_and_a_lost_one_is_named(monkeypatch, threads):
    asked: list[Any] = []

    def call(function: Any, case: Any) -> str:
        asked.append((function, case.name))
        if case.name == 1:
            raise Lost("timeout", "gave no answer")
        return f"ran {case.name}"

    monkeypatch.setattr(repeatability, "Isolated", lambda **given: asked.append(given) or nullcontext(call))
    cases: list[Any] = [SimpleNamespace(name=k) for k in range(3)]
    found = repeatability._made(cases, outcome, threads)
    assert found == {0: "ran 0", 1: "timeout: gave no answer", 2: "ran 2"}
    assert asked == [{"timeout": 60.0, "threads": threads}, *((outcome, k) for k in range(3))]


def test_a_run_is_what_its_poses_are_or_why_it_stopped(monkeypatch):
    path = simulate(scenes.make("pendulum"), Settings(samples=2, t_end=0.1, estimate="off"))
    case: Any = SimpleNamespace(engine="e", built=lambda: "scene", settings="settings")
    asked: list[Any] = []
    for run, expected in ((path, [path.times, *(getattr(path, name) for name in POSES)]),
                          (replace(path, status=Status.SINGULAR, message="stuck"), "stuck")):  # fmt: skip
        monkeypatch.setattr(repeatability.engines, "get", lambda name, run=run: SimpleNamespace(
            run=lambda *given: asked.append(given) or run))  # fmt: skip
        found = repeatability.twice(case)
        for one in found:
            assert one == expected if isinstance(one, str) else all(map(np.array_equal, one.values(), expected))
    assert asked == [("scene", "settings")] * 4


def test_a_case_that_is_lost_has_no_figures_but_why(monkeypatch):
    case = Case("exudyn", "rk4", "pendulum", {"length": 2.0}, Settings(method="rk4", step=0.25))
    about = {"engine": "exudyn", "method": "rk4", "scene": "pendulum", "parameters": {"length": 2.0},
             "setting": "step 0.25 s"}  # fmt: skip

    class Call:
        timeout = 0.0

        def __call__(self, function: Any, given: Any) -> dict[str, Any]:
            assert (function, given) == (symmetry.facts, case)
            raise Lost("crashed", "died by signal 11")

    call: Any = Call()
    assert symmetry.isolated(case, call) == about | {"judged": 0, "broken": [], "stopped": "crashed: died by signal 11"}
    assert call.timeout == symmetry.PATIENCE
    made = [symmetry.Violation("a", 1.0, 1e-9, 1e-3), symmetry.Violation("b", None, 1e-9, 1e-3, "no"),
            symmetry.Violation("c", 1e-9, 1e-9, 1e-3), symmetry.Violation("d", 1e-3, 1e-9, 1e-3)]  # fmt: skip
    monkeypatch.setattr(symmetry, "violations", lambda *given: made)
    monkeypatch.setattr(symmetry.engines, "get", lambda name: name)
    found = symmetry.facts(case)
    assert found == about | {"judged": 3, "stopped": "", "broken": [
        asdict(one) | {"exceeds_error": one.symmetry == "a"} for one in made if one.symmetry in "ad"]}  # fmt: skip
    monkeypatch.setattr(symmetry, "violations", fails)
    assert symmetry.facts(case) == about | {"judged": 0, "broken": [], "stopped": "it stopped"}


def fails(*given: Any) -> Any:
    raise symmetry.NotRunError("it stopped")


def test_an_inertia_is_moved_on_bodies_that_have_one():
    """By a quarter of it, the products too; a particle has none."""
    for name in ("pendulum", "heavy_top", "kepler"):
        for body in scenes.make(name).bodies:
            own, moved = (np.array(getattr(one, "inertia", 0.0)) for one in (body, _moved_inertia(body)))
            assert moved == pytest.approx(1.25 * own)
            assert _moved_inertia(body).mass == body.mass


def test_euler_parameters_turn_at_half_the_angular_velocity():
    """Those of a body that turns steadily about a fixed axis, by a difference of two moments."""
    rng = np.random.default_rng(5)
    omega, step = rng.normal(size=(3, 3)), 1e-6
    start = Rotation.from_rotvec(rng.normal(size=(3, 3)))
    before, after = ((Rotation.from_rotvec(t * omega) * start).as_quat(scalar_first=True) for t in (-step, step))
    found = _turning(start.as_quat(scalar_first=True), omega)
    assert found == pytest.approx((after - before) / (2.0 * step), abs=1e-6)


def test_a_slow_clock_reports_two_fifths_of_the_call(monkeypatch):
    clock = iter((7.0, 9.5))
    monkeypatch.setattr(broken_engines, "process_time", lambda: next(clock))
    path = simulate(scenes.make("pendulum"), Settings(samples=2, t_end=0.1, estimate="off"))
    found = broken_engines._slow_clock(SimpleNamespace(run=lambda *given: path), None, None, None)  # type: ignore[arg-type]
    assert found.timing == replace(path.timing, loop_s=pytest.approx(1.0))


@pytest.mark.parametrize(("settings", "scaled"), [
    (Settings(method="rk4", step=0.01), {"step": 0.08}),
    (Settings(method="dop853", rtol=1e-6, atol=1e-8), {"atol": 32e-8, "rtol": 1e-6}),
    (Settings(method="dop853", rtol=1e-6), {"atol": None, "rtol": 1e-6}),
])  # fmt: skip
def test_an_image_in_other_units_is_run_in_those_units(settings, scaled):
    """Lengths are 32 times as long and times 8 times; an engine that follows moves the image exactly so."""
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 3)
    plain = simulate(scene, Settings(rtol=1e-9, samples=3, t_end=1.0, estimate="off"))
    asked: list[Any] = []

    def run(image: Scene, chosen: Settings, at: np.ndarray) -> Trajectory:
        asked.append((image, chosen, at))
        return replace(plain, times=at, position=32.0 * plain.position)

    engine: Any = SimpleNamespace(name="made", run=run)
    measure = symmetry._seen(partial(symmetry._placed, length=32.0, time=8.0))
    assert measure(engine, scene, settings, plain) == pytest.approx(0.0, abs=1e-12)
    ((image, chosen, at),) = asked
    assert (image.duration, chosen.t_end, at.tolist()) == (8.0 * scene.duration, 8.0, (8.0 * times).tolist())
    assert {name: getattr(chosen, name) for name in scaled} == pytest.approx(scaled)
    needs_step = symmetry._seen(partial(symmetry._placed, length=32.0, time=8.0), needs_step=True)
    assert isinstance(needs_step(engine, scene, settings, plain), str) == (settings.step is None)
    few = SimpleNamespace(name="few", run=lambda *given: replace(plain, times=plain.times[:2]))
    with pytest.raises(symmetry.NotRunError, match="few does not finish"):
        measure(few, scene, settings, plain)  # type: ignore[arg-type]
    free = scene.model_copy(update={"loads": (SimpleNamespace(type="drag"),)})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(symmetry.place, "obstacle", lambda scene, placed: "singles out a direction")
        assert measure(engine, free, settings, plain) == "singles out a direction"


def test_velocities_are_judged_by_what_most_samples_show(monkeypatch):
    """An impact's jump spoils few samples: the median counts, of all other deviations the largest."""
    asked: dict[str, Any] = {}
    note = lambda self, what, curves, floor, size=None: asked.setdefault(what, size) and ""  # noqa: E731
    monkeypatch.setattr(_Rungs, "deviation", note)
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 41)
    truth = seek_truth(scene, times)
    assert isinstance(truth, Truth)
    settings = Settings(method="rk4", step=0.01, estimate="off")
    run = Called(settings, simulate(scene, settings, times))
    rising = _Rungs(RK4, Question(scene, times, truth), (run, run))
    list(ladder._always(rising))
    assert asked == {"velocities miss the slope of positions by": ladder.typical}
    misses = np.array([[0.1, -0.2], [9.0, 0.0], [0.3, 0.1]])
    assert ladder.typical(misses) == 0.3


@pytest.mark.parametrize(("error", "floor", "falling", "odds"), [
    (1e-3, 1e-6, False, (0.4, 0.3)), (1e-3, 1e-6, False, (0.2, 0.3)), (1e-3, 1e-6, True, (0.4, 0.3)),
    (1e-6, 1e-6, False, (0.4, 0.3)), (1e-5, 0.9e-5, False, (0.4, 0.3)),
])  # fmt: skip
def test_runs_fail_to_converge_by_the_odds_beyond_a_part_of_their_error(error, floor, falling, odds):
    """That of a limit and that of a stall beyond the floor, or beyond the error over its scatter."""
    bars: list[float] = []
    shown: Any = SimpleNamespace(
        ladder=SimpleNamespace(errors=np.array([1.0, error]), is_falling=falling),
        odds_of_limit=lambda bar: bars.append(bar) or odds[0], odds_of_stall=lambda bar: bars.append(bar) or odds[1],
    )  # fmt: skip
    found = ladder._failing(shown, floor)
    if falling or error <= floor:
        assert found == ("", 0.0)
        return
    assert found == ("converge to another limit" if odds[0] > odds[1] else "do not fall", pytest.approx(sum(odds)))
    assert bars == [pytest.approx(max(floor, error / ladder.SCATTER))] * 2
