"""Cells of the validation matrix: a tiny engine, the store behind it, and the observations that once were wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.judge.answers import check
from cross_checks.judge.cell import judged, truth_of
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Verdict
from cross_checks.metrics.metric import from_truth
from cross_checks.records.store import Store
from cross_checks.truths import seek_truth
from mbs_ref import scenes
from mbs_ref.observables.distance import largest
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.cross_checks.conftest import BIAS, raising

PENDULUM = scenes.make("pendulum")
LENGTH = 2.0**0.5  # m, of the pendulum's box: its pin and its bob
CRANK = {"name": "my_crank", "parameters": {}}  # what a scene file changes of the library's scene


def test_every_cell_has_its_verdict(swing):
    second, biased, loops, absent = cells = check(Runs(), [PENDULUM])
    assert (second.verdict, biased.verdict) == (Verdict.AGREES, Verdict.WRONG_LIMIT)
    assert (loops.verdict, absent.verdict) == (Verdict.CANNOT, Verdict.ENGINE_MISSING)
    assert second.order == pytest.approx(2.0, abs=1e-3)
    assert [target.answer for target in second.targets] == ["reached", "reached", "not-tried"]
    assert biased.error * truth_length() == pytest.approx(BIAS, rel=1e-2)
    json.dumps([cell.to_dict() for cell in cells], allow_nan=False)


def truth_length() -> float:
    from mbs_ref.scene.scales import scales_of

    return scales_of(PENDULUM).length


def test_an_engine_that_raises_fails_its_own_cells(swing):
    swing(raising(RuntimeError("singular")))
    verdicts = {cell.method: cell.verdict for cell in check(Runs(), [PENDULUM], ["swing"])}
    assert verdicts == {"second": Verdict.FAILED, "biased": Verdict.FAILED, "loops": Verdict.CANNOT}


def test_no_engine_is_accused_of_a_scene_whose_start_breaks_its_joints(swing):
    (bob,) = PENDULUM.bodies
    torn = PENDULUM.model_copy(update={"bodies": (bob.model_copy(update={"velocity": (0.5, 0.5)}),)})
    cells = check(Runs(), [torn], ["swing"])
    assert {cell.verdict for cell in cells} == {Verdict.CANNOT}
    assert "breaks joint" in cells[0].reason
    assert not any(cell.is_wrong for cell in cells)


def test_a_cell_holds_the_runs_that_reach_its_targets_without_their_histories(swing):
    cell, records = judged(Runs(), PENDULUM, "swing", engines.get("swing").method("second"), truth_of(Runs(), PENDULUM))
    reached = [result.record for result in cell.targets if result.record]
    assert [replace(r, history={}) for r in records if r.settings in [run.settings for run in reached]] == reached
    assert all(record.history for record in records)


def test_unknown_engines_are_refused(swing):
    with pytest.raises(ValueError, match="nobody"):
        check(Runs(), [PENDULUM], ["nobody"])


def test_wrong_velocities_do_not_agree(swing):
    """An engine whose positions are right and whose velocities are not was once said to agree."""
    swing(lambda path: replace(path, velocity=-3.0 * path.velocity))
    cell, _ = judged(Runs(), PENDULUM, "swing", engines.get("swing").method("second"), truth_of(Runs(), PENDULUM))
    assert cell.verdict not in (Verdict.AGREES, Verdict.CONVERGING)


@pytest.mark.parametrize(("wrong", "part"), [("orientation", 1), ("angular_velocity", 3)])
def test_a_wrong_angle_or_spin_in_the_plane_is_an_error(wrong, part):
    """A rolling disc of another angle and spin once scored 0."""
    scene = scenes.make("rolling_disc")
    path = simulate(scene, Settings(rtol=1e-10, estimate="off"), np.linspace(0.0, scene.duration, 41))
    truth = seek_truth(scene, path.times)
    assert not largest(from_truth(scene, path, truth).counted[..., part]) > 1e-6  # NaN: less than the truth resolves
    spoiled = replace(path, **{wrong: -3.0 * getattr(path, wrong) + 1.0})
    assert largest(from_truth(scene, spoiled, truth).sizes[..., part]) > 0.1


def test_the_same_store_asked_twice_makes_no_run_and_says_the_same(swing):
    runs = Runs(Store())
    first = [cell.to_dict() for cell in check(runs, [PENDULUM], ["swing"])]
    made = len(runs.store)
    again = [cell.to_dict() for cell in check(runs, [PENDULUM], ["swing"])]
    assert made == len(runs.store) > 0
    assert json.dumps(first, sort_keys=True) == json.dumps(again, sort_keys=True)


def test_a_body_that_turns_about_a_resting_centre_is_not_settled():
    """Gaps once were measured by positions alone, which do not move here: every coarse run had 'settled'."""
    scene = scenes.make("torque_free_top", turns=10.0)
    runs = Runs()
    cell, _ = judged(runs, scene, "mbs_ref", engines.get("mbs_ref").method("euler"), truth_of(runs, scene))
    assert cell.verdict in (Verdict.CONVERGING, Verdict.NOT_SHOWN), cell.reason
    assert "order 1" in cell.reason


def test_a_copy_under_another_name_has_the_truth_and_the_verdict_of_the_original():
    scene = scenes.make("slider_crank")
    copy = scene.model_copy(update=CRANK)
    runs, method = Runs(), engines.get("mujoco").method("rk4")
    known, found = (judged(runs, one, "mujoco", method, truth_of(runs, one))[0] for one in (scene, copy))
    assert known.verdict is Verdict.WRONG_LIMIT
    assert (found.verdict, found.error, found.reason) == (known.verdict, known.error, known.reason)
    assert known.exemption
    assert not known.is_wrong


def test_a_weakness_exempts_where_its_trait_holds_alone():
    method = engines.get("mujoco").method("rk4")
    assert method.exemption(scenes.make("slider_crank"))
    assert not method.exemption(scenes.make("pendulum_chain", links=3))
