"""What engines agree on: which pairs count, how far it is refined, and who is waited for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import islice
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.isolation.parent import direct
from cross_checks.isolation.workers import Late
from cross_checks.judge import consensus
from cross_checks.judge.cell import ALONE, cell_of
from cross_checks.judge.consensus import (
    BETWEEN,
    ENOUGH,
    LEVELS,
    Consensus,
    Pair,
    Witness,
    best_methods,
    between,
    witness_of,
    working_truth,
)  # fmt: skip
from cross_checks.judge.measure import error_of
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.judge.vocabulary import Verdict
from cross_checks.metrics.metric import Judged, known_to
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from cross_checks.truths import truth_for
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene.bodies import PlanarBody
from mbs_ref.scene.traits import traits
from mbs_ref.trajectory import Trajectory
from tests.cross_checks.conftest import Swing

SCENE = scenes.make("pendulum")
TIMES = np.linspace(0.0, SCENE.duration, 5)
ONE, OTHER, THIRD = ("mujoco", "mujoco"), ("mbs_ref", "mbs_ref"), ("pinocchio", "pinocchio")


def off(by: float, times: np.ndarray = TIMES) -> Trajectory:
    """Return the motion with its places off."""
    truth = truth_for(SCENE, times)
    assert truth is not None
    assert truth.velocity is not None
    assert truth.angular_velocity is not None
    return Trajectory(times, truth.position + by, truth.orientation, truth.velocity, truth.angular_velocity)


@dataclass
class MadeUp:
    """Runs that are off by a function of the step, with the times that each was made at."""

    by: Callable[[float], float]
    times: np.ndarray = field(default_factory=lambda: TIMES)
    made: list[np.ndarray] = field(default_factory=list)

    def grid(self, scene) -> np.ndarray:
        return self.times

    def run(self, scene, engine, settings):
        plain = dict(scene=scene.name, parameters={}, engine=engine, method=settings.method, status="success",
                     settings=settings.model_dump(exclude_none=True))  # fmt: skip
        self.made.append(self.times)
        return Run(Record(**plain), off(self.by(settings.step or settings.rtol), self.times))


@pytest.mark.parametrize(
    ("by", "known", "leads"),
    [
        (lambda h: 3.0 * h**2, 1e-9, True),  # the finest run is off by 4e-7, and the truth by 6e-11 with its times
        (lambda h: 3.0 * h**2 + 50.0 * h**3, 1e-7, True),  # the finest run is off by 8e-7
        (lambda h: h, 2e-3, True),  # another order than documented: half of the error goes, and is stated
        (lambda h: 1e-7 if h > 6e-4 else -1e-7, 3e-7, False),  # rounding leads nowhere: the finest run stands
    ],
)
def test_runs_of_fixed_steps_are_extrapolated_where_they_lead(by, known, leads):
    method = engines.get("exudyn").method("generalized_alpha")
    found = witness_of(MadeUp(by), SCENE, "exudyn", method, (2e-4, 1e-4, 5e-5))  # type: ignore[arg-type]
    assert found is not None
    assert ("extrapolated" in found.name) == leads
    assert np.array_equal(found.path.times, TIMES)
    assert np.max(np.abs(found.path.position - off(0.0).position)) <= max(found.moved, 1e-15) <= known


def test_a_run_at_an_unknown_distance_from_the_others_agrees_with_none(script, monkeypatch):
    monkeypatch.setattr(consensus, "gap", lambda scene, truth, first, second: np.nan)
    method = engines.get("exudyn").method("generalized_alpha")
    found = witness_of(MadeUp(lambda h: h), SCENE, "exudyn", method, (2e-4, 1e-4, 5e-5))  # type: ignore[arg-type]
    assert found is not None
    assert found.moved == np.inf
    assert "extrapolated" not in found.name
    script({ONE: [(0.0, 1e-10)], OTHER: [(0.0, 1e-10)]})
    assert isinstance(working_truth(Runs(), SCENE), NoTruth)


def test_no_two_runs_look_for_events_at_the_same_times():
    """Each has its own output times between the judges'; fixed steps are of another length in each method."""
    runs, method = MadeUp(lambda h: h), Method("dop853", "adaptive", 8, "")
    for engine in ("mbs_ref", "pinocchio"):
        assert witness_of(runs, SCENE, engine, method, (1e-6, 1e-8)) is not None  # type: ignore[arg-type]
    inner = [set(times) - set(TIMES) for times in runs.made]
    assert [len(own) for own in inner] == [BETWEEN * (len(TIMES) - 1)] * 4
    assert len(set.union(*inner)) == sum(map(len, inner))
    steps: set[float] = set()
    for engine in ("mujoco", "exudyn"):
        fixed = MadeUp(lambda h: steps.add(h) or h)  # type: ignore[func-returns-value]
        witness_of(fixed, SCENE, engine, Method("rk4", "fixed", 4, ""), (1e-3,) * 2)  # type: ignore[arg-type]
    assert len(steps) == 2


