"""Scene files: what is written reads back equal, and a mistake is named with its place."""

from __future__ import annotations

import math
import os
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbs_ref import scene as language
from mbs_ref import scenes
from mbs_ref.scene import toml as scene_file
from mbs_ref.scene.celestial import CelestialLoad
from mbs_ref.scene.contact import Granules, ProgressiveLaw, Wall
from mbs_ref.scene.messages import Problem
from mbs_ref.scene.signals import Constant, HalfSine, Harmonic, Polynomial, Table
from mbs_ref.scene.toml import SceneFileError, dumps, loads, read_scene, write_scene
from tests.mbs_ref.cores.every_spatial_part import every_part

finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=1e-300, max_value=1e150)
non_negative = st.floats(min_value=0.0, max_value=1e150)
pair = st.tuples(finite, finite)
direction = st.tuples(finite.filter(lambda x: abs(x) > 1e-100), finite.map(lambda y: y / 1e160))
text = st.text(st.characters(codec="utf-8"), max_size=30)
signal = st.one_of(
    st.builds(Constant, value=finite),
    st.lists(st.tuples(finite, finite), min_size=1, max_size=5, unique_by=lambda point: point[0])
    .map(sorted)
    .map(lambda points: Table(times=tuple(t for t, _ in points), values=tuple(v for _, v in points))),
    st.builds(HalfSine, peak=finite, duration=positive, start=finite),
    st.builds(Harmonic, amplitude=finite, omega=finite, phase=finite, offset=finite),
    st.builds(Polynomial, coefficients=st.lists(finite, min_size=1, max_size=5).map(tuple)),
)
ends = {"body_a": st.just("ground"), "body_b": st.just("anchor")}
marks = ends | {"point_a": pair, "point_b": pair}
level = st.sampled_from(["position", "velocity", "acceleration"])
coordinate = st.sampled_from(["x", "y", "angle"])


@st.composite
def numbered(draw, kinds, prefix, most=4):
    """Draw parts named after their place, as names must differ."""
    return tuple(
        kind(name=f"{prefix}{k}", **{field: draw(value) for field, value in fields.items()})
        for k, (kind, fields) in enumerate(draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=most)))
    )


ANCHOR = language.PlanarBody(name="anchor", mass=1.0, inertia=1.0)  # what joints and loads hold on to
BODIES = [
    (language.PlanarBody, dict(mass=positive, inertia=positive, position=pair, angle=finite, velocity=pair,
                               angular_velocity=finite)),
    (language.PlanarBody, dict(mass=positive, inertia=positive)),
    (language.PointMass, dict(mass=positive, position=pair, velocity=pair)),
]  # fmt: skip
JOINTS = [
    (language.Revolute, ends | {"point": pair, "point_b": st.none() | pair}),
    (language.Prismatic, ends | {"point": pair, "axis": direction}),
    (language.Weld, ends | {"point": pair, "point_b": st.none() | pair}),
    (language.Distance, marks | {"length": positive}),
    (language.CoordinateDrive, {"body": st.just("anchor"), "coordinate": coordinate, "motion": signal, "level": level}),
    (language.UserConstraint, marks | {"expression": st.sampled_from(["b.x - a.x * t", "hypot(b.y, 1) - b.angle"])}),
    (language.PointDrive, {"body": st.just("anchor"), "point": pair, "direction": direction, "motion": signal}),
]
LOADS = [
    (language.Force, {"body": st.just("anchor"), "point": pair, "vector": pair, "factor": signal,
                      "frame": st.sampled_from(["world", "body"])}),
    (language.Torque, {"body": st.just("anchor"), "torque": finite, "factor": signal}),
    (language.SpringDamper, marks | {"stiffness": non_negative, "damping": non_negative, "tension_only": st.booleans(),
                                     "rest_length": st.none() | non_negative}),
    (language.PointBushing, ends | {"point": pair, "stiffness": non_negative, "damping": non_negative}),
    (language.TorsionSpring, ends | {"stiffness": non_negative, "rest_angle": st.none() | finite}),
    (Granules, {"radius": st.tuples(positive),
                "law": st.builds(ProgressiveLaw, stiffness=positive, damping=non_negative),
                "walls": st.lists(st.builds(Wall, point=pair, normal=direction), max_size=2).map(tuple)}),
]  # fmt: skip
scene_strategy = st.builds(
    language.Scene,
    name=st.from_regex(r"[A-Za-z][A-Za-z0-9_.\-]{0,20}", fullmatch=True),
    description=text,
    source=text,
    duration=positive,
    gravity=pair,
    bodies=numbered(BODIES, "b").map(lambda found: (*found, ANCHOR)),
    joints=numbered(JOINTS, "j"),
    loads=numbered(LOADS, "l").filter(lambda found: sum(isinstance(load, Granules) for load in found) < 2),
    parameters=st.dictionaries(text, st.one_of(finite, st.integers(-(2**62), 2**62), text, st.booleans()), max_size=3),
)


