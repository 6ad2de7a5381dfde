"""Pictures of motions: the GIF plays every sample, the strip shows what was asked for."""

from __future__ import annotations

import base64
import io
import json
import re
import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageChops

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import unit
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.film import drawing as drawn
from reports.film import files
from reports.film.drawing import Drawing, _paper, drawing
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
    assert json.loads(re.search(r"times = (\[.*?\]), pause = 222;", page).group(1)) == [
        f"{time:.3f} s" for time in paths["one"].times]  # fmt: skip
    late = as_page("", pictures[:3], np.array([0.0, 9000.0, 10_800.0]), 2.0).decode()  # three hours
    assert json.loads(re.search(r"times = (\[.*?\]), pause = 667;", late).group(1)) == ["0.0 h", "2.5 h", "3.0 h"]


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
        (6e-4, 5e-4, "0.5 mm"),
        (1e-3, 1e-3, "1 mm"),
        (999.0, 500.0, "500 m"),
    ],
)
def test_the_scale_is_a_round_length(most, length, told):
    found, word = round_length(most)
    assert found == pytest.approx(length)
    assert word == told


@pytest.mark.parametrize(("end", "told"), [(1.0, "0.500 s"), (4e5, "0.0 days"), (1e9, "0.0 years")])
def test_the_clock_suits_the_film(end, told):
    assert clock(0.5, end) == told


@pytest.mark.parametrize("end", np.geomspace(1.0, 1e11, 45).tolist())
def test_the_clock_ends_at_three_of_its_unit_at_least_and_of_no_greater_one(end):
    lengths = {"s": 1.0, "h": 3600.0, "days": 86_400.0, "years": 365.25 * 86_400.0}
    number, word = clock(end, end).split()
    assert float(number) == pytest.approx(end / lengths[word], abs=0.05)
    assert word == "s" or end / lengths[word] >= 3.0
    assert all(end / length < 3.0 for length in lengths.values() if length > lengths[word])


def test_planets_have_names_and_orbits_and_mechanisms_have_not():
    sky = scenes.make("figure_eight")
    path = simulate(sky, Settings(samples=5, reactions=False, estimate="off"))
    assert sorted(drawing(sky, path).labels.values()) == sorted(sky.body_names)
    masses = (2.0, 3.0, 1.0)
    uneven = [body.model_copy(update={"mass": mass}) for body, mass in zip(sky.bodies, masses, strict=True)]
    ranked = drawing(sky.model_copy(update={"bodies": tuple(uneven)}), path).labels
    assert list(ranked) == [1, 0, 2]  # the heaviest first: a name is left out where it would hide one before
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
    inner = np.array(line[1:-1])
    assert np.diff(inner[:, 0]) == pytest.approx(np.full(len(inner) - 1, 100.0 / len(inner)))
    assert inner[:, 0] + inner[::-1, 0] == pytest.approx(np.full(len(inner), 100.0)), "as far from both ends"
    assert inner[:, 1] + np.roll(inner[:, 1], 1) == pytest.approx(np.zeros(len(inner)))


def test_bodies_that_travel_far_stay_in_the_picture_and_the_ground_passes_by():
    scene = scenes.make("tracked_vehicle")
    still = simulate(scene, Settings(samples=3, t_end=1e-3, reactions=False, estimate="off"))
    way = 5.0 * np.arange(3)[:, None, None] * np.array((1.0, 0.0))  # m
    riding = drawing(scene, replace(still, position=still.position + way))
    assert np.ptp(riding.centres.mean(axis=1), axis=0).max() < 1e-3
    assert Camera(riding).size == pytest.approx(Camera(drawing(scene, still)).size, abs=3)
    moved = [surface for surface in riding.surfaces if np.allclose(surface[2] - surface[0], (-10.0, 0.0), atol=1e-3)]
    assert len(moved) > len(scene.contacts) // 3, "the ground, and the marks below it"


