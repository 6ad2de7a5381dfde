"""The search for settings: made-up methods whose error is known, then engines."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge.bounds import FINER, LEVELS, MOST_STEPS, WINDOW
from cross_checks.judge.cell import truth_of
from cross_checks.judge.ladder import SAMPLES, TIGHTEST, settings_at
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import Tried, first_knob, search
from cross_checks.judge.vocabulary import Verdict
from cross_checks.records.numbers import duration
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.traits import traits
from mbs_ref.trajectory import Trajectory

SCENE = scenes.make("pendulum")
TIMES = np.linspace(0.0, SCENE.duration, 41)
TRUTH = Truth(np.zeros((41, 1, 2)), np.zeros((41, 1)), 1e-16, "exact", "nowhere")
FOURTH, ADAPTIVE = Method("rk4", "fixed", 4, "made up"), Method("tight", "adaptive", 8, "made up")


@pytest.fixture(autouse=True)
def alone(monkeypatch):
    """No other engine is a reference of made-up methods, unless a test wants one."""
    monkeypatch.setattr("cross_checks.judge.tried.Tried.reference_error", lambda tried, knob: None)


@dataclass
class MadeUp:
    """Runs whose error is a function of the step or the tolerance; `refuses` and `blows` say where they end."""

    error: object
    refuses: object = lambda knob: False
    blows: object = lambda knob: False
    status: str = "non-finite"  # of what blows
    count: object = None  # steps of a tolerance
    turn: object = lambda knob: np.pi / 4.0  # direction of the error
    a_step: float = 0.0  # s of processor time
    longest: float = np.inf
    asked: list = field(default_factory=list)

    def run(self, scene, engine, settings, seconds=0.0):
        knob = settings.step or settings.rtol
        self.asked.append(knob)
        steps = int(scene.duration / knob) if settings.step else int((self.count or (lambda r: 30 * r**-0.1))(knob))
        plain = dict(scene=scene.name, parameters={}, engine=engine, method=settings.method, steps=steps,
                     settings=settings.model_dump(exclude_none=True))  # fmt: skip
        times = {"loop_s": 2.0 * self.a_step * steps, "cpu_share": 0.5}  # on a machine that others use
        if self.refuses(knob):
            return Run(Record(**plain, status="cannot", message=f"step = {knob} s is too long"), None)
        if self.blows(knob):
            return Run(Record(**plain, status=self.status, message="NaN", times=times), None)
        way = np.array([np.cos(self.turn(knob)), np.sin(self.turn(knob))])
        place = np.ones((41, 1, 1)) * self.error(knob) * scales_of(scene).length * way
        still = np.zeros((41, 1))
        return Run(Record(**plain, status="success", times=times), Trajectory(TIMES, place, still, 0.0 * place, still))


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
    assert tried.verdict().verdict is Verdict.AGREES


def test_between_a_run_and_a_failure_close_to_it_nothing_is_tried():
    """What is in between cannot reach a target a thousand times smaller."""
    runs = MadeUp(lambda h: 1e2 * h**2, blows=lambda h: h < 2e-3)
    search(runs, SCENE, "made", Method("trapezoidal", "fixed", 2, "made up"), TRUTH)
    assert len(runs.asked) <= 6


def test_steps_are_foretold_as_they_grew():
    """Some estimates of the error are of a lower order than the method, and steps grow faster than documented."""
    runs = MadeUp(lambda r: 10.0 * r, count=lambda r: int(40.0 * r**-0.33))
    tried, answers = search(runs, SCENE, "made", Method("radau", "adaptive", 3, "made up"), TRUTH)
    assert [answer.answer for answer in answers] == ["reached"] * 3
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
    assert 1e-8 <= 5.0 * runs.asked[1] ** power <= 1e-7


def test_an_embedded_solution_may_be_of_order_zero():
    assert Method("euler", "adaptive", 1, "made up", embedded=0).local_order == 1


def test_a_verdict_asks_no_more_of_a_tolerance_than_a_local_error_leaves():
    tried = Tried(Runs(), SCENE, "made", Method("radau", "adaptive", 5, "made up", embedded=3), TRUTH)
    assert tried.documented_order == pytest.approx(5 / 6)


@pytest.mark.parametrize(("engine", "method"), [("mbs_ref", "radau"), ("exudyn", "tree_dopri5")])
def test_the_orders_declared_of_pairs_show_in_their_errors(engine, method):
    """Against the closed form: 5(3) of Radau gives 5/4, 5(4) of Dormand and Prince 1."""
    runs, truth, tolerances = Runs(), truth_of(Runs(), SCENE), (1e-6, 1e-10)
    declared = engines.get(engine).method(method)
    errors = [runs.judged(SCENE, engine, settings_at(declared, SCENE, rtol), truth).error.value for rtol in tolerances]
    seen = np.log(errors[0] / errors[1]) / np.log(tolerances[0] / tolerances[1])
    assert seen == pytest.approx(declared.order / declared.local_order, abs=0.1)


def test_after_a_tolerance_that_no_step_meets_only_looser_ones_are_tried():
    runs = MadeUp(lambda r: r, blows=lambda r: True, status="step-too-small")
    _, (answer,) = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3,))
    assert answer.answer == "not-reached"
    assert runs.asked == sorted(runs.asked)
    assert runs.asked[1] > runs.asked[0]


def test_a_method_that_fails_at_all_tolerances_is_done_in_few_runs():
    runs = MadeUp(lambda r: r, blows=lambda r: True)
    search(runs, SCENE, "made", ADAPTIVE, TRUTH)
    assert len(runs.asked) <= 5
    assert TIGHTEST <= min(runs.asked) <= 4.0 * TIGHTEST


def test_steps_that_outputs_end_make_no_looser_tolerance_cheaper():
    runs = MadeUp(lambda r: min(9e-7, r), count=lambda r: 41)
    search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-3,))
    assert len(runs.asked) <= 3
    assert max(runs.asked) == 1e-5


def test_a_costly_target_is_tried_where_its_edge_is_within_the_bound():
    runs = MadeUp(lambda h: 9.0 * h)  # 1e-3 is met by 90 000 steps, the middle of its window by 300 000
    _, answers = search(runs, SCENE, "made", Method("euler", "fixed", 1, "made up"), TRUTH, (1e-3,))
    assert [answer.answer for answer in answers] == ["reached"]


def test_between_two_runs_a_steep_error_is_interpolated():
    runs = MadeUp(lambda r: 1e12 * r**3)
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
    omitted = answers[1].omitted
    assert 0.5 < omitted.steps / (SCENE.duration / 1e-6) < 3.0
    assert omitted.range[0] <= omitted.error <= omitted.range[1] <= 3e-6
    assert SCENE.duration / min(runs.asked) <= 1.01 * MOST_STEPS


def test_a_target_alone_is_worth_no_run_that_takes_long():
    runs = MadeUp(lambda h: 60.0 * h**2, a_step=1e-3, longest=3.0)
    method = Method("trapezoidal", "fixed", 2, "made up")
    tried, answers = search(runs, SCENE, "made", method, TRUTH)
    assert [answer.answer for answer in answers] == ["reached", "not-tried", "not-tried"]
    assert SCENE.duration / min(runs.asked) <= 4096  # the next power of two
    assert answers[1].omitted.seconds == pytest.approx(1e-3 * answers[1].omitted.steps)
    assert duration(answers[1].omitted.seconds) in answers[1].reason
    assert tried.verdict().verdict is Verdict.CONVERGING
    _, answers = search(replace(runs, longest=np.inf), SCENE, "made", method, TRUTH)
    assert [answer.answer for answer in answers] == ["reached", "reached", "not-tried"]


def test_a_method_that_is_wrong_within_a_limit_of_time_is_judged_without_one():
    """Errors that stay, rise and then fall: affordable runs after the confirming one show the plateau alone."""
    runs = MadeUp(lambda h: 0.022 if 6.55e-3 <= h < 2.09e-2 else 0.23 * min(1.0, (h / 6.55e-3) ** 1.78), a_step=1e-3)
    runs.longest, method = 0.56, Method("trapezoidal", "fixed", 2, "made up")
    limited = Tried(runs, SCENE, "made", method, TRUTH)
    limited.begin(first_knob(SCENE, method))
    limited.reach([1e-3, 1e-6, 1e-9])
    assert limited.settle().verdict is Verdict.WRONG_LIMIT
    tried, answers = search(runs, SCENE, "made", method, TRUTH)
    assert tried.verdict().verdict is Verdict.CONVERGING
    assert "not-reached" not in {answer.answer for answer in answers}


def test_a_run_for_the_verdict_alone_is_finer_than_others_and_no_dearer_than_it_must_be():
    runs = MadeUp(lambda h: 1e-3 * h**4)
    tried, _ = search(runs, SCENE, "made", FOURTH, TRUTH)
    assert tried.verdict().verdict is Verdict.AGREES
    assert len(runs.asked) == 2
    assert 0.8 * FINER["fixed"] < runs.asked[0] / runs.asked[1] < 1.5 * FINER["fixed"]


@pytest.mark.parametrize("is_exempt", [False, True])
def test_no_run_for_a_verdict_takes_long_where_a_documented_weakness_explains_it(is_exempt):
    weak = replace(FOURTH, wrong_limit="soft", weak_on=traits(SCENE) if is_exempt else frozenset())
    runs = MadeUp(lambda h: 0.25 + h**4, a_step=1e-3, longest=3.0)
    tried, _ = search(runs, SCENE, "made", weak, TRUTH)
    assert tried.verdict().verdict is Verdict.WRONG_LIMIT
    assert (SCENE.duration / min(runs.asked) <= 4096) is is_exempt  # the next power of two


@pytest.mark.parametrize(("longest", "count"), [(np.inf, 4), (1.0, LEVELS)])
def test_after_three_failures_no_setting_is_tried_that_takes_long(longest, count):
    runs = MadeUp(lambda h: h, blows=lambda h: True, a_step=1e-3, longest=longest)
    tried, _ = search(runs, SCENE, "made", FOURTH, TRUTH, (1e-3,), 10**7)
    assert len(runs.asked) == count
    assert tried.verdict().verdict is Verdict.DIVERGED


@pytest.mark.parametrize(("settle", "answer"), [(True, "not-reached"), (False, "not-tried")])
def test_a_verdict_that_is_not_settled_denies_no_target(settle, answer):
    tried, answers = search(MadeUp(lambda r: 1e-5 + r), SCENE, "made", ADAPTIVE, TRUTH, (1e-6, 1e-9), settle=settle)
    assert tried.verdict().verdict is Verdict.WRONG_LIMIT
    assert {one.answer for one in answers} == {answer}


def test_a_tolerance_that_cannot_be_tightened_denies_its_target():
    runs = MadeUp(lambda r: 1e-2, blows=lambda r: r > 4.0 * TIGHTEST)
    _, (answer,) = search(runs, SCENE, "made", ADAPTIVE, TRUTH, (1e-6,), settle=False)
    assert (min(runs.asked), answer.answer) == (TIGHTEST, "not-reached")


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


def test_where_finer_settings_fail_the_reason_names_the_failure():
    _, answers = search(MadeUp(lambda h: 50.0 * h, blows=lambda h: h < 4e-3), SCENE, "made", FOURTH, TRUTH)
    reasons = [answer.reason for answer in answers if answer.answer == "not-reached"]
    assert reasons
    assert all("non-finite" in reason for reason in reasons)


def test_runs_that_are_as_far_off_as_motions_go_are_compared_with_a_reference_method(monkeypatch):
    """Its error at the same setting states what the motion allows: as far off as it, nobody is classified as wrong."""
    made = MadeUp(lambda h: 1.5 + 0.2 * np.sin(1.2e5 * h), turn=lambda h: 8.4e6 * h)
    for error, verdict in ((1.6, Verdict.NOT_SHOWN), (1e-9, Verdict.DIVERGED)):
        monkeypatch.setattr("cross_checks.judge.tried.Tried.reference_error", lambda tried, knob, error=error: error)
        tried, answers = search(made, SCENE, "made", FOURTH, TRUTH)
        assert tried.reference is not None
        assert tried.verdict().verdict is verdict, tried.verdict()
        assert {answer.answer for answer in answers} <= {"not-tried", "not-reached"}


@pytest.mark.parametrize(("method", "finer"), [(FOURTH, 4.0), (ADAPTIVE, 100.0)], ids=["fixed", "adaptive"])
def test_a_classification_as_wrong_waits_for_a_plainly_finer_run(method, finer):
    """Errors that stay as far as the search goes, and fall beyond or never: who needs more work is slow, not wrong."""
    stays = MadeUp(lambda knob: 0.3 * (1.0 + knob), count=lambda rtol: 50.0 * rtol**-0.2)
    wrong, _ = search(stays, SCENE, "made", method, TRUTH)
    finest, before = wrong.knobs[-1], wrong.knobs[-2]
    assert wrong.verdict().verdict is Verdict.WRONG_LIMIT
    assert stays.asked[-1] == finest
    assert before / finest >= 0.9 * finer or finest == TIGHTEST
    falls = MadeUp(lambda knob: 0.3 * (1.0 + knob) if knob > finest else 0.02 * knob / finest, count=stays.count)
    acquitted, answers = search(falls, SCENE, "made", method, TRUTH)
    assert acquitted.verdict().verdict is not Verdict.WRONG_LIMIT
    assert "reached" not in {answer.answer for answer in answers}


def test_first_order_is_expected_where_contacts_begin_between_steps():
    """An error that halves with the step converges; below half of the documented order the sentence says so."""
    contact, pendulum = scenes.make("bouncing_ball"), SCENE
    for scene, method, slow in (
        (contact, FOURTH, False),
        (contact, replace(FOURTH, locates_events=True), True),
        (pendulum, FOURTH, True),
    ):
        tried, _ = search(MadeUp(lambda h: 50.0 * h), scene, "made", method, TRUTH)
        verdict, reason, _ = tried.verdict()
        assert verdict is Verdict.CONVERGING
        assert ("below half of 4" in reason) is slow


def test_the_reference_is_of_another_library_and_of_no_lower_order(monkeypatch):
    monkeypatch.undo()
    scene = scenes.make("double_pendulum")
    runs, truth = Runs(), truth_of(Runs(), scene)
    theirs = Tried(runs, scene, "pinocchio", engines.get("pinocchio").method("rk4"), truth).reference_error(0.05)
    ours = Tried(runs, scene, "mbs_ref", engines.get("mbs_ref").method("rk4"), truth).reference_error(0.05)
    assert theirs is not None
    assert ours == pytest.approx(theirs, rel=0.5)  # rk4 is rk4


def test_the_same_question_makes_the_same_runs():
    first, second = MadeUp(lambda h: h**4), MadeUp(lambda h: h**4)
    for runs in (first, second):
        search(runs, SCENE, "made", FOURTH, TRUTH)
    assert first.asked == second.asked


def test_a_stiff_android_runs_with_the_steps_that_it_bears():
    """Ladders once ended at the first refused step, so that our own RK4 'cannot'."""
    scene, runs = scenes.make("android_simplified", model="paper"), Runs()
    method = engines.get("mbs_ref").method("rk4")
    _, (coarse, *_) = search(runs, scene, "mbs_ref", method, truth_of(runs, scene), (1e-3,))
    assert coarse.answer == "reached"


def test_a_search_whose_first_step_would_cost_too_much_begins_at_the_bound():
    scene = scenes.make("kepler", eccentricity=0.9)  # ten orbits: the pericentre asks for steps beyond the bound
    method = engines.get("mbs_ref").method("rk4")
    assert first_knob(scene, method) < scene.duration / MOST_STEPS
    tried, reached = search(Runs(), scene, "mbs_ref", method, NoTruth("not run"))
    assert tried.knobs
    assert {answer.answer for answer in reached} == {"unjudged"}