@settings(max_examples=60, deadline=None)
@given(scene_strategy)
def test_what_is_written_reads_back_equal(scene):
    again = loads(dumps(scene))
    assert again == scene
    assert repr(again) == repr(scene)  # tells 1 from 1.0 and True, and 0.0 from -0.0


@pytest.mark.parametrize("name", scenes.names())
def test_every_scene_goes_through_a_file(name, tmp_path):
    scene = scenes.make(name)
    write_scene(scene, tmp_path / "scene.toml")
    assert read_scene(tmp_path / "scene.toml") == scene


SPATIAL = {
    type(part)
    for scene in (every_part(), scenes.make("bicycle"))
    for part in (*scene.bodies, *scene.joints, *scene.loads)
}


def test_every_spatial_part_reads_back_equal():
    scene = every_part()
    assert loads(dumps(scene)) == scene


def test_every_part_type_is_tried():
    tried = {kind for kind, _ in [*BODIES, *JOINTS, *LOADS]}
    every = {part for union in (language.Body, language.Joint, language.Load) for part in get_args(get_args(union)[0])}
    celestial = set(get_args(CelestialLoad))  # test_particles.py writes and reads those, in a scene in space
    assert tried | SPATIAL == every - {language.UserForce} - celestial


def test_defaults_are_left_out():
    written = dumps(scenes.make("pendulum"))
    assert "angular_velocity" not in written
    assert "type" in written


ROD = '[[bodies]]\ntype = "planar"\nname = "rod"\nmass = 1\ninertia = 0.1\n'