def scenery(rng: np.random.Generator) -> Drawing:
    """Return bodies anywhere, and circles about them, without a law."""
    size, middle = 10 ** rng.uniform(-3, 9), 10 ** rng.uniform(-3, 9)
    centres = middle + size * rng.normal(size=(7, 3, 2)) * rng.uniform(0.1, 1.0, 2)
    circles = [(centres[:, k], size * rng.uniform(0.1, 2.0)) for k in range(2)]
    return Drawing([], [], [], [], circles, [], centres, np.linspace(0.0, 3.0, 7))


@pytest.mark.parametrize("seed", range(6))
def test_the_camera_shows_everything_to_one_scale(seed):
    rng = np.random.default_rng(seed)
    seen = [scenery(rng) for _ in range(1 + seed % 2)]
    camera = Camera(*seen)
    places = np.concatenate([place for one in seen for place in (one.centres.reshape(-1, 2), *(
        centre + sign * radius for centre, radius in one.circles for sign in (-1.0, 1.0)))])  # fmt: skip
    pixels = np.array([camera(place) for place in places]) / 2.0  # twice as many are drawn
    wide, high = camera.size
    assert (pixels >= 0.0).all()
    assert (pixels <= (wide + 1, high + 1)).all()
    gaps, apart = places - places[0], pixels - pixels[0]
    assert apart == pytest.approx(camera.scale * gaps * (1.0, -1.0), rel=1e-6, abs=1e-4)
    assert wide <= 960
    assert high <= 540
    assert wide * high <= 480**2
    assert max(wide / 960, high / 540, (wide * high) ** 0.5 / 480) > 0.98
    free = np.array([pixels.min(axis=0), (wide, high) - pixels.max(axis=0)])  # the margins
    assert free == pytest.approx(np.full((2, 2), 0.06 * np.ptp(pixels, axis=0).max()), abs=1.1)
    (bar,) = np.flatnonzero((np.asarray(camera.picture(seen[0], 3)) == (68, 68, 68)).all(axis=2).sum(axis=1) > 8)[-1:]
    drawn = (np.asarray(camera.picture(seen[0], 3))[bar] == (68, 68, 68)).all(axis=1).sum()
    assert drawn == pytest.approx(camera.scale * round_length(0.3 * wide / camera.scale)[0], abs=3.0)


def test_moments_are_a_part_of_the_run_apart_and_a_film_lasts_as_long_as_requested(monkeypatch, runs):
    scene, paths = runs
    pictures = beside(scene, {"one": paths["one"]})
    film = Image.open(io.BytesIO(as_gif(pictures, 1.8)))
    lasted = 0.0
    for k in range(film.n_frames):
        film.seek(k)
        lasted += film.info["duration"]
    assert lasted == pytest.approx(1800.0, abs=10.0 * film.n_frames)
    shown: list[int] = []
    monkeypatch.setattr(Camera, "picture", lambda self, one, k: shown.append(k) or Image.new("RGB", self.size))
    filmstrip(scene, paths["one"], 4)
    assert shown == [0, 2, 4, 6]  # of nine samples


def moved(scene: Scene, seed: int) -> Trajectory:
    """Return a motion of no law, near the start."""
    rng, n, bodies = np.random.default_rng(seed), 4, len(scene.bodies)
    start = np.array([body.position for body in scene.bodies])
    place = start + 0.05 * rng.normal(size=(n, bodies, scene.dimension))
    if scene.dimension == 2:
        angles = np.array([getattr(body, "angle", 0.0) for body in scene.bodies])
        turn = angles + 0.3 * rng.normal(size=(n, bodies))
        turn[0] = angles
        place[0] = start
        return Trajectory(np.arange(4.0), place, turn, np.zeros_like(place), np.zeros_like(turn))
    own = np.array([getattr(body, "orientation", (1.0, 0.0, 0.0, 0.0)) for body in scene.bodies])
    turn = np.tile(own, (n, 1, 1))
    return Trajectory(np.arange(4.0), place, turn, np.zeros_like(place), np.zeros_like(place))


@pytest.mark.parametrize("name", ["slider_crank", "spring_pendulum", "sliding_block", "newtons_cradle", "bouncing_ball",
                                  "n_four_bar", "tracked_vehicle"])  # fmt: skip
