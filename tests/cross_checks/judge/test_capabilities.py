"""What the adapters declare, derived a second time from their refusals."""

from __future__ import annotations

import pytest

from cross_checks import engines
from cross_checks.judge.capabilities import capabilities
from mbs_ref import scenes
from mbs_ref.scene.traits import traits

PROBES = {name: scenes.make(name) for name in ("pendulum", "slider_crank", "kepler", "sliding_block", "heavy_top")}


def refusals(engine, scene):
    by_method = [refusal for method in engine.methods() for refusal in engine.method_refusals(scene, method)]
    return engine.refusals(scene) or by_method


@pytest.mark.parametrize("one", capabilities(PROBES), ids=lambda one: one.engine)
def test_traits_follow_from_the_scenes_that_show_them(one):
    if not one.installed:
        assert (one.methods, one.parts, one.traits) == ((), {}, {})
        assert one.reason
        return
    engine = engines.get(one.engine)
    assert set(one.traits) == {trait for scene in PROBES.values() for trait in traits(scene)}
    for trait, ability in one.traits.items():
        own = [name for name, scene in PROBES.items() if trait in traits(scene)]
        if all(one.scenes[name] for name in own):
            listed = [[r for r in refusals(engine, PROBES[name]) if r.permanent] for name in own]
            assert ability.answer == ("never" if all(listed) else "not-yet")
            assert ability.reason
        else:
            barred = [method.name for method in engine.methods() if trait in method.excludes]
            assert ability.answer == ("some" if barred else "can")
            assert all(name in ability.reason for name in barred)


def test_these_scenes_show_unlike_answers():
    answers = {ability.answer for one in capabilities(PROBES) for ability in one.traits.values()}
    assert answers >= {"can", "not-yet", "never"}
