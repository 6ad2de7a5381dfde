"""Scene files with parameters: what they build, and what is refused, with its place."""

from __future__ import annotations

import inspect
import math

import pytest
from click.testing import CliRunner

from mbs_ref import scenes
from mbs_ref.scene.base.expression import FUNCTIONS, evaluate
from mbs_ref.scene.toml import SceneFileError, builder, dumps, loads
from reports import inputs
from reports.cli import main

HANGING = """
# A bob hangs.
name = "hanging"
duration = "= 2 * period"
gravity = [0.0, -9.81]

[parameters]
length = { default = 0.5, gt = 0.0, le = 4.0 }
axis = { default = "x", among = ["x", "y"] }

[values]
period = "= 2 * pi * sqrt(length / 9.81)"
down = "= -length + 0 * period"

[[bodies]]
type = "point_mass"
name = "bob"
mass = 1.0
position = [0.0, "= down"]
velocity = [0.0, 0.0]

[[joints]]
type = "coordinate_drive"
name = "drive"
body = "bob"
coordinate = "= axis"
motion = { type = "constant", value = "= length**2 / (1 + length)" }
"""


def test_a_file_is_built_with_the_values_of_its_formulas():
    scene = loads(HANGING)
    assert scene.parameters == {"length": 0.5, "axis": "x"}
    assert scene.duration == 2.0 * (2.0 * math.pi * math.sqrt(0.5 / 9.81))
    other = scenes.build(builder(HANGING), "hanging", length=2.0, axis="y")
    assert other.bodies[0].position == (0.0, -2.0)
    assert (other.joints[0].coordinate, other.joints[0].motion.value) == ("y", 2.0**2 / 3.0)
    assert loads(dumps(other)) == other  # as built, without formulas


