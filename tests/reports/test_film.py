"""Pictures of motions: the GIF plays every sample, the strip shows what was asked for."""

from __future__ import annotations

import base64
import io
import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image, ImageChops

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import unit
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.film.drawing import _paper, drawing
from reports.film.files import (
    STRIP,
    Camera,
    as_gif,
    as_mp4,
    as_page,
    beside,
    clock,
    coil,
    filmstrip,
    gif,
    round_length,
    video_library,
)

SCENES = ["android_simplified", "pendulum_chain", "spring_pendulum", "bouncing_ball", "rolling_sphere"]


@pytest.mark.parametrize("name", SCENES)
def test_every_sample_is_a_frame(name):
    scene = scenes.make(name)
    path = simulate(scene, Settings(samples=9, t_end=0.05, reactions=False))
    film = Image.open(io.BytesIO(gif(scene, path)))
    assert film.n_frames == 9
    strip = Image.open(io.BytesIO(filmstrip(scene, path, 8)))
    wide, high = Camera(drawing(scene, path), widest=STRIP / 4).size
    assert strip.size == (4 * wide, 2 * high)
    assert 4 * wide <= STRIP


@pytest.fixture(scope="module")
def runs():
    scene = scenes.make("pendulum")
    paths = (simulate(scene, Settings(samples=n, t_end=0.5, reactions=False, estimate="off")) for n in (9, 5))
    return scene, dict(zip(("one", "other"), paths, strict=True))


def test_runs_stand_beside_each_other_in_one_scale_for_as_long_as_both_last(runs):
    scene, paths = runs
    pictures = beside(scene, paths)
    assert len(pictures) == 5
    wide, high = Camera(*(drawing(scene, path) for path in paths.values())).size
    assert {picture.size for picture in pictures} == {(2 * wide, high)}
    first = np.asarray(pictures[0])
    label = slice(14, 32)  # the rows of the label, the only difference at t = 0
    same = first[:, :wide] == first[:, wide:]
    assert np.delete(same, label, axis=0).all()
    assert not same[label].all()
    assert Image.open(io.BytesIO(as_gif(pictures, 1.0))).n_frames == 5


def test_an_mp4_plays_for_as_long_as_asked(runs):
    av = pytest.importorskip("av")
    scene, paths = runs
    with av.open(io.BytesIO(as_mp4(beside(scene, {"one": paths["one"]}), 2.0, video_library()))) as film:
        (stream,) = film.streams
        assert float(stream.duration * stream.time_base) == pytest.approx(2.0, abs=0.3)
        assert all(length % 2 == 0 for length in (stream.width, stream.height))


def test_a_page_holds_every_picture_and_its_time(runs):
    scene, paths = runs
    pictures = beside(scene, {"one": paths["one"]})
    page = as_page("<pendulum>", pictures, paths["one"].times, 2.0).decode()
    assert "<title>&lt;pendulum&gt;</title>" in page
    kept = json.loads(re.search(r"const pictures = (\[.*?\]), times = ", page).group(1))
    for text, picture in zip(kept, pictures, strict=True):
        shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(text))).convert("RGB"), dtype=int)
        assert np.abs(shown - np.asarray(picture, dtype=int)).mean() < 2.0  # of 255: few colours are kept
    assert len(json.loads(re.search(r"times = (\[.*?\]), pause = 222;", page).group(1))) == 9


def test_without_its_package_an_mp4_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ImportError, match=r"pip install 'mbs-ref\[film\]'"):
        video_library()


@pytest.mark.parametrize(
    ("most", "length", "told"),
    [
        (0.9, 0.5, "500 mm"),
        (2.1, 2.0, "2 m"),
        (1.0, 1.0, "1 m"),
        (7e4, 5e4, "50 km"),
        (3.2e11, 2 * 1.495978707e11, "2 au"),
    ],
)
def test_the_scale_is_a_round_length(most, length, told):
    found, word = round_length(most)
    assert found == pytest.approx(length)
    assert word == told


@pytest.mark.parametrize(("end", "told"), [(1.0, "0.500 s"), (4e5, "0.0 days"), (1e9, "0.0 years")])
def test_the_clock_suits_the_film(end, told):
    assert clock(0.5, end) == told


