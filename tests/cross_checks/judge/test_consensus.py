"""What engines agree on: whom the pair may be made of, and when all are asked for a finer setting."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.judge import consensus
from cross_checks.judge.consensus import ENOUGH, FINE, FINEST, Witness, _heard, working_truth
from cross_checks.judge.measure import error_of
from cross_checks.judge.runs import Runs
from cross_checks.metrics.metric import Judged
from cross_checks.metrics.state_error import known_to
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import truth_for
from mbs_ref import scenes
from mbs_ref.scene.bodies import PlanarBody
from mbs_ref.trajectory import Trajectory

SCENE = scenes.make("pendulum")
TIMES = np.linspace(0.0, SCENE.duration, 5)


def off(by: float) -> Trajectory:
    """Return the motion with its places off."""
    truth = truth_for(SCENE, TIMES)
    assert truth is not None
    assert truth.velocity is not None
    assert truth.angular_velocity is not None
    return Trajectory(TIMES, truth.position + by, truth.orientation, truth.velocity, truth.angular_velocity)


def witness(engine: str, package: str, by: float, moved: float = 1e-10) -> Witness:
    return Witness(engine, package, "rk4", "step=1", off(by), moved)


@dataclass
class MadeUp:
    """Runs that are off by a function of the step."""

    by: Callable[[float], float]

    def run(self, scene, engine, settings):
        plain = dict(scene=scene.name, parameters={}, engine=engine, method=settings.method, status="success",
                     settings=settings.model_dump(exclude_none=True))  # fmt: skip
        return Run(Record(**plain), off(self.by(settings.step)))


@pytest.mark.parametrize(
    ("by", "known", "leads"),
    [
        (lambda h: 3.0 * h**2, 1e-14, True),
        (lambda h: 3.0 * h**2 + 50.0 * h**3, 1e-7, True),  # the finest run is off by 8e-7
        (lambda h: h, 2e-3, True),  # another order than documented: half of the error goes, and is told
        (lambda h: 1e-7 if h > 8e-4 else -1e-7, 3e-7, False),  # rounding leads nowhere: the finest run stands
    ],
)
def test_runs_of_fixed_steps_are_heard_where_they_lead(by, known, leads):
    method = engines.get("exudyn").method("generalized_alpha")
    found = _heard(MadeUp(by), SCENE, "exudyn", method, FINE)  # type: ignore[arg-type]
    assert found is not None
    assert ("extrapolated" in found.name) == leads
    assert np.max(np.abs(found.path.position - off(0.0).position)) <= max(found.moved, 1e-15) <= known


@pytest.fixture
def heard(monkeypatch):
    """Return what fills in the witnesses: those at the fine settings, and those at the finest."""

    def fill(fine: list[Witness], finest: list[Witness] | None = None) -> None:
        monkeypatch.setattr(consensus, "_witnesses", lambda runs, scene, asked: finest if asked is FINEST else fine)

    return fill


def test_engines_of_one_package_do_not_agree_with_themselves(heard):
    """Pinocchio from Python and from C++ are closest, and know nothing of each other's mistakes."""
    heard([witness("pinocchio", "pinocchio", 1e-2), witness("pinocchio_cpp", "pinocchio", 1e-2),
           witness("mujoco", "mujoco", 0.0), witness("mbs_ref", "mbs_ref", 1e-9)])  # fmt: skip
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert "mujoco" in found.how
    assert "mbs_ref" in found.how


def test_one_package_alone_is_told(heard):
    heard([witness("pinocchio", "pinocchio", 0.0), witness("pinocchio_cpp", "pinocchio", 1e-9)])
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert "both stand on pinocchio" in found.how


def test_a_truth_too_rough_to_tell_agreement_is_refined(heard):
    rough = [witness("mujoco", "mujoco", 1e-9, 1e-6), witness("mbs_ref", "mbs_ref", 0.0, 2e-6)]
    fine = [one._replace(moved=1e-9) for one in rough]
    heard(rough, fine)
    found = working_truth(Runs(), SCENE)
    assert isinstance(found, Truth)
    assert "1.4e-09 of the scene" in found.how  # 1e-9 m in both coordinates
    heard(fine, [])
    assert isinstance(working_truth(Runs(), SCENE), Truth)  # known well enough: nobody is asked again


def test_what_engines_agree_to_is_what_a_judge_believes(heard):
    """Turns are compared, too: no small body's radius of gyration makes the distance of two runs larger."""
    body = PlanarBody(name="bob", mass=1.0, inertia=1e-6, position=SCENE.bodies[0].position)
    small = SCENE.model_copy(update={"bodies": (body,)})
    heard([witness("mujoco", "mujoco", 0.0, 2e-9), witness("mbs_ref", "mbs_ref", 0.0, 2e-9)])
    found = working_truth(Runs(), small)
    assert isinstance(found, Truth)
    error, _ = error_of(Judged(small, off(1e-7), found))
    assert error is not None
    assert error.uncertainty == pytest.approx(2e-9)
    assert known_to(small, replace(found, turn_uncertainty=None)) > 100.0 * error.uncertainty  # of points alone


def test_what_a_finer_setting_does_not_mend_stays_as_it_was(heard):
    rough = [witness("mujoco", "mujoco", 1e-9, 1e-6), witness("mbs_ref", "mbs_ref", 0.0, 1e-6)]
    worse = [one._replace(moved=1e-2) for one in rough]
    for finest in (worse, []):
        heard(rough, finest)
        found = working_truth(Runs(), SCENE)
        assert isinstance(found, Truth)
        assert "1.0e-06" in found.how
    heard([witness("mujoco", "mujoco", 0.5), witness("mbs_ref", "mbs_ref", 0.0)])
    assert isinstance(working_truth(Runs(), SCENE), NoTruth)
    assert ENOUGH < 1e-6
