"""The search for settings: made-up methods whose error is known, then engines."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge.bounds import MOST_STEPS
from cross_checks.judge.cell import truth_of
from cross_checks.judge.control import control
from cross_checks.judge.ladder import SAMPLES, TIGHTEST, settings_at
from cross_checks.judge.runs import Runs
from cross_checks.judge.search import AIM, BACK, WINDOW, Tried, first_knob, search
from cross_checks.judge.verdict import Control, judge
from cross_checks.judge.vocabulary import Verdict
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from cross_checks.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

SCENE = scenes.make("pendulum")
TIMES = np.linspace(0.0, SCENE.duration, 41)
TRUTH = Truth(np.zeros((41, 1, 2)), np.zeros((41, 1)), 1e-16, "exact", "nowhere")
FOURTH, ADAPTIVE = Method("rk4", "fixed", 4, "made up"), Method("tight", "adaptive", 8, "made up")


@dataclass
class MadeUp:
    """Runs whose error is a function of the step or the tolerance; `refuses` and `blows` say where they end."""

    error: object
    refuses: object = lambda knob: False
    blows: object = lambda knob: False
    status: str = "non-finite"  # of what blows
    count: object = None  # steps of a tolerance
    asked: list = field(default_factory=list)

    def run(self, scene, engine, settings):
        knob = settings.step or settings.rtol
        self.asked.append(knob)
        steps = int(scene.duration / knob) if settings.step else int((self.count or (lambda r: 30 * r**-0.1))(knob))
        plain = dict(scene=scene.name, parameters={}, engine=engine, method=settings.method, steps=steps,
                     settings=settings.model_dump(exclude_none=True))  # fmt: skip
        if self.refuses(knob):
            return Run(Record(**plain, status="cannot", message=f"step = {knob} s is too long"), None)
        if self.blows(knob):
            return Run(Record(**plain, status=self.status, message="NaN"), None)
        place = np.full((41, 1, 2), self.error(knob) * scales_of(scene).length / 2.0**0.5)
        still = np.zeros((41, 1))
        return Run(Record(**plain, status="success"), Trajectory(TIMES, place, still, 0.0 * place, still))


@pytest.mark.parametrize("constant", [1e-3, 1.0, 50.0])
@pytest.mark.parametrize("method", [FOURTH, ADAPTIVE], ids=["fixed", "adaptive"])
def test_each_target_is_met_from_within_its_window_in_few_runs(method, constant):
    runs = MadeUp((lambda h: constant * h**4) if method is FOURTH else (lambda r: constant * r**0.9))
    _, answers = search(runs, SCENE, "made", method, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3
    coarsest = max(runs.asked)
    for answer in answers:
        error, knob = answer.record.error.value, answer.record.settings.get("step") or answer.record.settings["rtol"]
        assert answer.target / WINDOW <= error <= answer.target or knob == coarsest
    assert len(runs.asked) <= 6


def test_a_plateau_of_coarse_tolerances_is_passed():
    """A method that lands on every output errs alike at all coarse tolerances: no limit of its own."""
    runs = MadeUp(lambda r: min(6e-7, 3.0 * r))
    _, answers = search(runs, SCENE, "made", ADAPTIVE, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3


def test_a_failure_on_the_fine_side_is_passed():
    """An extrapolation may lead beyond the settings at which a method runs: those before are tried then."""
    runs = MadeUp(lambda r: 10.0 * r**0.6, blows=lambda r: r < 1e-12)
    _, answers = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3, 1e-6))
    assert [answer.answer for answer in answers] == ["reached"] * 2


def test_a_step_that_fails_between_steps_that_run_is_leapt_over():
    """As an implicit method does whose iteration fails at some steps and converges at finer ones."""
    runs = MadeUp(lambda h: 1e2 * h**2, blows=lambda h: 8e-4 < h < 4e-3)
    _, (answer,) = search(runs, SCENE, "made", Method("trapezoidal", "fixed", 2, "made up"), TRUTH, (1e-4,))
    assert answer.answer == "reached"


def test_a_leap_over_a_failing_step_ends_at_the_bound_on_work():
    runs = MadeUp(lambda h: 60.0 * h**2, blows=lambda h: 1.1e-4 < h < 2e-4)
    _, (answer,) = search(runs, SCENE, "made", Method("trapezoidal", "fixed", 2, "made up"), TRUTH, (1e-6,))
    assert answer.answer == "reached"


def test_a_run_that_lost_its_way_is_no_guide():
    """As where a loop takes the wrong turn in a singular pose, which steps on either side pass."""
    runs = MadeUp(lambda h: 3e-3 if 1e-3 < h < 1.5e-3 else 1e2 * h**4)
    _, answers = search(runs, SCENE, "made", FOURTH, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3


def test_a_lucky_run_stops_no_search():
    runs = MadeUp(lambda r: 2e-6 if 1e-8 < r < 4e-8 else 3e4 * r)
    _, answers = search(runs, SCENE, "made", ADAPTIVE, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3


def test_tolerances_begin_to_govern_where_outputs_no_longer_end_all_steps():
    runs = MadeUp(lambda r: min(3e-8, 3.0 * r), count=lambda r: 40 if r > 1e-8 else 80)
    _, (answer,) = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-9,))
    assert answer.answer == "reached"
    assert len(runs.asked) <= 2 + 1  # the first, the one asked for, and one for the verdict


def test_tolerances_that_do_not_yet_govern_end_no_search():
    """Where outputs govern the steps errors are alike, over decades, and a step more is no sign that they do not."""
    runs = MadeUp(lambda r: min(2e-5, 2e4 * r), count=lambda r: 40 if r > 1e-9 else 41 * (r / 1e-9) ** -0.1)
    _, answers = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3, 1e-6, 1e-8))
    assert [answer.answer for answer in answers] == ["reached"] * 3


def test_tolerances_that_leave_the_steps_as_they_are_are_no_refinements():
    """Between outputs steps are even, so their number jumps: by luck a coarser tolerance of one number errs less."""

    def error(r):
        return 1e-3 if r > 6e-7 else 1.6e-6 if r > 7e-8 else 4e-4 if r > 1e-8 else 100.0 * r

    runs = MadeUp(error, count=lambda r: 85 if r > 6e-7 else 104 if r > 1e-8 else 41 * r**-0.06)
    tried, answers = search(runs, SCENE, "made", ADAPTIVE, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3
    assert judge(tried.points(), tried.order, 1e-16)[0] is Verdict.AGREES


def test_between_a_run_and_a_failure_close_to_it_nothing_is_tried():
    """What is in between cannot reach a target a thousand times smaller."""
    runs = MadeUp(lambda h: 1e2 * h**2, blows=lambda h: h < 2e-3)
    search(runs, SCENE, "made", Method("trapezoidal", "fixed", 2, "made up"), TRUTH)
    assert len(runs.asked) <= 6


def test_steps_are_foretold_as_they_grew():
    """Some estimates of the error are of a lower order than the method, and steps grow faster than documented."""
    runs = MadeUp(lambda r: 10.0 * r, count=lambda r: int(40.0 * r**-0.33))
    tried, answers = search(runs, SCENE, "made", Method("radau", "adaptive", 3, "made up"), TRUTH)
    assert [answer.answer for answer in answers] == ["reached", "reached", "not-tried"]
    assert max(record.steps for record in tried.records.values()) <= MOST_STEPS


def test_a_run_beyond_the_bound_on_work_does_not_end_the_search_before_it():
    """Steps may grow faster than any run foretold: coarser settings cost no more for it."""
    runs = MadeUp(lambda r: 0.1 * r, count=lambda r: 300 * r**-0.12 if r > 3e-9 else 200_000)
    tried, answers = search(runs, SCENE, "made", Method("radau", "adaptive", 3, "made up"), TRUTH, (1e-3, 1e-9))
    assert max(record.steps for record in tried.records.values()) > MOST_STEPS
    assert [answer.answer for answer in answers] == ["reached"] * 2
    assert answers[1].record.steps <= MOST_STEPS


@pytest.mark.parametrize(("order", "embedded", "power"), [(5, 4, 1.0), (5, 3, 1.25), (4, None, 0.8)])
def test_errors_follow_the_tolerance_as_the_orders_of_a_pair_tell(order, embedded, power):
    """From the first run on: the second hits the middle of the window."""
    runs = MadeUp(lambda r: 5.0 * r**power)
    search(runs, SCENE, "made", Method("pair", "adaptive", order, "made up", embedded=embedded), TRUTH, (1e-7,))
    assert 5.0 * runs.asked[1] ** power == pytest.approx(AIM * 1e-7, rel=0.05)


def test_an_embedded_solution_may_be_of_order_zero():
    assert Method("euler", "adaptive", 1, "made up", embedded=0).local_order == 1


def test_a_verdict_asks_no_more_of_a_tolerance_than_a_local_error_leaves():
    tried = Tried(SCENE, "made", Method("radau", "adaptive", 5, "made up", embedded=3), TRUTH)
    assert tried.promised == pytest.approx(5 / 6)


@pytest.mark.parametrize(("engine", "method"), [("mbs_ref", "radau"), ("exudyn", "tree_dopri5")])
def test_the_orders_declared_of_pairs_show_in_their_errors(engine, method):
    """Against the closed form: 5(3) of Radau gives 5/4, 5(4) of Dormand and Prince 1."""
    runs, truth, tolerances = Runs(), truth_of(Runs(), SCENE), (1e-6, 1e-10)
    declared = engines.get(engine).method(method)
    errors = [runs.judged(SCENE, engine, settings_at(declared, SCENE, rtol), truth).error.value for rtol in tolerances]
    seen = np.log(errors[0] / errors[1]) / np.log(tolerances[0] / tolerances[1])
    assert seen == pytest.approx(declared.order / declared.local_order, abs=0.1)


def test_a_tolerance_that_no_step_meets_is_tried_no_tighter():
    runs = MadeUp(lambda r: r, blows=lambda r: True, status="step-too-small")
    _, (answer,) = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3,))
    assert answer.answer == "not-reached"
    assert len(runs.asked) == 1


def test_a_method_that_fails_at_all_tolerances_is_done_in_few_runs():
    runs = MadeUp(lambda r: r, blows=lambda r: True)
    search(runs, SCENE, "made", ADAPTIVE, TRUTH)
    assert len(runs.asked) <= 4
    assert TIGHTEST <= min(runs.asked) <= BACK * TIGHTEST


def test_steps_that_outputs_end_make_no_looser_tolerance_cheaper():
    runs = MadeUp(lambda r: min(1e-6, r), count=lambda r: 41)
    search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3,))
    assert len(runs.asked) <= 3
    assert max(runs.asked) == 1e-5


def test_a_costly_target_is_tried_where_its_edge_is_within_the_bound():
    runs = MadeUp(lambda h: 9.0 * h)  # 1e-3 is met by 90 000 steps, the middle of its window by 300 000
    _, answers = search(runs, SCENE, "made", Method("euler", "fixed", 1, "made up"), TRUTH, (1e-3,))
    assert [answer.answer for answer in answers] == ["reached"]


def test_between_two_runs_a_steep_error_is_interpolated():
    runs = MadeUp(lambda r: 1e20 * r**3)
    _, (answer,) = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-6,))
    assert answer.target / WINDOW <= answer.record.error.value <= answer.target
    assert len(runs.asked) <= 5


def test_a_coarser_setting_that_takes_no_fewer_steps_is_no_gain():
    runs = MadeUp(lambda r: min(1e-7, r), count=lambda r: 60)
    search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3,))
    assert len(runs.asked) <= 3


def test_refused_and_failing_steps_on_the_coarse_side_are_passed():
    runs = MadeUp(lambda h: 1e6 * h**4, refuses=lambda h: h > 3e-3, blows=lambda h: 1e-3 < h <= 3e-3)
    _, answers = search(runs, SCENE, "made", FOURTH, TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3


def test_what_costs_too_much_is_not_tried_and_says_so():
    runs = MadeUp(lambda h: h)
    _, answers = search(runs, SCENE, "made", Method("euler", "fixed", 1, "made up"), TRUTH)
    assert [answer.answer for answer in answers] == ["reached", "not-tried", "not-tried"]
    assert "steps" in answers[1].reason
    assert SCENE.duration / min(runs.asked) <= 1.01 * MOST_STEPS


@pytest.mark.parametrize("most", [300, 3000])
def test_a_search_keeps_within_the_steps_that_it_is_allowed(most):
    runs = MadeUp(lambda h: h)
    _, answers = search(runs, SCENE, "made", Method("euler", "fixed", 1, "made up"), TRUTH, (1e-2, 1e-6), most)
    assert [answer.answer for answer in answers] == ["not-tried" if most == 300 else "reached", "not-tried"]
    rounding = SAMPLES - 1  # a step more in each output interval, which it divides
    assert SCENE.duration / min(runs.asked) <= most + rounding


def test_a_limit_of_its_own_is_not_reached():
    _, answers = search(MadeUp(lambda h: 0.25 + h**4), SCENE, "made", FOURTH, TRUTH)
    assert {answer.answer for answer in answers} == {"not-reached"}


def test_a_target_beyond_the_bound_on_work_is_not_tried_however_many_runs_came_before():
    """A saw about the step, as of contacts that begin and end between steps: no run tells the next one's error."""
    saw = MadeUp(lambda h: h * (0.5 + abs(np.sin(1e5 * h))))
    _, answers = search(saw, SCENE, "made", replace(FOURTH, order=6), TRUTH, (1e-3, 1e-6, 1e-9))
    assert [answer.answer for answer in answers] == ["reached", "not-tried", "not-tried"]
    assert all("steps" in answer.reason for answer in answers[1:])