def test_times_between_are_whole_steps_and_none_of_the_grid():
    step = TIMES[1] / 16.0
    inner = between(TIMES, step, np.random.default_rng(3))
    assert np.allclose(inner / step, np.rint(inner / step), atol=1e-9)
    assert len(inner) > 0
    assert np.min(np.abs(inner[:, None] - TIMES)) > 0.5 * step
    assert len(between(TIMES, TIMES[1], np.random.default_rng(3))) == 0


@dataclass
class Script:
    """What every engine's one method gives at each level: a witness off and moved by numbers, None, or a Late."""

    levels: dict[tuple[str, str], list[tuple[float, float] | Late | None]]
    requested: list[tuple[str, int]] = field(default_factory=list)
    tried: set[str] = field(default_factory=set)
    weak: frozenset[str] = frozenset()  # engines whose method has a documented weakness on the scene

    def names(self):
        return [name for name, _ in self.levels]

    def get(self, name):
        weak = {"wrong_limit": "slips", "weak_on": traits(SCENE)} if name in self.weak else {}

        class Named(Swing):
            library = dict(self.levels.keys())[name]  # type: ignore[assignment]

            def refusals(self, scene):
                return []

            def methods(self):
                return (Method("rk4", "adaptive", 4, "", **weak),)

        Named.name = name
        return Named()

    def witness(self, runs, scene, engine, method, knobs):
        level = next(k for k, one in enumerate(LEVELS) if one["adaptive"] == knobs)
        self.requested.append((engine, level))
        package = self.get(engine).library
        told = self.levels[engine, package]
        given = told[min(level, len(told) - 1)]
        if isinstance(given, Late) and engine not in self.tried:
            self.tried.add(engine)
            raise given
        return None if given is None or isinstance(given, Late) else Witness(
            engine, package, "rk4", f"level {level}", off(given[0]), given[1], engine not in self.weak
        )  # fmt: skip


@pytest.fixture
def script(monkeypatch):
    """Return what makes the engines those of a script."""

    def use(levels, weak=()) -> Script:
        made = Script(levels, weak=frozenset(weak))
        monkeypatch.setattr(consensus.engines, "names", made.names)
        monkeypatch.setattr(consensus.engines, "get", made.get)
        monkeypatch.setattr(consensus, "witness_of", made.witness)
        return made

    return use


def test_engines_of_one_package_do_not_agree_with_themselves(script):
    """Pinocchio from Python and from C++ are closest, and know nothing of each other's mistakes."""
    script({THIRD: [(1e-2, 1e-10)], ("pinocchio_cpp", "pinocchio"): [(1e-2, 1e-10)],
            ONE: [(0.0, 1e-10)], OTHER: [(1e-9, 1e-10)]})  # fmt: skip
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert found.kind == "agreed"
    assert "mujoco" in found.how
    assert "mbs_ref" in found.how


def test_one_package_alone_is_stated(script):
    script({THIRD: [(0.0, 1e-10)], ("pinocchio_cpp", "pinocchio"): [(1e-9, 1e-10)]})
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert found.kind == "one-package"
    assert "both stand on pinocchio: one package, not certified" in found.how


def test_against_a_truth_of_one_package_no_method_is_confirmed_and_none_is_wrong(swing):
    for method, plain in (("second", Verdict.AGREES), ("biased", Verdict.WRONG_LIMIT)):
        for kind, shown in (("agreed", plain), ("one-package", Verdict.NOT_SHOWN)):
            truth = replace(truth_for(SCENE, np.linspace(0.0, SCENE.duration, 41)), kind=kind)
            cell = cell_of(*search(Runs(), SCENE, "swing", Swing().method(method), truth))
            assert cell.verdict is shown
            assert not cell.is_wrong or kind == "agreed"
            assert ({target.answer for target in cell.targets} <= {"unjudged", "not-tried", "not-reached"}) == (
                kind == "one-package" or method == "biased"
            )
            assert (ALONE in cell.reason) == (kind == "one-package")


