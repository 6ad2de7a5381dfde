"""The fate of made-up runs, the search of the boundary, the file of cells, and real cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.extremes import (
    LISTED,
    Axis,
    Case,
    Extreme,
    Measured,
    every,
    families,
    fate,
    grid,
    named,
    run,
    unjudged,
)
from cross_checks.extremes.families import bad_input
from cross_checks.extremes.fate import Fate, Point, judge, made_of
from cross_checks.extremes.run import run_point
from cross_checks.isolation.parent import Lost
from cross_checks.records import lines
from cross_checks.truths.made_by.sky.particles import converge
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Estimate, Status, Trajectory

SCENE = scenes.make("pendulum")


RK4 = Method("rk4", "fixed", 4, "made up")


def fate_of(run: Trajectory, error: float = 0.0, uncertainty: float = 0.0, must_stop: bool = False) -> Point:
    case = Case(SCENE, grid(1.0, 0.1), lambda scene, path: Measured(error, uncertainty), step=0.1, must_stop=must_stop)
    return judge(case, RK4, 1.0, run)


def path(status: Status = Status.SUCCESS, message: str = "", unreported: bool = False) -> Trajectory:
    none = np.zeros((2, 1, 2))
    return Trajectory(
        np.array([0.0, 1.0]), none, np.zeros((2, 1)), none, np.zeros((2, 1)), status, message, unreported=unreported
    )


def admitting(error: float) -> Trajectory:
    """A success on a motion of 1 m that says itself how far it may be off (m)."""
    times = np.array([0.0, 1.0])
    estimate = Estimate(times, np.array([[0.0] * 4, [error] * 4]), "made up", size=1.0, tolerance=1e-8, cost_s=0.0)
    return replace(path(), estimate=estimate)


@pytest.mark.parametrize(
    ("error", "uncertainty", "fate", "odds"),
    [
        (0.0, 0.0, Fate.SURVIVED, 1.0),
        (1e-4, 0.0, Fate.SURVIVED, 1.0),
        (1e-2, 0.0, Fate.DEGRADED, 0.0),
        (0.3, 0.0, Fate.SILENTLY_WRONG, 0.0),
        (np.nan, 0.0, Fate.SILENTLY_WRONG, 0.0),
        (np.inf, 0.0, Fate.SILENTLY_WRONG, 0.0),
        (1e-4, 1e-3, Fate.SURVIVED, 0.95),  # below the uncertainty of the truth, which is as large as the bar
    ],
)
def test_a_success_is_judged_by_its_error(error, uncertainty, fate, odds):
    point = fate_of(path(), error, uncertainty)
    assert point.fate is fate
    assert point.odds == pytest.approx(odds, abs=0.02)


def test_an_error_near_the_bar_is_handled_with_even_odds():
    odds = [fate_of(path(), error).odds for error in (0.7e-3, 0.9e-3, 1e-3, 1.1e-3, 1.5e-3)]
    assert odds == sorted(odds, reverse=True)
    assert 0.2 < odds[2] < 0.8


@pytest.mark.parametrize(
    ("error", "said", "fate"),
    [
        (0.2, 0.3, Fate.DEGRADED),
        (0.2, np.inf, Fate.DEGRADED),
        (0.2, 0.05, Fate.SILENTLY_WRONG),  # it says less than another motion
        (1e-4, 0.3, Fate.SURVIVED),
    ],
)
def test_a_success_that_says_itself_that_it_is_another_motion_is_not_silent(error, said, fate):
    point = fate_of(admitting(said), error)
    assert point.fate is fate
    assert point.handled is (fate is Fate.SURVIVED)
    assert ("it states so: the digits hold until" in point.reason) is (fate is Fate.DEGRADED)


def test_to_say_so_is_right_where_nothing_but_a_refusal_is():
    assert fate_of(admitting(0.05), must_stop=True).fate is Fate.SILENTLY_WRONG
    point = fate_of(admitting(0.3), must_stop=True)
    assert (point.fate, point.handled, point.is_silent) == (Fate.DEGRADED, True, False)


def test_a_stop_with_a_reason_is_no_lie_and_is_right_where_nothing_else_is():
    stopped = path(Status.NOT_CONVERGED, "Newton gave up at t = 0.5 s")
    assert not fate_of(stopped).handled
    point = fate_of(stopped, must_stop=True)
    assert (point.fate, point.handled, point.is_silent) == (Fate.STOPPED, True, False)
    assert "Newton" in point.reason


def test_success_without_a_right_answer_is_silently_wrong():
    point = fate_of(path(), must_stop=True)
    assert (point.fate, point.is_silent, point.caught) == (Fate.SILENTLY_WRONG, True, False)


@pytest.mark.parametrize(
    "found",
    [
        path(Status.RESET, "mujoco reset its state before t = 1 s"),
        path(Status.NON_FINITE, "NaN arose", unreported=True),
    ],
)
def test_what_our_checks_find_and_the_engine_does_not_say_is_caught_and_silently_wrong(found):
    point = fate_of(found)
    assert (point.fate, point.is_silent, point.caught) == (Fate.SILENTLY_WRONG, True, True)
    assert "without a word" in point.reason


def test_an_engine_that_reports_its_nan_has_stopped():
    assert fate_of(path(Status.NON_FINITE, "it said so")).fate is Fate.STOPPED


def point_at(value: float, handled: bool) -> Point:
    return Point(value, Fate.SURVIVED if handled else Fate.STOPPED, float(handled), handled, None, "", "")


def sought(values: list[float], is_handled: Callable[[float], bool], full: bool = False) -> fate.Cell:
    calls: list[float] = []

    def probe(value: float) -> Point:
        calls.append(value)
        return point_at(value, is_handled(value))

    found = made_of("a", "b", "e", "m", full, run.search(values, probe, full))
    assert sorted(calls) == [point.value for point in found.points]
    return found


VALUES = [10.0**k for k in range(11)]


@pytest.mark.parametrize("edge", range(12))
def test_the_last_handled_value_is_found_in_few_runs(edge):
    found = sought(VALUES, lambda value: value < 0.5 * 10.0**edge)
    assert found.last == (VALUES[edge - 1] if edge else None)
    assert len(found.points) <= 6


@pytest.mark.parametrize("edge", range(1, 11))
def test_a_full_search_narrows_the_boundary_between_listed_values(edge):
    found = sought(VALUES, lambda value: value < 0.5 * 10.0**edge, full=True)
    assert found.last is not None
    assert 0.5 * 10.0 ** (edge - 0.125) <= found.last < 0.5 * 10.0**edge
    assert len(found.points) <= 12


@pytest.mark.parametrize("bad", range(1, 10))
def test_a_full_search_detects_a_failure_in_the_middle_of_the_axis(bad):
    found = sought(VALUES, lambda value: not 10.0**bad <= value < 10.0 ** (bad + 1), full=True)
    assert found.last is not None
    assert 10.0 ** (bad - 1) <= found.last < 10.0**bad
    assert found.points[-1].handled
    assert len(found.points) <= 15


def test_values_whose_product_overflows_or_is_zero_are_refined():
    fine = run.refined([1e160, 1e300])
    assert fine[4] == pytest.approx(1e230)
    assert (len(fine), fine[-1]) == (9, 1e300)
    assert run.refined([1.0, 0.0]) == [1.0, 0.0]


def test_an_axis_of_one_value_is_one_run():
    assert len(sought([1.0], lambda value: True).points) == 1


def test_a_cell_is_explained_by_the_first_of_its_worst_failures():
    """And not by a milder one before it; that comes where all is right no more."""

    def failed(value: float, fate: Fate, reason: str, handled: bool = False) -> Point:
        return Point(value, fate, float(handled), True, None, "", reason)

    grows = [point_at(1.0, True), failed(2.0, Fate.STOPPED, "it died"), failed(3.0, Fate.SILENTLY_WRONG, "NaN"),
             failed(4.0, Fate.SILENTLY_WRONG, "another motion")]  # fmt: skip
    found = made_of("a", "b", "e", "m", False, grows)
    assert (found.fate, found.reason, found.first_failure, found.last) == (Fate.SILENTLY_WRONG, "NaN", "it died", 1.0)
    says_so = [failed(1.0, Fate.DEGRADED, "it says so", handled=True), failed(2.0, Fate.STOPPED, "it died")]
    assert made_of("a", "b", "e", "m", False, says_so).reason == "it died"


def test_cells_survive_the_file_and_a_corrupt_line_costs_only_itself(tmp_path):
    one = made_of("a", "b", "e", "m", False, [point_at(1.0, True), point_at(2.0, False)])
    target = tmp_path / "cells.jsonl"
    lines.append(target, [one])
    with target.open("a") as file:
        file.write('{"extreme": 3}\n')
    lines.append(target, [made_of("a", "b", "e", "n", False, [point_at(1.0, False)])])
    cells, problems = fate.read(target)
    assert cells[0] == one
    assert [c.method for c in cells] == ["m", "n"]
    assert len(problems) == 1
    assert ":2:" in problems[0]


def test_every_extreme_is_a_scene_along_an_axis():
    found = every()
    assert len(found) >= 30
    assert len({e.name for e in found}) == len(found)
    for extreme in found:
        mild = extreme.case(extreme.axis.values[0])
        assert not mild.must_stop, extreme.name
        assert mild.step is not None or mild.rtol is not None
        assert extreme.title.endswith(".")
        assert not extreme.axis.labels or len(extreme.axis.labels) == len(extreme.axis.values)
    with pytest.raises(ValueError, match="unknown"):
        named("no-such-extreme")


def test_the_file_of_extremes_names_every_case_and_its_kinds():
    modules = {info.name: import_module(f"{families.__name__}.{info.name}") for info in iter_modules(families.__path__)}
    listed = {family: [entry["name"] for entry in entries if "case" not in entry] for family, entries in LISTED.items()}
    assert {name: list(module.CASES) for name, module in modules.items()} == listed
    for name, unit, numbers in (("any-mass", "kg", bad_input.MASSES), ("any-start", "rad/s", bad_input.SPEEDS)):
        assert named(name).axis.labels == tuple(f"{number:g} {unit}" for number in numbers)
    assert len(named("any-orbit").axis.labels) == len(bad_input.SPEEDS)


def standing(case: Case) -> Trajectory:
    """The start, kept: a wrong answer as a rule, but one that can be judged."""
    bodies, n = case.scene.bodies, len(case.times)
    place = np.tile(np.array([body.position for body in bodies], dtype=float), (n, 1, 1))
    turned = np.array([getattr(body, "angle", 0.0) for body in bodies])
    spin = np.zeros((n, len(bodies)))
    if case.scene.dimension == 3:
        turned = np.array([getattr(body, "orientation", (1.0, 0.0, 0.0, 0.0)) for body in bodies])
        spin = np.zeros_like(place)
    still = np.zeros_like(place)
    return Trajectory(case.times, place, np.tile(turned, (n,) + (1,) * turned.ndim), still, spin)


# whose truths take ten seconds, and further ones of the androids and of satellites
LONG = {"chain-length", "chain-going-taut", "android-belts", "android-mass", "satellite-dive"}


@pytest.mark.parametrize("extreme", [
    pytest.param(e, marks=pytest.mark.slow) if e.name in LONG else e for e in every()
], ids=lambda e: e.name)  # fmt: skip
@pytest.mark.parametrize("ends", [True, pytest.param(False, marks=pytest.mark.slow)], ids=["ends", "between"])
def test_an_answer_can_be_judged_everywhere_on_the_axis(extreme, ends):
    """A truth that gives up, or takes long, would be held against the engine."""
    values = extreme.values(full=True)
    for value in (values[0], values[-1]) if ends else values[1:-1]:
        case = extreme.case(value)
        if not case.must_stop:
            assert case.measure(case.scene, standing(case)).error >= 0.0, value


def test_mujoco_resets_on_a_stiff_spring_and_is_caught():
    pytest.importorskip("mujoco")
    assert run_point("stiff-spring-quiet", 1e2, "mujoco", "rk4").fate is Fate.SURVIVED
    point = run_point("stiff-spring-quiet", 1e10, "mujoco", "rk4")
    assert (point.fate, point.caught, point.status) == (Fate.SILENTLY_WRONG, True, "reset")


def test_the_reference_solver_refuses_the_same_spring_at_that_step():
    point = run_point("stiff-spring-quiet", 1e10, "mbs_ref", "rk4")
    assert (point.fate, point.is_silent) == (Fate.STOPPED, False)
    assert "step" in point.reason


@pytest.mark.parametrize("duration", [1e-4, 1e-6])
@pytest.mark.parametrize("method", ["dop853", "lsodar"])
def test_the_reference_solver_meets_a_declared_pulse_of_a_microsecond(method, duration):
    assert run_point("crash-pulse", duration, "mbs_ref", method).fate is Fate.SURVIVED


@pytest.mark.parametrize(("extreme", "value"), [
    ("any-mass", 2.0), pytest.param("chain-going-taut", 1e5, marks=pytest.mark.slow),
])  # fmt: skip
def test_dassl_keeps_heavy_bodies_in_their_joints(extreme, value):
    pytest.importorskip("sundials4py")
    assert run_point(extreme, value, "mbs_ref", "dassl").fate is Fate.SURVIVED


def test_rebound_carries_nan_along_and_is_caught():
    pytest.importorskip("rebound")
    point = run_point("any-orbit", 1.0, "rebound", "whfast")
    assert (point.fate, point.caught, point.status) == (Fate.SILENTLY_WRONG, True, "non-finite")
    assert run_point("any-orbit", 1.0, "mbs_ref", "gauss").fate is Fate.STOPPED


def test_the_sky_is_judged_by_how_far_its_bodies_go():
    """Half an orbit later the satellite is across the Earth; nothing else moves."""
    case = named("satellite-step").case(10.0)
    start = np.array(case.scene.bodies[1].position)
    assert case.measure(case.scene, standing(case)).error == pytest.approx(1.0)
    moved = standing(case)
    moved.position[-1, 1] += 1e-3 * np.linalg.norm(start)
    assert case.measure(case.scene, moved).error == pytest.approx(1.0, rel=1e-2)


def test_an_orbit_in_too_few_steps_says_how_far_it_is_off():
    """RK4 at up to a seventh of Jupiter's year: whatever size counts as another motion, the error is known."""
    scene, times = scenes.make("outer_solar_system"), np.array([0.0, 3e8])
    truth = converge(scene, times)
    assert isinstance(truth, Truth)
    for step in (1e7, 3e7, 5e7):
        run = simulate(scene, Settings(method="rk4", step=step, reactions=False), times)
        error = float(np.linalg.norm(run.position[-1] - truth.position[-1], axis=1).max())
        assert run.estimate is not None
        assert 1.0 < run.estimate.poses[-1] * run.estimate.length / error < 10.0


