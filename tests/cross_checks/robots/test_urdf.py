"""Robots from URDF: the scene moves as Pinocchio's own dynamics of the file does, in joint coordinates."""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

from mbs_ref.scene.euler_parameters import conjugate, product, rotation_vector
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports import inputs
from reports.cli import main

pinocchio = pytest.importorskip("pinocchio")

from cross_checks import engines  # noqa: E402
from cross_checks.robots.pinocchio_ import RobotError, read_urdf  # noqa: E402
from mbs_ref.observables.distance import largest, relative  # noqa: E402

ROBOT = Path(__file__).parents[2] / "data" / "two_links_and_a_slider.urdf"
START = {"shoulder": 0.3, "elbow": -0.5, "ram": 0.05, "elbow.rate": 1.0, "ram.rate": -0.2, "duration": 0.5}
DAMPING = {"shoulder": 0.3, "ram": 2.0}


def natively(path: Path, given: dict, duration: float, step: float, damping: dict[str, float]) -> np.ndarray:
    """Return the centres of mass (n, 3) at the end, by Pinocchio's articulated bodies and the classical RK4."""
    model = pinocchio.buildModelFromUrdf(str(path))
    data, q, v = model.createData(), pinocchio.neutral(model), np.zeros(model.nv)
    drag = np.zeros(model.nv)
    for i in range(1, model.njoints):
        joint, name = model.joints[i], model.names[i]
        turn = given.get(name, 0.0)
        q[joint.idx_q : joint.idx_q + joint.nq] = turn if joint.nq == 1 else (np.cos(turn), np.sin(turn))
        v[joint.idx_v], drag[joint.idx_v] = given.get(f"{name}.rate", 0.0), damping.get(name, 0.0)

    def slope(q, v):
        return pinocchio.aba(model, data, q, v, -drag * v)

    for _ in range(round(duration / step)):
        a = slope(q, v)
        vb = v + step / 2 * a
        b = slope(pinocchio.integrate(model, q, step / 2 * v), vb)
        vc = v + step / 2 * b
        c = slope(pinocchio.integrate(model, q, step / 2 * vb), vc)
        vd = v + step * c
        d = slope(pinocchio.integrate(model, q, step * vc), vd)
        q = pinocchio.integrate(model, q, step / 6 * (v + 2 * vb + 2 * vc + vd))
        v = v + step / 6 * (a + 2 * b + 2 * c + d)
    pinocchio.forwardKinematics(model, data, q)
    return np.array([data.oMi[i].act(model.inertias[i].lever) for i in range(1, model.njoints)])


def test_a_robot_moves_as_pinocchios_own_dynamics_of_the_file():
    scene = read_urdf(ROBOT, START).scene
    assert tuple(scene.body_names) == ("upper", "fore", "rod")
    path = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), np.array([0.0, 0.5]))
    assert path.ok, path.message
    np.testing.assert_allclose(path.position[-1], natively(ROBOT, START, 0.5, 1e-3, DAMPING), atol=1e-9)
    moved = np.abs(path.position[-1] - path.position[0]).max()
    assert moved > 0.1


def test_a_locked_joint_is_part_of_the_link_before_it():
    assert tuple(read_urdf(ROBOT, {"elbow": "locked"}).scene.body_names) == ("upper", "rod")


HEAVY = (
    '<link name="base"><inertial><mass value="3"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


def test_a_free_root_falls_with_all_that_hangs_on_it(tmp_path):
    with pytest.raises(RobotError, match="link 'base' moves and has no mass"):
        read_urdf(ROBOT, {"base": "free"})
    scene = read_urdf(changed(tmp_path, '<link name="base"/>', HEAVY), {"base": "free", "elbow.rate": 2.0}).scene
    assert len(scene.joints) == 3
    path = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), np.linspace(0.0, 0.5, 3))
    assert path.ok, path.message
    mass = np.array([body.mass for body in scene.bodies])
    centre = np.einsum("k,tkd->td", mass, path.position) / mass.sum()
    drift = np.einsum("k,kd->d", mass, path.velocity[0]) / mass.sum()
    fallen = centre[0] + np.outer(path.times, drift) + np.outer(0.5 * path.times**2, (0.0, 0.0, -9.81))
    np.testing.assert_allclose(centre, fallen, atol=1e-10)