def test_marks_move_with_their_bodies(name):
    """Spokes, pins, springs, surfaces and circles stand where a mark of the body does, by its place and turn."""
    scene = scenes.make(name)
    path = moved(scene, 3)
    shown, names = drawing(scene, path), list(scene.body_names)
    assert np.ptp(shown.centres.mean(axis=1), axis=0).max() < 0.2

    def at(body: str, mark: tuple[float, ...]) -> np.ndarray:
        if body == "ground":
            return np.tile(mark, (4, 1))
        k = names.index(body)
        arm, turn = np.array(mark) - path.position[0, k], path.orientation[:, k] - path.orientation[0, k]
        c, s = np.cos(turn), np.sin(turn)
        return path.position[:, k] + np.stack((c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]), axis=1)

    def has(lines: list[np.ndarray], wanted: np.ndarray) -> bool:
        return any(line.shape == wanted.shape and np.allclose(line, wanted, atol=1e-9) for line in lines)

    assert np.allclose(shown.centres, path.position)
    spokes, drawn = [line for _, line in shown.spokes], 0
    for joint in scene.joints:
        for end in ("body_a", "body_b"):
            body, mark = getattr(joint, end, None), joint.mark(end)
            if body is not None and mark is not None:
                drawn += 1
                place = at(body, mark)
                own = [place] if body == "ground" else [path.position[:, names.index(body)], place]
                assert has(shown.pins, place) if body == "ground" else has(spokes, np.stack(own, axis=1))
    for load in scene.loads:
        if load.type == "spring_damper":
            ends = [at(getattr(load, f"body_{end}"), getattr(load, f"point_{end}")) for end in "ab"]
            assert has(shown.springs, np.stack(ends, axis=1))
            drawn += 1
    circles = [(radius, place) for place, radius in shown.circles]
    for contact in scene.contacts:
        if contact.type == "circle_on_line" and getattr(contact, "extent", "") != "line":
            ends = [at(contact.body_b, point) for point in (contact.point_1, contact.point_2)]
            assert has(shown.surfaces, np.stack(ends, axis=1))
        balls = {"circle_on_line": [("body_a", "center", "radius")],
                 "circle_on_circle": [(f"body_{end}", f"center_{end}", f"radius_{end}") for end in "ab"]}  # fmt: skip
        for body, center, radius in balls.get(contact.type, []):
            size = getattr(contact, radius)
            place = at(getattr(contact, body), getattr(contact, center))
            assert size == 0.0 or any(r == size and np.allclose(own, place) for r, own in circles)
            drawn += 1
    assert drawn


def test_a_plane_in_space_is_drawn_around_its_spheres():
    scene = scenes.make("rolling_sphere")
    path = moved(scene, 1)
    (contact,), paper = scene.contacts, _paper(scene)
    sides = np.concatenate([side[0] for side in drawing(scene, path).surfaces])
    low, high = sides.min(axis=0), sides.max(axis=0)
    for place in path.position[:, 0]:
        foot = place - (place - np.array(contact.point)) @ unit(contact.normal) * np.array(unit(contact.normal))
        assert (paper @ foot >= low).all()
        assert (paper @ foot <= high).all()
    assert len({tuple(np.round(corner, 9)) for corner in sides}) == 4
    assert np.ptp(sides, axis=0).max() > 4.0 * contact.radius


@pytest.mark.parametrize(("seconds", "rate", "shown"), [(2.0, 4, [0, 1, 2, 3, 5, 6, 7, 8]), (0.1, 30, [0, 4, 8]),
                                                     (90.0, 1, None)])  # fmt: skip
