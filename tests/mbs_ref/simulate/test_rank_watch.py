"""A run that passes close to a singular pose says so; one that does not keeps quiet."""

from __future__ import annotations

import pytest

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scenes.slider_cranks import slider_crank as slider_crank
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate


def passages(scene: Scene, t_end: float) -> list[str]:
    path = simulate(scene, Settings(rtol=1e-8, t_end=t_end, samples=401, reactions=False))
    assert path.ok, path.message
    return [note for note in path.notes if "singular pose" in note]


def test_a_parallelogram_through_flat_names_the_time_and_the_joints():
    (note,) = passages(scenes.make("n_four_bar", loops=1), 1.0)
    assert "t = 0.70" in note
    assert "smallest singular value of C_q" in note
    assert "joint '" in note


def test_a_rod_hardly_longer_than_its_crank_names_the_dead_centre():
    assert passages(slider_crank(crank_length=0.5, rod_length=0.5001), 1.0)


@pytest.mark.parametrize("scene", ["slider_crank", "pendulum_chain", "kepler", "bricard"])
def test_a_regular_motion_has_no_note(scene):
    assert not passages(scenes.make(scene), 0.5)