def test_its_parameters_are_those_of_a_function():
    signature = inspect.signature(builder(HANGING))
    assert {one.name: one.default for one in signature.parameters.values()} == {"length": 0.5, "axis": "x"}
    for given, words in (({"length": 5.0}, "less than or equal to 4"), ({"length": 0.0}, "greater than 0"),
                         ({"axis": "z"}, "'x' or 'y'"), ({"lenght": 1.0}, "did you mean 'length'")):  # fmt: skip
        with pytest.raises(ValueError, match=words):
            scenes.build(builder(HANGING), "hanging", **given)
    with pytest.raises(TypeError, match="unexpected keyword argument 'lenght'"):
        builder(HANGING)(lenght=1.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"= down"', '"= dwon"', r"bodies\[0\]\.position\[1\]: 'dwon' is not allowed.*length, axis, period, down"),
        ('"= down"', "\"= __import__('os')\"", r"position\[1\]: .* is not allowed"),
        ('"= down"', '"= length.real"', r"position\[1\]: 'length.real' is not allowed"),
        ('"= down"', '"= axis"', r"position\[1\].*number"),
        ("length / 9.81", "-length", r"values\.period: "),
        ("length / 9.81", "length / 0", r"values\.period: .*division by zero"),
        ("length / 9.81", "axis + axis", r"values\.period: axis = 'x' is no number"),
        ("[values]", "[values.deep]\nx = { y = '= axis + 1' }\n[values]", r"values\.deep\.x\.y: axis = 'x' is no"),
        ("[values]", "[requires]\nso = '= axis'\n[values]", r"parameters: so; given: length = 0\.5"),
        ("default = 0.5, gt", "default = 0.5, above", r"parameters\.length\.above: is no field"),
        ("default = 0.5, gt = 0.0, le = 4.0", "gt = 0.0", r"parameters\.length\.default: is missing"),
        ('default = "x"', 'default = "z"', r"parameters\.axis: default = 'z' is not within"),
        ("gt = 0.0, le = 4.0", "gt = 0.5", r"parameters\.length: default = 0\.5 is not within what is allowed"),
        ('"x", among = ["x", "y"]', '"x", gt = 0.0', r"parameters\.axis: default = 'x' is not within"),
        ('axis = { default = "x", among = ["x", "y"] }', 'axis = "x"', r"parameters\.axis = 'x': must be a table"),
        ("length = {", '"a b" = {', r"parameters\.a b: the name of a parameter"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_place(old, new, words):
    assert old in HANGING
    with pytest.raises(SceneFileError, match=words):
        loads(HANGING.replace(old, new))


BALL = """
name = "ball"
[parameters]
law = { default = "rigid", among = ["rigid", "soft", "none"] }
mu = { default = 0.0 }
pushed = { default = false }
[values]
floor = { choose = "= law", rigid = { type = "rigid_law", restitution = 0.5 }, soft = "= linear" }
linear = 1.0
[[bodies]]
type = "planar"
name = "ball"
mass = 1.0
inertia = 0.1
[[contacts]]
type = "circle_on_line"
name = "floor"
body_a = "ball"
center = [0.0, 0.0]
radius = 0.1
point_1 = [0.0, -0.1]
point_2 = [1.0, -0.1]
law = { type = "spring_damper_law", stiffness = 1e4 }
friction = { choose = "= mu", 0 = "none", otherwise = { type = "regularised_coulomb", coefficient = "= mu" } }
[[loads]]
choose = "= pushed"
true = { type = "torque", name = "push", body = "ball", torque = 1.0 }
false = "none"
"""


def test_a_choice_stands_for_the_entry_that_is_named():
    scene = loads(BALL)
    assert (scene.contacts[0].friction, scene.loads) == (None, ())
    other = scenes.build(builder(BALL), "ball", mu=0.3, pushed=True)
    assert other.contacts[0].friction.coefficient == 0.3
    assert [load.name for load in other.loads] == ["push"]
    chosen = loads(BALL.replace('law = { type = "spring_damper_law", stiffness = 1e4 }', 'law = "= floor"'))
    assert chosen.contacts[0].law.restitution == 0.5
    with pytest.raises(
        SceneFileError, match=r"values\.floor: choose = 'none' names none of its entries; there are rigid, soft"
    ):
        scenes.build(builder(BALL), "ball", law="none")


ROW = """
name = "row"
description = "{rods} rods, {mass} kg each."
[parameters]
rods = { default = 2, ge = 1 }
[values]
mass = 0.25
total = "= rods * mass"
[requires]
"{total} kg are too heavy" = "= 2 - total"
[[bodies]]
repeat = { k = "= rods", side = 2 }
values.x = "= k + 0.5 * side"
values.y = "= -x"
type = "planar"
name = "rod{k + 1}.{side}"
mass = "= mass"
inertia = 1.0
position = ["= x", "= y"]
[[joints]]
repeat = { k = "= rods" }
choose = "= k"
0 = "none"
otherwise = { type = "weld", name = "weld{k}", body_a = "rod{k}.0", body_b = "rod{k + 1}.1", point = [0.0, 0.0] }
"""


def test_a_repeated_item_stands_for_one_of_each_index():
    scene = scenes.build(builder(ROW), "row", rods=3)
    assert scene.description == "3 rods, 0.25 kg each."
    assert [body.name for body in scene.bodies] == ["rod1.0", "rod1.1", "rod2.0", "rod2.1", "rod3.0", "rod3.1"]
    assert [body.position[0] for body in scene.bodies] == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    assert scene.bodies[-1].position[1] == -2.5
    assert [joint.ends for joint in scene.joints] == [("rod1.0", "rod2.1"), ("rod2.0", "rod3.1")]
    with pytest.raises(SceneFileError, match=r"parameters: 2\.5 kg are too heavy; given: rods = 10"):
        scenes.build(builder(ROW), "row", rods=10)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [('side = 2', 'side = "= 0.5"', r"bodies\[0\]\.repeat: side = 0\.5 is no index; allowed"),
     ('side = 2', 'side = -1', r"side = -1 is no index"), ('side = 2', 'rods = 2', r"rods = 2 is no index"),
     ('side = 2', 'side = 1e9', r"side = 1000000000\.0 is no index"), ('side = 2', 'side = "two"', r"no index"),
     ('= { k = "= rods" }', '= 3', r"joints\[0\]\.repeat: must be a table"),
     ('values.x = "= k', 'values.x = "= j', r"bodies\[0\]\.values\.x: 'j' is not allowed.*rods, mass, total, k, side"),
     ("rod{k + 1}.{side}", "rod{j}", r"bodies\[0\]\.name: 'j' is not allowed")],
)  # fmt: skip
def test_a_mistake_in_a_repeated_item_is_named_with_its_place(old, new, words):
    assert old in ROW
    with pytest.raises(SceneFileError, match=words):
        loads(ROW.replace(old, new, 1))


def test_parameters_that_break_a_requirement_are_refused_with_its_sentence():
    text = HANGING.replace(
        "[values]", '[requires]\n"the cord must be longer than {0.4 / 2} m" = "= length - 0.2"\n\n[values]'
    )
    assert loads(text).parameters["length"] == 0.5
    with pytest.raises(
        SceneFileError, match=r"parameters: the cord must be longer than 0\.2 m; given: length = 0\.1, axis = 'x'"
    ):
        scenes.build(builder(text), "hanging", length=0.1)
    with pytest.raises(ValueError, match=r"does not rest.*restitution = 1\.0"):
        scenes.make("bouncing_ball", law="rigid", restitution=1.0, height=0.0, speed=0.0, gravity=9.81)
    with pytest.raises(ValueError, match=r"too slow for steady precession, which needs 56\.193 rad/s.*spin = 5\.0"):
        scenes.make("heavy_top", motion="steady", spin=5.0)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_of_numbers_is_that_of_its_name(name):
    given = (0.4, 0.3)[: FUNCTIONS[name].nin]  # type: ignore[attr-defined]
    assert evaluate(f"{name}({', '.join('xy'[: len(given)])})", {"x": 0.4, "y": 0.3}) == getattr(math, name)(*given)


def test_numbers_of_formulas_are_floats_and_python_stays_out():
    text = HANGING.replace(
        'axis = { default = "x", among = ["x", "y"] }', 'axis = { default = "x" }\nn = { default = 9 }'
    )
    with pytest.raises(SceneFileError, match=r"values\.period: .*too large|Result too large|out of range"):
        loads(text.replace("length / 9.81", "n**n**n**n"))
    force = '\n[[loads]]\nchoose = "= axis"\nx = { type = "user_force", name = "f", function = "f" }\n'
    with pytest.raises(SceneFileError, match="cannot be in a file: it is Python"):
        loads(HANGING + force)
    with pytest.raises(SceneFileError, match="values: must be a table"):
        loads(HANGING.replace("[values]", "[other]").replace("[parameters]", "values = 3\n[parameters]"))


def test_the_command_line_sets_the_parameters_of_a_file(tmp_path):
    file = tmp_path / "hanging.toml"
    file.write_text(HANGING, encoding="utf-8")
    scene = inputs.scene(str(file), ["length=2.0"])
    assert scene.parameters["length"] == 2.0
    rebuild = inputs.rebuilder(str(file), scene)
    assert rebuild is not None
    assert rebuild(axis="y").bodies[0].position == (0.0, -2.0)
    wrong = CliRunner().invoke(main, ["simulate", str(file), "-p", "length=9"])
    assert wrong.exit_code == 2
    assert "length = 9 is not allowed" in wrong.output


def test_what_a_scene_was_built_with_is_no_parameter_of_its_file(tmp_path):
    file = tmp_path / "kepler.toml"
    file.write_text(dumps(scenes.make("kepler")), encoding="utf-8")
    scene = inputs.scene(str(file))
    assert scene == scenes.make("kepler")
    assert inputs.rebuilder(str(file), scene) is None
    assert "is no parameter" in CliRunner().invoke(main, ["simulate", str(file), "-p", "orbits=2"]).output


def test_formulas_need_no_parameters():
    declared = HANGING[HANGING.index("[parameters]") : HANGING.index("[values]")]
    scene = loads(HANGING.replace(declared, "").replace("[values]", "[values]\nlength = 0.5\naxis = 'x'"))
    assert scene.bodies == builder(HANGING)().bodies
    bob = HANGING[HANGING.index("[[bodies]]") : HANGING.index("[[joints]]")].replace("down", "-pi / 6")
    free = loads(f'name = "bob"\ndescription = "= a {{brace}}"\n{bob}')  # no number has a name: a description is text
    assert (free.description, free.bodies[0].position[1]) == ("= a {brace}", -math.pi / 6)
    assert loads(dumps(free)) == free