def test_where_finer_settings_fail_nobody_says_that_they_do_not_help():
    _, answers = search(MadeUp(lambda h: 50.0 * h, blows=lambda h: h < 4e-3), SCENE, "made", FOURTH, TRUTH)
    told = [answer.reason for answer in answers if answer.answer == "not-reached"]
    assert told
    assert all("failed" in reason and "do not help" not in reason for reason in told)


def test_runs_that_are_strangers_to_one_another_ask_for_a_control(monkeypatch):
    """They tell nothing of finer ones: a method of the same order says what may be expected."""
    asked = []

    def control(runs, scene, engine, method, knob, truth):
        asked.append(knob)
        return Control("other rk4", 2.0)

    monkeypatch.setattr("cross_checks.judge.search.control", control)
    tried, answers = search(MadeUp(lambda h: 2.0 + np.sin(1e4 * h)), SCENE, "made", FOURTH, TRUTH)
    assert tried.is_scattered()
    assert asked == [tried.knobs[-1]]
    assert tried.control == Control("other rk4", 2.0)
    assert {answer.answer for answer in answers} <= {"not-tried", "not-reached"}
    assert not any("do not help" in answer.reason for answer in answers)
    settled, _ = search(MadeUp(lambda h: 2.0 + h**4), SCENE, "made", FOURTH, TRUTH)
    assert not settled.is_scattered()
    assert settled.control is None


