"""mbs-ref animate: planar and spatial scenes become a GIF that moves and a strip of pictures."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from PIL import Image, ImageChops

from reports.cli import main


def animate(*words: str):
    return CliRunner().invoke(main, ["animate", *words], prog_name="mbs-ref")


@pytest.mark.parametrize("scene", ["android_vertebral", "spherical_pendulum", "spatial_chain"])
def test_a_scene_moves_in_its_gif(scene, tmp_path):
    target = tmp_path / "film.gif"
    found = animate(scene, "--frames", "5", "--strip", "3", "--t-end", "0.1", "-o", str(target))
    assert found.exit_code == 0, found.output
    assert found.stdout.split() == [str(target), str(target.with_suffix(".png"))]
    with Image.open(target) as film, Image.open(target.with_suffix(".png")) as strip:
        assert film.n_frames == 5
        assert strip.width == 3 * film.width
        first = film.convert("RGB")
        film.seek(4)
        assert ImageChops.difference(first, film.convert("RGB")).getbbox() is not None


def test_what_cannot_be_written_is_said_before_the_run(tmp_path):
    found = animate("pendulum", "-o", str(tmp_path / "film.mp4"))
    assert found.exit_code == 2
    assert "'.mp4' is unknown; allowed: .gif" in found.stderr
    assert animate("no_such_scene").exit_code == 2