def test_an_mp4_has_pictures_at_an_even_rate_to_the_last_one(seconds, rate, shown):
    """Nine pictures of an odd size: at most 30 a second, at least one; no row or column without a partner."""
    stream, written = SimpleNamespace(encode=lambda *frame: frame), []

    class Film:
        def __enter__(self) -> Film:
            return self

        def __exit__(self, *given: object) -> None: ...

        def add_stream(self, codec: str, rate: int) -> Any:
            written.append((codec, rate))
            return stream

        def mux(self, packet: Any) -> None:
            written.append(packet)

    frame = SimpleNamespace(from_image=lambda picture: (picture.getpixel((0, 0))[0], picture.size))
    av = SimpleNamespace(VideoFrame=frame, open=lambda buffer, mode, format: buffer.write(format.encode()) and Film())
    pictures = [Image.new("RGB", (33, 21), (k, 0, 0)) for k in range(9)]
    assert as_mp4(pictures, seconds, av) == b"mp4"
    assert written[0] == ("h264", rate)
    assert (stream.width, stream.height, stream.pix_fmt) == (32, 20, "yuv420p")
    assert written[-1] == ()
    frames = [one[0] for one in written[1:-1]]
    assert {size for _, size in frames} == {(32, 20)}
    numbers = [k for k, _ in frames]
    assert numbers == (shown if shown is not None else np.linspace(0, 8, 90).round().tolist())


def test_walls_of_grains_are_drawn_as_far_as_grains_go():
    """A wall through a point along its normal's left, beyond the grains' way by the largest radius, at every time."""
    rng = np.random.default_rng(2)
    path, point, normal = rng.normal(size=(5, 3, 2)), rng.normal(size=2), (3.0, -4.0)
    ends = drawn._wall(point, normal, path, 0.25)
    along = np.array((-4.0, -3.0)) / 5.0
    way = [(place - point) @ along for places in path for place in places]
    assert ends.shape == (5, 2, 2)
    for shown in ends:
        assert shown == pytest.approx(point + np.outer((min(way) - 0.25, max(way) + 0.25), along))
    scene = scenes.make("granular_column", search=True)
    (grains,) = (load for load in scene.loads if load.type == "granules")
    still = Trajectory(np.arange(2.0), *(np.stack((own, own)) for own in (
        np.array([body.position for body in scene.bodies]), np.zeros(len(scene.bodies)),
        np.zeros((len(scene.bodies), 2)), np.zeros(len(scene.bodies)))))  # fmt: skip
    found = drawing(scene, still)
    assert len(found.surfaces) == len(grains.walls)
    radius, half = grains.shapes(len(scene.bodies), 2)
    reach = radius + np.hypot(*np.transpose(half))
    assert sorted(size for _, size in found.circles) == pytest.approx(sorted(reach))


class Pen:
    """Notes what is drawn, and how."""

    def __init__(self) -> None:
        self.drawn: list[tuple[str, np.ndarray, dict[str, Any]]] = []

    def polygon(self, places: Any, **how: Any) -> None:
        self.drawn.append(("polygon", np.array(places), how))

    def line(self, places: Any, **how: Any) -> None:
        self.drawn.append(("line", np.array(places), how))

    def circle(self, place: Any, radius: float, **how: Any) -> None:
        self.drawn.append(("circle", np.array((*place, radius)), how))


