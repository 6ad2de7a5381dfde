"""The broad phase changes what is looked at, never what comes out."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores import contact_shapes as broad_phase
from mbs_ref.cores.choice import compile_scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate


@pytest.mark.parametrize(("space", "events"), [
    (False, "located"), (True, "none"),
    *(pytest.param(*case, marks=pytest.mark.slow) for case in ((False, "none"), (True, "located"))),
])  # fmt: skip
def test_results_are_the_same_to_the_last_bit(monkeypatch, space, events):
    scene = scenes.make("granular_column", grains=16, across=2, space=space)
    settings = Settings(method="rk4", step=2e-4, t_end=0.12, samples=11, events=events, estimate="off")
    monkeypatch.setattr(broad_phase, "FROM_PAIRS", 10**9)
    every = simulate(scene, settings)
    monkeypatch.setattr(broad_phase, "FROM_PAIRS", 1)
    near = simulate(scene, settings)
    assert every.ok, every.message
    assert np.array_equal(every.position, near.position)
    assert np.array_equal(every.velocity, near.velocity)
    assert every.events == near.events
    assert (every.events > 20) == (events == "located")
    for name, forces in every.contacts.items():
        assert np.array_equal(forces, near.contacts[name]), name


@pytest.mark.parametrize("space", [False, True])
def test_only_near_pairs_are_looked_at(space):
    scene = scenes.make("granular_column", grains=40, across=4, space=space)
    system = compile_scene(scene)
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    system.derivative(0.0, y)
    near = system.groups.near_pairs  # type: ignore[attr-defined]
    listed = near.pair[: near.count[0]]
    walls = [k for k, contact in enumerate(scene.contacts) if contact.name.startswith("wall")]
    assert set(walls) <= set(listed.tolist())
    assert list(listed) == sorted(listed)
    reach = 0.1 + near.skin[0]
    places = {body.name: np.array(body.position) for body in scene.bodies}
    close = [
        k for k, contact in enumerate(scene.contacts)
        if k >= len(walls) and np.linalg.norm(places[contact.body_a] - places[contact.body_b]) <= reach
    ]  # fmt: skip
    assert sorted({*walls, *close}) == listed.tolist()
    assert len(close) < len(scene.contacts) // 4


def test_a_scene_with_few_pairs_keeps_no_list():
    near = compile_scene(scenes.make("tracked_vehicle", links=20, start="drawn")).groups.near_pairs  # type: ignore[attr-defined]
    assert near.skin[0] > 0.0
    few = compile_scene(scenes.make("newtons_cradle")).groups.near_pairs  # type: ignore[attr-defined]
    assert few.skin[0] == 0.0
    assert few.count[0] == 4
