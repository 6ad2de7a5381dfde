"""A refusal as one text: complete where it is short, counted where many parts are refused alike."""

from cross_checks import engines
from cross_checks.engine import Refusal
from cross_checks.judge.capabilities import summary
from mbs_ref import scenes


def test_reasons_that_differ_by_names_are_counted_and_others_are_shown():
    many = [Refusal(f"contact 'a{k}': no law of '{k}'", permanent=True) for k in range(20)]
    loops = Refusal("no loops", permanent=True)
    assert Refusal.text([*many, loops, loops]) == "contact 'a0': no law of '0' (and 19 more like it); no loops"
    assert Refusal.text(many[:2]) == "contact 'a0': no law of '0'; contact 'a1': no law of '1'"
    assert Refusal.text([]) == ""
    owned = [Refusal(f"the engine's laws lack 'b{k}'", permanent=True) for k in range(9)]
    assert Refusal.text(owned) == "the engine's laws lack 'b0' (and 8 more like it)"


def test_an_engine_refuses_a_scene_of_many_parts_in_a_readable_text():
    scene, mujoco = scenes.make("tracked_vehicle"), engines.get("mujoco")
    text = mujoco.refusal(scene, mujoco.method(None))
    assert "mujoco" in text
    assert "more like it" in text
    assert len(text) < 2000


def test_what_an_engine_has_nothing_for_is_refused_for_good_with_the_cause():
    mujoco, pinocchio = engines.get("mujoco"), engines.get("pinocchio")
    (never,), (later,) = (engine.refusals(scenes.make("straight_line_linkage")) for engine in (mujoco, pinocchio))
    cause = "mujoco does not support the part type 'coordinate_drive': MuJoCo prescribes motions of mocap bodies alone"
    assert never.reason.startswith(cause)
    assert never.permanent
    assert later == Refusal("pinocchio does not yet support the part type 'coordinate_drive'", permanent=False)
    assert summary([never.reason]) == "lacks coordinate_drive"