@pytest.mark.parametrize(("method", "finer"), [(FOURTH, 4.0), (ADAPTIVE, 16.0)], ids=["fixed", "adaptive"])
def test_an_accusation_waits_for_a_plainly_finer_run(method, finer):
    """Errors that stay as far as the search goes, and fall beyond or never: who needs more work is slow, not wrong."""
    stays = MadeUp(lambda knob: 0.3 * (1.0 + knob), count=lambda rtol: 50.0 * rtol**-0.35)
    accused, _ = search(stays, SCENE, "made", method, TRUTH)
    finest = accused.knobs[-1]
    assert accused.verdict()[0] is Verdict.WRONG_LIMIT
    assert stays.asked[-1] == pytest.approx(finest / finer, rel=0.05, abs=0.0)
    assert stays.asked[-1] not in accused.records
    falls = MadeUp(lambda knob: 0.3 * (1.0 + knob) if knob >= finest else 0.02, count=stays.count)
    acquitted, answers = search(falls, SCENE, "made", method, TRUTH)
    assert acquitted.verdict()[0] is Verdict.NOT_SHOWN
    assert falls.asked == stays.asked
    assert "reached" not in {answer.answer for answer in answers}


def test_no_verdict_asks_for_more_than_first_order_where_contacts_begin_between_steps():
    """An error that halves with the step, where order 4 is documented: a failing, unless forces jump unseen."""
    contact, pendulum = scenes.make("bouncing_ball"), SCENE
    for scene, method, verdict in (
        (contact, FOURTH, Verdict.CONVERGING),
        (contact, replace(FOURTH, locates_events=True), Verdict.NOT_SHOWN),
        (pendulum, FOURTH, Verdict.NOT_SHOWN),
    ):
        tried, _ = search(MadeUp(lambda h: 50.0 * h), scene, "made", method, TRUTH)
        assert tried.verdict()[0] is verdict


