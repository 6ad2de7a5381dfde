"""mbs-ref animate: planar and spatial scenes become a GIF that moves and a strip of pictures."""

from __future__ import annotations

import sys

import pytest
from click.testing import CliRunner
from PIL import Image, ImageChops

from reports.cli import main
from reports.film.files import STRIP


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
        assert strip.width % 3 == 0
        assert strip.width == 3 * film.width if 3 * film.width <= STRIP else strip.width > STRIP - 6
        first = film.convert("RGB")
        film.seek(4)
        assert ImageChops.difference(first, film.convert("RGB")).getbbox() is not None


def test_what_cannot_be_written_is_said_before_the_run(tmp_path):
    found = animate("pendulum", "-o", str(tmp_path / "film.mp4"))
    assert found.exit_code == 2
    assert "'.mp4' is unknown; allowed: .gif" in found.stderr
    assert animate("no_such_scene").exit_code == 2


def test_engines_stand_beside_each_other(tmp_path):
    pytest.importorskip("mujoco")
    one, both = tmp_path / "one.gif", tmp_path / "both.gif"
    short = ("--frames", "3", "--strip", "2", "--t-end", "0.1")
    assert animate("double_pendulum", *short, "--engine", "mujoco", "-o", str(one)).exit_code == 0
    found = animate("double_pendulum", *short, "--engine", "mbs_ref", "--engine", "mujoco", "-o", str(both))
    assert found.exit_code == 0, found.output
    with Image.open(one) as alone, Image.open(both) as together:
        assert abs(together.width - 2 * alone.width) <= 2
        assert together.n_frames == 3
    refused = animate("kepler", "--engine", "mujoco", "-o", str(tmp_path / "x.gif"))
    assert refused.exit_code == 1
    assert "nothing to draw: mujoco: refused" in refused.stderr


def test_an_mp4_without_its_package_is_refused_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    found = animate("pendulum", "--mp4", "-o", str(tmp_path / "film.gif"))
    assert found.exit_code == 3
    assert "pip install 'mbs-ref[film]'" in found.stderr
    assert not list(tmp_path.iterdir())