def test_planets_have_names_and_orbits_and_mechanisms_have_not():
    sky = scenes.make("figure_eight")
    path = simulate(sky, Settings(samples=5, reactions=False, estimate="off"))
    assert sorted(drawing(sky, path).labels.values()) == sorted(sky.body_names)
    scenery = drawing(sky, path)
    camera = Camera(scenery)
    drawn, bare = (camera.picture(one, 2) for one in (scenery, replace(scenery, labels={})))
    assert ImageChops.difference(drawn, bare).getbbox() is not None
    chain = scenes.make("pendulum_chain")
    assert drawing(chain, simulate(chain, Settings(samples=3, t_end=0.05, reactions=False))).labels == {}


def rolling() -> tuple[Scene, Trajectory]:
    """Return a disc that rolls down a slope without ends, told by a short stretch of it."""
    scene = scenes.make("rolling_disc")
    return scene, simulate(scene, Settings(samples=9, reactions=False, estimate="off"))


def test_the_ground_is_as_long_as_the_ride_and_wheels_are_seen_to_turn():
    scene, path = rolling()
    scenery = drawing(scene, path)
    (floor,), (contact,) = scenery.surfaces, scene.contacts
    along = (floor[0, 1] - floor[0, 0]) / np.linalg.norm(floor[0, 1] - floor[0, 0])
    place = scenery.circles[0][0] @ along
    assert floor[0, 0] @ along <= place.min() - contact.radius
    assert floor[0, 1] @ along >= place.max() + contact.radius
    assert np.ptp(path.orientation) > np.pi
    spoke = scenery.radii[0][:, 1] - scenery.radii[0][:, 0]
    assert np.allclose(np.unwrap(np.arctan2(spoke[:, 1], spoke[:, 0])), path.orientation[:, 0], atol=1e-9)


@pytest.mark.parametrize("name", ["heavy_top", "bricard"])  # gravity along -z, and along -y
def test_space_is_seen_upright_and_is_no_mirror_image(name):
    scene = scenes.make(name)
    paper = _paper(scene)
    assert np.allclose(unit(paper @ np.negative(scene.gravity)), (0.0, 1.0))
    right, up = paper  # both are perpendicular to the line of sight, which comes towards the eye from below the pole
    assert np.cross(right, up) @ np.negative(scene.gravity) > 0.0


def test_a_body_is_filled_between_its_joints_and_one_link_of_many_is_coloured():
    scene = scenes.make("tracked_vehicle")
    path = simulate(scene, Settings(samples=3, t_end=1e-3, reactions=False, estimate="off"))
    scenery = drawing(scene, path)
    chassis = scene.body_index("chassis")
    corners = {tuple(np.round(corner, 6)) for k, fill in scenery.fills if k == chassis for corner in fill[0]}
    axles = {tuple(np.round(joint.point, 6)) for joint in scene.joints if "chassis" in joint.ends}
    assert len(axles) == 5
    assert axles <= corners
    assert scene.bodies[scenery.accent].name == "link0"
    assert Camera(scenery).size[0] > 800


def test_a_spring_is_a_zigzag_from_end_to_end():
    line = coil((0.0, 0.0), (100.0, 0.0))
    assert (line[0], line[-1]) == ((0.0, 0.0), (100.0, 0.0))
    assert len({np.sign(y) for _, y in line[1:-1]}) == 2


def test_bodies_that_travel_far_stay_in_the_picture_and_the_ground_passes_by():
    scene = scenes.make("tracked_vehicle")
    still = simulate(scene, Settings(samples=3, t_end=1e-3, reactions=False, estimate="off"))
    way = 5.0 * np.arange(3)[:, None, None] * np.array((1.0, 0.0))  # m
    riding = drawing(scene, replace(still, position=still.position + way))
    assert np.ptp(riding.centres.mean(axis=1), axis=0).max() < 1e-3
    assert Camera(riding).size == pytest.approx(Camera(drawing(scene, still)).size, abs=3)
    moved = [surface for surface in riding.surfaces if np.allclose(surface[2] - surface[0], (-10.0, 0.0), atol=1e-3)]
    assert len(moved) > len(scene.contacts) // 3, "the ground, and the marks below it"