@pytest.mark.parametrize("name", ["slider_crank", "spring_pendulum", "newtons_cradle"])
def test_bodies_are_drawn_where_they_are_and_the_ground_below_its_joints(name):
    scene = scenes.make(name)
    shown = drawing(scene, simulate(scene, Settings(samples=3, t_end=0.2, estimate="off", reactions=False)))
    camera, pen, k = Camera(shown), Pen(), 2
    camera._bodies(pen, shown, k)  # type: ignore[arg-type]
    polygons = [places for kind, places, _ in pen.drawn if kind == "polygon"]
    for pin, (top, *foot) in zip(shown.pins, polygons, strict=False):
        assert top == pytest.approx(camera(pin[k]))
        assert all(corner[1] > top[1] for corner in foot), "pixels count downwards"
        assert np.mean(foot, axis=0)[0] == pytest.approx(top[0])
    fills = polygons[len(shown.pins) :]
    for (_, corners), places in zip(shown.fills, fills, strict=True):
        assert places == pytest.approx(np.array([camera(corner) for corner in corners[k]]))
    circles = [(places, how) for kind, places, how in pen.drawn if kind == "circle"]
    wide = 2 * camera.scale
    for (place, radius), (drawn_, how) in zip(shown.circles, circles, strict=False):
        assert drawn_ == pytest.approx((*camera(place[k]), wide * radius))
        assert "outline" in how
    for centre, (drawn_, how) in zip(shown.centres[k], circles[len(shown.circles) :], strict=True):
        assert drawn_[:2] == pytest.approx(camera(centre))
        assert "fill" in how
    lines = [places for kind, places, _ in pen.drawn if kind == "line"]
    straight = [ends[k] for ends in (*shown.surfaces, *shown.radii)], [ends[k] for _, ends in shown.spokes]
    coils = lines[len(straight[0]) : len(straight[0]) + len(shown.springs)]
    for ends, places in zip(shown.springs, coils, strict=True):
        assert places[[0, -1]] == pytest.approx(np.array([camera(end) for end in ends[k]]))
    others = lines[: len(straight[0])] + lines[len(straight[0]) + len(shown.springs) :]
    for ends, places in zip([*straight[0], *straight[1]], others, strict=True):
        assert places == pytest.approx(np.array([camera(end) for end in ends]))


def test_the_one_coloured_body_of_many_has_its_colour_alone():
    scene = scenes.make("pendulum_chain", links=8)
    shown = drawing(scene, simulate(scene, Settings(samples=2, t_end=0.1, estimate="off", reactions=False)))
    pen = Pen()
    Camera(shown)._bodies(pen, shown, 0)  # type: ignore[arg-type]
    spokes = [how["fill"] for kind, _, how in pen.drawn if kind == "line"]
    assert shown.accent == 0
    assert len(spokes) == len(shown.spokes)
    assert [fill == files.ACCENT for fill in spokes] == [body == 0 for body, _ in shown.spokes]
    fills = [how["fill"] for kind, _, how in pen.drawn if kind == "polygon"][len(shown.pins) :]
    assert [fill == files.ACCENT_FILL for fill in fills] == [body == 0 for body, _ in shown.fills]


def test_grains_with_corners_are_drawn_as_large_as_the_sphere_around_them():
    scene = scenes.make("granular_column", search=True, space=True, shape="box", grains=3)
    (grains,) = (load for load in scene.loads if load.type == "granules")
    (half,), (radius,) = grains.half, grains.radius
    found = drawn._circles(grains, scene.bodies)
    assert [(name, place) for name, place, _ in found] == [(body.name, body.position) for body in scene.bodies]
    assert [size for _, _, size in found] == pytest.approx([radius + float(np.hypot(np.hypot(*half[:2]), half[2]))] * 3)


@pytest.mark.parametrize("k", [0, 2])
def test_a_picture_states_its_time_in_the_unit_of_the_whole_film_and_a_round_length(monkeypatch, k):
    """The bar ends 8 pixels from the right, 6 above the lower edge, and is as long as its words say."""
    texts: list[tuple[Any, str]] = []
    bars: list[tuple[float, ...]] = []
    pen = SimpleNamespace(line=lambda ends, **how: bars.append(ends), text=lambda at, text, **how: texts.append(
        (at, text)))  # fmt: skip
    monkeypatch.setattr(files.ImageDraw, "Draw", lambda image: pen)
    for name in ("_bodies", "_orbits"):
        monkeypatch.setattr(Camera, name, lambda *given: None)
    shown = replace(scenery(np.random.default_rng(3)), times=np.array([0.0, 7200.0, 10_800.0]))
    camera = Camera(shown)
    assert camera.picture(shown, k, "rk4").size == camera.size
    wide, high = camera.size
    length, words = round_length(0.3 * wide / camera.scale)
    assert [text for _, text in texts] == [words, f"t = {'0.0 h' if k == 0 else '3.0 h'}", "rk4"]
    (bar,) = bars
    assert bar == pytest.approx((2 * (wide - 8) - 2 * length * camera.scale, 2 * (high - 6), 2 * (wide - 8),
                                 2 * (high - 6)))  # fmt: skip