def test_what_is_assumed_is_said():
    told = " ".join(read_urdf(ROBOT).assumed)
    for words in ("fixed to the ground", "do not collide", "no limits of place, rate or effort: shoulder, ram", "cap"):
        assert words in told


def changed(tmp_path: Path, old: str, new: str) -> Path:
    text = ROBOT.read_text()
    assert old in text
    target = tmp_path / "changed.urdf"
    target.write_text(text.replace(old, new))
    return target


@pytest.mark.parametrize(("old", "new", "said"), [
    ('<dynamics damping="0.3"/>', '<dynamics friction="0.1"/>', "joint 'shoulder' has dry friction of 0.1"),
    ('type="continuous"', 'type="floating"', "joint 'elbow' is floating; taken: revolute, continuous"),
    ('<axis xyz="0.6 0.0 0.8"/>', '<axis xyz="1 0 0"/><mimic joint="shoulder"/>', "joint 'elbow' mimics another"),
    ("<robot name", "<sdf name", "cannot be read as XML"),
    ('<mass value="0.5"/>', '<mass value="0.0"/>', "link 'rod' moves and has no mass"),
    ('ixx="0.004" iyy="0.02" izz="0.02"', 'ixx="0.004" iyy="0.02" izz="0.2"', "exceeds the sum of the others"),
])  # fmt: skip
def test_what_no_scene_holds_is_refused_by_name(old, new, said, tmp_path):
    with pytest.raises(RobotError, match=re.escape(said)):
        read_urdf(changed(tmp_path, old, new))


def test_friction_and_damping_are_left_out_where_asked(tmp_path):
    rubbed = changed(tmp_path, '<dynamics damping="0.3"/>', '<dynamics damping="0.3" friction="0.1"/>')
    robot = read_urdf(rubbed, {"ignore": "friction,damping"})
    assert robot.scene.loads == ()
    assert robot.assumed[-2:] == ("left out: friction of shoulder", "left out: damping of shoulder, ram")
    assert [load.name for load in read_urdf(rubbed, {"ignore": "friction"}).scene.loads] == [
        "shoulder_damping", "ram_damping",
    ]  # fmt: skip
    with pytest.raises(RobotError, match="-p ignore=limits: allowed: damping, friction"):
        read_urdf(rubbed, {"ignore": "limits"})


def test_an_unknown_joint_is_refused_with_a_hint():
    with pytest.raises(RobotError, match="no joint has that name; did you mean 'elbow'"):
        read_urdf(ROBOT, {"elbw": 1.0})


def test_the_command_line_takes_a_robot_and_says_what_it_assumes():
    done = CliRunner().invoke(main, ["simulate", str(ROBOT), "-p", "elbow=0.2", "--t-end", "0.1", "--no-truth"])
    assert done.exit_code == 0, done.output
    assert "assumed: links do not collide" in done.stderr
    done = CliRunner().invoke(main, ["simulate", str(ROBOT), "-p", "knee=0.2"])
    assert done.exit_code == 2
    assert "-p knee: no joint has that name" in done.output


def test_a_file_that_is_not_there_or_has_another_suffix_says_what_to_do(tmp_path):
    (tmp_path / "arm.urdf").write_text(ROBOT.read_text())
    done = CliRunner().invoke(main, ["simulate", str(tmp_path / "amr.urdf")])
    assert done.exit_code == 2
    assert "there is no such file; did you mean 'arm.urdf'?; robots there: arm.urdf" in done.output
    (tmp_path / "empty").mkdir()
    done = CliRunner().invoke(main, ["simulate", str(tmp_path / "empty" / "arm.urdf")])
    assert "there is no such file; no .urdf or .xml file is there" in " ".join(done.output.split())
    (tmp_path / "arm.txt").write_text(ROBOT.read_text())
    done = CliRunner().invoke(main, ["simulate", str(tmp_path / "arm.txt")])
    assert done.exit_code == 2
    assert "a robot in .urdf" in " ".join(done.output.split())


STARTED = """
duration = 0.5
[joints]
elbow = -0.5
ram = "locked"
[rates]
shoulder = 1.0
elbow = 0.6
[drives.elbow]
type = "harmonic"
amplitude = 0.3
omega = 2.0
"""


