"""One URDF, read by Pinocchio, MuJoCo, Drake and us: the same mass matrix, gravity and bias forces anywhere?

Damping, friction and shapes are no part of these; each reader gets the file without shapes, whose meshes need not be
there. Our mass matrix comes from the kinetic energy of the scene's bodies, our gravity from their height.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

from cross_checks.robots import RobotError
from cross_checks.robots.parity import Values, by_us, differences, joints_of, parity, readers
from reports.cli import main

pytest.importorskip("pinocchio")

from cross_checks.robots.pinocchio_ import by_pinocchio

ROBOT = Path(__file__).parents[2] / "data" / "two_links_and_a_slider.urdf"
REAL = ("ur_description/urdf/ur5_robot.urdf", "panda_description/urdf/panda.urdf", "z1_description/urdf/z1.urdf")
REFUSED = {REAL[1]: "mimics another"}  # by our own reader, and why; what is no part of these figures is left out
CRANE = ROBOT.parent / "crane.xml"


READERS = ("mujoco", "drake", "mbs_ref")


def reader_of(name: str):
    found = readers()[name]
    if isinstance(found, str):
        pytest.skip(found)
    return found


def without_shapes(path: Path, folder: Path, damage: float = 1.0) -> Path:
    """Write the file without shapes; `damage` multiplies the first mass, as a careless importer might."""
    tree = ElementTree.parse(path)
    for link in tree.getroot().iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    mass = next(tree.getroot().iter("mass"))
    mass.set("value", repr(float(mass.get("value", "0")) * damage))
    bare = folder / path.name
    tree.write(bare)
    return bare


def drawn(path: Path, seed: int) -> tuple[Values, Values]:
    """Return random joint values and rates for every joint that moves."""
    joints = ElementTree.parse(path).getroot().findall("joint")  # not those of transmissions
    names = [str(joint.get("name")) for joint in joints if joint.get("type") != "fixed"]
    dice = np.random.default_rng(seed)
    q, v = (dict(zip(names, dice.uniform(-1.0, 1.0, len(names)).tolist(), strict=True)) for _ in "qv")
    return q, v


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_small_robot_is_read_alike(reader, seed, tmp_path):
    path = without_shapes(ROBOT, tmp_path)
    q, v = drawn(path, seed)
    apart = differences(by_pinocchio(path, q, v), reader_of(reader)(path, q, v))
    assert apart["mass"] < 1e-12
    assert apart["gravity"] < (1e-8 if reader == "mbs_ref" else 1e-12)
    assert apart.get("bias", 0.0) < 1e-12


def test_a_wrong_mass_is_noticed(tmp_path):
    path = without_shapes(ROBOT, tmp_path)
    (tmp_path / "other").mkdir()
    q, v = drawn(path, 1)
    mine, theirs = by_pinocchio(path, q, v), by_us(without_shapes(ROBOT, tmp_path / "other", damage=1.01), q, v)
    assert max(differences(mine, theirs).values()) > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("file", REAL)
def test_real_robots_are_read_alike(file, reader, tmp_path):
    try:
        installed = distribution("example-robot-data")
    except PackageNotFoundError:
        pytest.skip("the extra `robots` is not installed")
    robots = Path(str(installed.locate_file("cmeel.prefix/share/example-robot-data/robots")))
    path = without_shapes(robots / file, tmp_path)
    q, v = drawn(path, 1)
    if reader == "mbs_ref" and file in REFUSED:
        with pytest.raises(RobotError, match=REFUSED[file]):
            reader_of(reader)(path, q, v)
        return
    theirs = reader_of(reader)(path, q, v)
    assert max(differences(by_pinocchio(path, q, v), theirs).values()) < 1e-8


@pytest.mark.parametrize(
    ("file", "alike"), [(ROBOT, {"mujoco", "pinocchio", "mbs_ref"}), (CRANE, {"mujoco", "mbs_ref"})]
)  # of several hinges of one body Pinocchio makes one joint, which bears none of their names
def test_these_readers_see_the_same_robot(file, alike):
    found = parity(file, 2, asked={name: reader_of(name) for name in alike})
    assert set(found.read) == alike
    assert found.differences == ()


def test_a_reader_that_sees_another_robot_is_named_with_the_joint_and_both_values(tmp_path):
    damaged = without_shapes(ROBOT, tmp_path, damage=1.01)
    path = Path(ROBOT)
    found = parity(path, 2, asked={"pinocchio": by_pinocchio, "careless": lambda _, q, v: by_pinocchio(damaged, q, v)})
    assert {one.quantity for one in found.differences} == {"mass", "gravity", "bias"}
    worst = found.differences[0]
    assert (worst.reader, worst.other) == ("careless", "pinocchio")
    assert set(worst.joints) <= set(joints_of(path))
    assert worst.here != worst.there


@pytest.mark.parametrize("height", [0.0, 1.0])
def test_drake_carries_the_first_of_two_hinges_at_its_parents_origin(height, tmp_path):
    """By hand: a box of 4 kg at (0.3, 0.1, 0.2) m turns about the body's y axis, whatever the body's height."""
    path = tmp_path / "two.xml"
    path.write_text(f"""<mujoco model="two"><worldbody><body name="a" pos="0 0 {height}">
        <joint name="first" type="hinge" axis="0 1 0"/><joint name="second" type="hinge" axis="1 0 0"/>
        <geom type="box" size=".2 .1 .05" pos=".3 .1 .2" density="500"/></body></worldbody></mujoco>""")
    still = {"first": 0.0, "second": 0.0}
    own = 4.0 / 3.0 * (0.2**2 + 0.05**2)
    assert reader_of("mujoco")(path, still, still).mass[0, 0] == pytest.approx(4.0 * (0.3**2 + 0.2**2) + own)
    assert by_us(path, still, still).mass[0, 0] == pytest.approx(4.0 * (0.3**2 + 0.2**2) + own, rel=1e-7)
    apart = 0.2 + height  # m, of the box above the axis that Drake 1.58 turns it about
    assert reader_of("drake")(path, still, still).mass[0, 0] == pytest.approx(4.0 * (0.3**2 + apart**2) + own)


def test_a_reader_that_refuses_says_why_and_the_others_answer():
    found = parity(ROBOT, 1, asked={"absent": "not installed: nothing", "mbs_ref": by_us, "pinocchio": by_pinocchio})
    assert found.refused == {"absent": "not installed: nothing"}
    assert found.read == ("mbs_ref", "pinocchio")


def test_the_command_compares_and_names_what_is_no_robot(tmp_path):
    done = CliRunner().invoke(main, ["parity", str(ROBOT), "--poses", "1"])
    assert done.exit_code == 0, done.output
    assert "compared with" in done.stdout
    other = tmp_path / "page.xml"
    other.write_text("<html/>")
    done = CliRunner().invoke(main, ["parity", str(other)])
    assert (done.exit_code, "expected: <robot> or <mujoco>" in done.stderr) == (2, True)
