"""Pictures of motions: the GIF plays every sample, the strip shows what was asked for."""

from __future__ import annotations

import io

import pytest
from PIL import Image

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.film import Camera, drawing, filmstrip, gif

SCENES = ["android_simplified", "pendulum_chain", "spring_pendulum", "bouncing_ball", "rolling_sphere"]


@pytest.mark.parametrize("name", SCENES)
def test_every_sample_is_a_frame(name):
    scene = scenes.make(name)
    path = simulate(scene, Settings(samples=9, t_end=0.05, reactions=False))
    film = Image.open(io.BytesIO(gif(scene, path)))
    assert film.n_frames == 9
    strip = Image.open(io.BytesIO(filmstrip(scene, path, 8)))
    wide, high = Camera(drawing(scene, path)).size
    assert strip.size == (4 * wide, 2 * high)