def test_nobody_appeals_who_is_not_accused_or_is_excused():
    converges, _ = search(MadeUp(lambda h: h**4), SCENE, "made", FOURTH, TRUTH)
    excused = replace(FOURTH, wrong_limit="as declared", weak_on=frozenset({"constrained"}))
    stays, _ = search(MadeUp(lambda h: 0.3 + h**4), SCENE, "made", excused, TRUTH)
    assert converges.appeal is None
    assert stays.verdict()[0] is Verdict.WRONG_LIMIT
    assert stays.appeal is None


def test_the_control_is_of_another_library_and_of_no_lower_order():
    scene = scenes.make("double_pendulum")
    runs, truth = Runs(), truth_of(Runs(), scene)
    method = engines.get("pinocchio").method("rk4")
    found = control(runs, scene, "pinocchio", method, 0.05, truth)
    assert found is not None
    assert found.by == "mbs_ref rk4"
    ours = control(runs, scene, "mbs_ref", engines.get("mbs_ref").method("rk4"), 0.05, truth)
    assert ours is not None
    assert ours.by.split()[0] != "mbs_ref"
    assert ours.error == pytest.approx(found.error, rel=0.5)  # rk4 is rk4


def test_the_same_question_makes_the_same_runs():
    first, second = MadeUp(lambda h: h**4), MadeUp(lambda h: h**4)
    for runs in (first, second):
        search(runs, SCENE, "made", FOURTH, TRUTH)
    assert first.asked == second.asked


def test_a_stiff_android_runs_with_the_steps_that_it_bears():
    """Ladders once ended at the first refused step, so that our own RK4 'cannot'."""
    scene, runs = scenes.make("android_simplified"), Runs()
    method = engines.get("mbs_ref").method("rk4")
    _, (coarse, *_) = search(runs, scene, "mbs_ref", method, truth_of(runs, scene), (1e-3,))
    assert coarse.answer == "reached"


def test_a_search_whose_first_step_would_cost_too_much_begins_at_the_bound():
    scene = scenes.make("kepler", eccentricity=0.9)  # ten orbits: the pericentre asks for steps beyond the bound
    method = engines.get("mbs_ref").method("rk4")
    assert first_knob(scene, method) < scene.duration / MOST_STEPS
    tried, reached = search(Runs(), scene, "mbs_ref", method, NoTruth("not asked"))
    assert tried.knobs
    assert {answer.answer for answer in reached} == {"unjudged"}