def problems_of(body: str) -> list[Problem]:
    with pytest.raises(SceneFileError) as caught:
        loads(f'name = "trial"\n{body}', file="trial.toml")
    assert all(line.startswith("trial.toml: ") for line in str(caught.value).splitlines())
    return list(caught.value.problems)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (ROD.replace("mass = 1", "mass = 0"), "bodies[0].mass (rod) = 0: must be greater than 0"),
        (ROD.replace("mass = 1", "mass = true"), "bodies[0].mass (rod) = True: must be a valid number"),
        (ROD.replace("mass = 1", 'mass = "1"'), "bodies[0].mass (rod) = '1': must be a valid number"),
        (ROD.replace("mass = 1", "mass = nan"), "bodies[0].mass (rod) = nan: must be a finite number"),
        (ROD.replace("mass = 1\n", ""), "bodies[0].mass (rod): is missing"),
        (ROD + "velocity = [0, inf]", "bodies[0].velocity[1] (rod) = inf: must be a finite number"),
        (ROD.replace('"planar"', '"plannar"'), "bodies[0].type (rod) = 'plannar': is no type allowed here; "
         "allowed: planar, spatial, point_mass; did you mean 'planar'?"),
        (ROD.replace('type = "planar"', ""), "bodies[0] (rod): needs a type; allowed: planar, spatial, point_mass"),
        ("bodies = 3", "bodies = 3: must be a list"),
        ("bodies = [3]", "bodies[0] = 3: must be a table"),
        ("parameters = {a = [1]}\n" + ROD, "parameters.a = [1]: must be a number, a text, true or false"),
        (ROD + '[[loads]]\ntype = "torque"\nname = "t"\nbody = "rod"\ntorque = 1\nfactor = {type = "tabel"}',
         "loads[0].factor.type (t) = 'tabel': is no type allowed here; "
         "allowed: constant, table, half_sine, harmonic, polynomial; did you mean 'table'?"),
        (ROD + '[[loads]]\ntype = "user_force"\nname = "f"\nfunction = "os.system"',
         "loads[0].type (f) = 'user_force': cannot be in a file: it is Python"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_place(body, expected):
    assert [str(problem) for problem in problems_of(body)] == [expected]


def test_an_unknown_field_suggests_the_closest():
    (problem,) = problems_of(ROD + "positon = [0, 0]")
    assert problem.path == "bodies[0].positon"
    assert "did you mean 'position'?" in problem.message
    assert "angular_velocity" in problem.message


def test_every_mistake_is_listed():
    found = problems_of("gravty = [0, 0]\nduration = -1\n" + ROD.replace("mass = 1", "mass = 0").replace("0.1", "nan"))
    assert {problem.path for problem in found} == {"gravty", "duration", "bodies[0].mass", "bodies[0].inertia"}


def test_a_mistake_between_parts_names_the_part():
    joint = '[[joints]]\ntype = "revolute"\nname = "pin"\nbody_a = "ground"\nbody_b = "rood"\npoint = [0, 0]'
    (problem,) = problems_of(ROD + joint)
    assert "pin" in str(problem)
    assert "'rood' is no body" in str(problem)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"a = = 3", r"is not TOML: .*line 1, column 5"),
        (b"\n\nname = x", r"is not TOML: .*line 3"),
        (b"name = '\xff'", "is not UTF-8 text"),
        (b"a = " + b"[" * 5000, "nested too deeply"),
        (b"a" + b".a" * 5000 + b" = 1", "nested too deeply"),
        (b"a = " + b"9" * 5000, "is not TOML"),
    ],
)
def test_what_is_no_toml_is_refused(content, complaint, tmp_path):
    file = tmp_path / "bad.toml"
    file.write_bytes(content)
    with pytest.raises(SceneFileError, match=complaint) as caught:
        read_scene(file)
    assert str(file) in str(caught.value)


def test_a_file_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(scene_file, "LARGEST_FILE", 2**20)
    file = tmp_path / "large.toml"
    file.write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(SceneFileError, match="larger than 1 MiB"):
        read_scene(file)


@pytest.mark.parametrize(("name", "complaint"), [("absent.toml", "No such file"), (".", "directory")])
def test_what_cannot_be_opened_is_named(name, complaint, tmp_path):
    with pytest.raises(SceneFileError, match=complaint):
        read_scene(tmp_path / name)


def test_a_users_function_is_not_written(tmp_path):
    force = language.UserForce(name="wind", function=math.sin)
    scene = scenes.make("pendulum").model_copy(update={"loads": (force,)})
    with pytest.raises(SceneFileError, match=r"loads\[0\] \(wind\): is the user's own Python function"):
        write_scene(scene, tmp_path / "scene.toml")
    assert os.listdir(tmp_path) == []


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    file = tmp_path / "scene.toml"
    write_scene(scenes.make("pendulum"), file)
    before = file.read_bytes()

    def no_space(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(SceneFileError, match="cannot be written: No space left"):
        write_scene(scenes.make("slider_crank"), file)
    assert file.read_bytes() == before
    assert os.listdir(tmp_path) == ["scene.toml"]