def test_after_a_failure_at_the_mild_end_the_far_end_is_not_the_next():
    calls: list[float] = []
    run.search(VALUES, lambda value: calls.append(value) or point_at(value, False), False)  # type: ignore[func-returns-value]
    assert calls[0] == VALUES[0]
    assert calls[1:2] != [VALUES[-1]]


@pytest.mark.parametrize("extreme", ["heavy-on-light", "driven-lock"])
def test_the_default_method_is_right_at_the_mild_end(extreme):
    assert run_point(extreme, named(extreme).axis.values[0], "mbs_ref", "dop853").fate is Fate.SURVIVED


def test_orbits_are_as_many_as_they_are_called():
    case = named("orbit-count").case(30.0)
    assert case.times[-1] == pytest.approx(60.0 * np.pi)
    assert case.step == pytest.approx(2.0 * np.pi / 200.0)


def test_a_run_that_does_not_come_back_is_a_stop_and_not_handled():
    axis = Axis("kind", "", (0.0, 1.0), labels=("mild", "wild"))
    extreme = Extreme("made", "family", "Made.", axis, lambda value: Case(SCENE, grid(1.0), unjudged))

    class Call:
        fresh, timeout = True, 0.0

        def apart(self, *given: object) -> Point:
            raise Lost("timeout", "it took too long")

        __call__ = apart

    engine = engines.get("mbs_ref")
    found = run.cell_of(extreme, engine, engine.method("dop853"), False, Call())  # type: ignore[arg-type]
    assert [(p.fate, p.handled, p.status, p.reason) for p in found.points] == [
        (Fate.STOPPED, False, "timeout", "it took too long")] * 2  # fmt: skip
    assert (found.fate, found.last) == (Fate.STOPPED, None)


def test_a_block_holds_by_the_reference_solver_and_creeps_by_mujocos_own_contacts():
    """MuJoCo creeps at 765 um/s as shipped, of the 2 m/s that the weight gives within a second."""
    pytest.importorskip("mujoco")
    held, creeps = run_point("hold-slope", 0.29, "mbs_ref", "dop853"), run_point("hold-slope", 0.29, "mujoco", "stock")
    assert held.error < 1e-12
    assert creeps.error == pytest.approx(765e-6 / 1.95, rel=0.02)
    methods = {task[1] for task in run.tasks([named("hold-slope"), named("zeno")], ["mujoco"], full=False)}
    assert {"stock", "euler_noslip", "rk4"} <= methods