def test_a_start_file_poses_the_robot_and_drives_its_hinges(tmp_path):
    """The driven hinge turns by the motion's own closed form, whatever the other link does."""
    (tmp_path / "start.toml").write_text(STARTED)
    scene = inputs.scene(str(ROBOT), [f"start={tmp_path / 'start.toml'}", "shoulder=0.3"])
    assert [joint.type for joint in scene.joints] == ["revolute", "revolute", "rotation_drive"]
    path = simulate(scene, Settings(rtol=1e-10, samples=6, estimate="off"))
    assert path.ok, path.message
    between = product(conjugate(path.orientation[:, 0]), path.orientation[:, 1])
    turned = np.linalg.norm(rotation_vector(product(between, conjugate(between[0]))), axis=-1)
    assert np.allclose(turned, 0.3 * np.sin(2.0 * path.times), atol=1e-8)
    assert np.linalg.norm(path.angular_velocity[-1, 0] - path.angular_velocity[0, 0]) > 0.1


@pytest.mark.parametrize(("old", "new", "said"), [
    ("[rates]", "[speeds]", "[speeds] is no table here; allowed: joints, rates, drives"),
    ("[drives.elbow]", "[drives.elbw]", "[drives.elbw] is of no hinge; did you mean 'elbow'?; hinges are shoulder"),
    ('type = "harmonic"', 'type = "harmonics"', "motion"),
    ("elbow = -0.5", "elbo = -0.5", "no joint has that name; did you mean 'elbow'"),
])  # fmt: skip
def test_a_mistake_in_a_start_file_is_named(old, new, said, tmp_path):
    (tmp_path / "start.toml").write_text(STARTED.replace(old, new))
    with pytest.raises(click.UsageError, match=re.escape(said)):
        inputs.scene(str(ROBOT), [f"start={tmp_path / 'start.toml'}"])


REAL = {
    "ur_description/urdf/ur5_robot.urdf": {},
    "panda_description/urdf/panda.urdf": {"panda_finger_joint2": "locked", "panda_joint2": 0.4, "panda_joint4": -1.0},
    "anymal_b_simple_description/robots/anymal.urdf": {"base": "free", "LF_KFE.rate": 2.0, "RH_HAA.rate": -1.0},
    "talos_data/robots/talos_reduced.urdf": {"ignore": "friction", "arm_left_2_joint": 0.5, "leg_right_4_joint": 1.0},
}


@pytest.mark.slow
@pytest.mark.parametrize("file", REAL)
def test_real_robots_move_alike_in_every_engine(file):
    try:
        installed = distribution("example-robot-data")
    except PackageNotFoundError:
        pytest.skip("the extra `robots` is not installed")
    robots = Path(str(installed.locate_file("cmeel.prefix/share/example-robot-data/robots")))
    scene = read_urdf(robots / file, REAL[file]).scene
    times, fine = np.linspace(0.0, 1.0, 11), {"pinocchio": ("dop853", 1e-11, None), "mujoco": ("rk4", None, 2.5e-4)}
    ours = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), times)
    assert ours.ok, ours.message
    for name, (method, rtol, step) in fine.items():
        engine = engines.get(name)
        if not engine.refusals(scene):
            given = Settings(method=method, step=step) if rtol is None else Settings(method=method, rtol=rtol)
            theirs = engine.run(scene, given, times)
            assert theirs.ok, theirs.message
            assert largest(relative(scene, ours, theirs)) < 1e-6


def test_names_that_no_scene_allows_are_made_plain(tmp_path):
    """Other tools write spaces, slashes and digits first; -p takes the file's own names."""
    text = ROBOT.read_text().replace('"upper"', '"left arm/upper"').replace('"elbow"', '"2.elbow"')
    text = text.replace('"rod"', '"ground"')
    (tmp_path / "2 links.urdf").write_text(text)
    scene = read_urdf(tmp_path / "2 links.urdf", {"2.elbow": 0.2}).scene
    assert (scene.name, scene.body_names) == ("n2_links", ["left_arm_upper", "fore", "ground_"])
    assert [joint.name for joint in scene.joints] == ["shoulder", "n2.elbow", "ram"]