def test_methods_of_one_package_that_disagree_are_not_confirmed_by_limits_of_their_own(script):
    script({THIRD: [(0.0, 1e-10)], ("pinocchio_cpp", "pinocchio"): [(1.0, 1e-10)]})
    found = working_truth(Runs(), SCENE, "no closed form")
    assert isinstance(found, NoTruth)
    assert found.kind == "one-package"
    assert "no closed form; one package runs the scene, and its methods agree on nothing" in found.reason


@pytest.mark.parametrize(("end", "kind"), [(1.0, NoTruth), (1e-4, Truth)])
def test_engines_that_part_agree_up_to_a_stated_time(script, end, kind):
    parting = np.array([0.0, 0.0, 1e-9, end, end])[:, None, None]
    script({ONE: [(parting, 1e-10)], OTHER: [(0.0, 1e-10)]})
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, kind)
    words = found.how if isinstance(found, Truth) else found.reason
    assert f"; up to t = {TIMES[2]:.3g} s they agree within {ENOUGH:.0e} of it: a duration no longer than that" in words


def test_a_pair_that_is_hoped_to_be_known_well_enough_needs_no_shorter_duration():
    parting = np.array([0.0, 0.0, 0.0, 1.0, 1.0])[:, None, None]
    rough = Witness("mujoco", "mujoco", "rk4", "", off(0.0), 1.0, coarser=off(parting))
    fine = rough._replace(coarser=None)
    waiting: Any = SimpleNamespace(scene=SCENE, _enough=1e-5)
    assert "up to t" in Consensus._advice(waiting, Pair(1.0, fine, rough))
    assert not Consensus._advice(waiting, Pair(1e-6, fine, rough))


def test_a_truth_is_refined_until_it_shows_agreement_and_no_further(script):
    both = [(0.0, 1e-4), (0.0, 1e-6), (0.0, 1e-9), (0.0, 1e-12)]
    made = script({ONE: both, OTHER: both})
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert "1.0e-09 of the scene" in found.how
    assert {("mujoco", 3), ("mbs_ref", 3)} > {one for one in made.requested if one[1] == 3}
    made.requested.clear()
    assert isinstance(working_truth(Runs(), SCENE, enough=1e-5), Truth)  # a caller that needs less
    assert {("mujoco", 2), ("mbs_ref", 2)} > {one for one in made.requested if one[1] == 2}


def test_what_a_finer_setting_does_not_mend_stays_as_it_was(script):
    script({ONE: [(1e-9, 1e-6), (1e-9, 1e-2)], OTHER: [(0.0, 1e-6), None]})
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert "1.0e-06" in found.how
    script({ONE: [(0.5, 1e-10)], OTHER: [(0.0, 1e-10)]})
    assert isinstance(working_truth(Runs(), SCENE), NoTruth)
    assert ENOUGH < 1e-6


def test_a_slow_engine_is_waited_for_only_where_the_others_agree_on_nothing(script):
    slow = {THIRD: [Late("slow"), (0.0, 1e-10)]}
    made = script({ONE: [(0.0, 1e-6)], OTHER: [(0.0, 1e-6)], **slow})
    assert isinstance(_received(made), Truth)
    assert made.requested.count(("pinocchio", 0)) == 1
    made = script({ONE: [(0.0, 1e-6)], OTHER: [(0.5, 1e-6)], **slow})
    assert isinstance(_received(made), Truth)
    assert made.requested.count(("pinocchio", 0)) == 2


def test_a_slow_member_of_the_closest_pair_is_waited_for_until_the_scene_is_known(script):
    slow = [(0.0, 1e-4), Late("slow"), (0.0, 1e-9)]
    made = script({ONE: [(0.0, 1e-4), (0.0, 1e-9)], OTHER: slow, THIRD: [(0.1, 1e-6)]})
    found = _received(made)
    assert isinstance(found, Truth)
    assert "1.0e-09 of the scene" in found.how
    assert made.requested.count((OTHER[0], 1)) == 2


def test_of_slow_methods_that_is_waited_for_first_which_is_nearly_settled(script):
    nearly, far = [(0.0, 1e-4), Late("slow"), (0.0, 1e-9)], [Late("slow"), (0.5, 1e-2)]
    made = script({THIRD: far, ONE: [(0.1, 1e-4), (0.0, 1e-9)], OTHER: nearly})
    assert isinstance(_received(made), Truth)
    assert made.requested.count(("pinocchio", 0)) == 1


def test_a_method_with_a_documented_weakness_agrees_with_a_sound_one_alone(script):
    levels = {ONE: [(0.0, 1e-9)], OTHER: [(0.0, 1e-9)], THIRD: [(0.5, 1e-9)]}
    weak = {ONE[0], OTHER[0]}
    script(levels, weak)
    assert isinstance(working_truth(Runs(), SCENE), NoTruth)
    script(levels, {OTHER[0]})
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert OTHER[0] in found.how


def test_sound_methods_come_before_those_with_a_documented_weakness():
    scene = scenes.make("slider_crank")
    assert [m.name for m in best_methods(engines.get("pinocchio"), scene)] == ["rk4", "dop853"]
    assert [m.name for m in best_methods(engines.get("mbs_ref"), scene)] == ["lsodar", "dop853"]


def test_the_first_levels_are_those_of_two_packages_that_lead_there_at_the_least_cost():
    """Where contact makes fixed steps a method of first order, tolerances lead."""
    engines.get("pinocchio")
    asked: list[Any] = []
    consensus_of(scenes.make("bouncing_ball"), lambda request, work, tries: asked.append(request))
    assert len({one.library for one in asked}) == len(asked) == 2
    assert {one.method.kind for one in asked} == {"adaptive"}


def test_a_method_of_order_four_is_expected_to_refine_with_a_quarter_of_the_steps_of_one_of_order_one():
    """With steps halved each time, (1/2)^(p n) = ENOUGH is reached after n levels at 2^n times the first one's cost."""
    found = consensus_of(SCENE, lambda request, work, tries: None)
    of_method = {(one.request.engine, one.request.method.name): one for one in found._waiting}
    first, fourth = (found._cost(of_method["mujoco", name])[1] for name in ("euler", "rk4"))
    assert first == pytest.approx(1.0 / ENOUGH)
    assert fourth**4 == pytest.approx(first)


def test_while_runs_are_under_way_the_scene_is_known_to_what_is_hoped(script):
    """That the second is as near to the first shows more than how far it moved."""
    script({ONE: [(0.0, 1e-5)], OTHER: [(2e-5, 1e-2)]})
    asked: list[Any] = []
    found = consensus_of(SCENE, lambda request, work, tries: asked.append((request, work)))
    for request, work in asked[:2]:
        found.receive(request, work(direct))
    assert found.pair is not None
    assert found.pair.known_to == pytest.approx(2e-5 * np.sqrt(2.0))  # in x and y
    assert isinstance(found.truth, Truth)
    for request, work in islice(asked, 2, None):  # grows meanwhile, until all levels were made
        found.receive(request, work(direct))
    assert found.is_settled
    assert found.pair.known_to == pytest.approx(1e-2)
    assert isinstance(found.truth, NoTruth)


def consensus_of(scene, add: Callable[..., Any]) -> Consensus:
    """Return a consensus whose pool does nothing but `add`."""
    return Consensus(SimpleNamespace(add=add, drop=lambda unwanted: None), Runs(), scene)  # type: ignore[arg-type]


def _received(made: Script) -> Truth | NoTruth:
    """Return the truth of a consensus whose runs are made here, a Late as in a process of its own."""

    class Here:
        def __init__(self):
            self.waiting = []

        def add(self, name, work, seconds=0.0, tries=0):
            self.waiting.append((name, work))

        def drop(self, unwanted):
            self.waiting = [(name, work) for name, work in self.waiting if not unwanted(name)]

    pool = Here()
    agreed = Consensus(pool, Runs(), SCENE)  # type: ignore[arg-type]
    while not agreed.is_settled:
        name, work = pool.waiting.pop(0)
        try:
            agreed.receive(name, work(direct))
        except Late as late:
            agreed.receive(name, late)
    assert pool.waiting == []
    return agreed.truth


def test_what_engines_agree_to_is_what_a_judge_believes(script):
    """Turns are compared, too: no small body's radius of gyration makes the distance of two runs larger."""
    body = PlanarBody(name="bob", mass=1.0, inertia=1e-6, position=SCENE.bodies[0].position)
    small = SCENE.model_copy(update={"bodies": (body,)})
    script({ONE: [(0.0, 2e-9)], OTHER: [(0.0, 2e-9)]})
    found = working_truth(Runs(), small)
    assert isinstance(found, Truth)
    error, _ = error_of(Judged(small, off(1e-7), found))
    assert error is not None
    assert error.uncertainty == pytest.approx(2e-9)
    assert known_to(small, replace(found, turn_uncertainty=None)) > 100.0 * error.uncertainty  # of points alone
