"""Models from MJCF: the scene moves as MuJoCo's own dynamics of the file does, in joint coordinates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from mbs_ref.scene import Revolute, Spherical, Universal
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.cli import main

mujoco = pytest.importorskip("mujoco")

from cross_checks import engines  # noqa: E402
from cross_checks.robots import RobotError  # noqa: E402
from cross_checks.robots.mujoco_ import read_mjcf  # noqa: E402

CRANE = Path(__file__).parents[2] / "data" / "crane.xml"
START = {"swing": 0.4, "sway": -0.2, "pitch": 0.3, "slew": 0.5, "reach": 0.05}
RATES = {"slew": 1.0, "twist": -2.0, "yaw": 0.7, "rail": 0.4}
FOUR_BAR = """
<mujoco><worldbody>
  <body name="left">
    <joint name="l" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 1" size=".03"/>
    <body name="top" pos="0 0 1">
      <joint name="t" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 1 0 0" size=".03"/>
    </body>
  </body>
  <body name="right" pos="1 0 0">
    <joint name="r" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 1" size=".03"/>
  </body>
</worldbody><equality><connect name="pin" body1="top" body2="right" anchor="1 0 0"/></equality></mujoco>
"""


def natively(duration: float, step: float) -> tuple[dict[str, np.ndarray], float]:
    """Return the centres of the bodies' masses at the end by MuJoCo's RK4 in joint coordinates."""
    spec = mujoco.MjSpec.from_file(str(CRANE))
    spec.option.timestep, spec.option.integrator = step, mujoco.mjtIntegrator.mjINT_RK4
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, value in START.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    for name, value in RATES.items():
        data.qvel[model.joint(name).dofadr[0]] = value
    for _ in range(round(duration / step)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    centres = {model.body(b).name: data.xipos[b].copy() for b in range(1, model.nbody)}
    jib, weight = model.body("jib").id, model.body("counterweight").id
    mass = model.body_mass
    both = mass[jib] * data.xipos[jib] + mass[weight] * data.xipos[weight]
    return centres | {"jib": both / (mass[jib] + mass[weight])}, float(data.qpos[model.joint("reach").qposadr[0]])


def test_a_model_moves_as_mujocos_own_dynamics_of_the_file():
    given = START | {f"{name}.rate": value for name, value in RATES.items()}
    scene = read_mjcf(CRANE, given).scene
    assert tuple(scene.body_names) == ("carriage", "jib", "hook", "load", "arm", "ram", "stone")
    path = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), np.array([0.0, 0.5]))
    assert path.ok, path.message
    ends, reach = natively(0.5, 2.5e-4)
    assert abs(reach - START["reach"]) > 0.05, "all that can move does"
    for name, end in zip(scene.body_names, path.position[-1], strict=True):
        assert np.abs(end - ends[name]).max() < 1e-8, name


def test_the_joints_are_those_that_hinges_make_together():
    joints = {joint.body_b: joint for joint in read_mjcf(CRANE).scene.joints}
    assert isinstance(joints["hook"], Universal)
    assert isinstance(joints["arm"], Spherical)
    assert isinstance(joints["jib"], Revolute)
    assert "stone" not in joints
    assert len(read_mjcf(CRANE, {"flight": "locked"}).scene.bodies) == 6


def test_an_equality_that_connects_closes_a_loop(tmp_path):
    scene = read_mjcf(written(tmp_path, FOUR_BAR)).scene
    (pin,) = [joint for joint in scene.joints if joint.name == "pin"]
    assert isinstance(pin, Spherical)
    assert pin.point == pytest.approx((1.0, 0.0, 1.0))


def written(tmp_path: Path, text: str) -> Path:
    target = tmp_path / "model.xml"
    target.write_text(text)
    return target


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name="slew" type="hinge"', 'name="slew" type="hinge" armature=".1"', "armature) of slew; -p ignore=armature"),
        ('name="slew" type="hinge"', 'name="slew" type="hinge" frictionloss=".1"', "dry friction of slew"),
        ('name="swing" type="hinge"', 'name="swing" type="hinge" damping="1"', "several joints of a body: swing"),
        ('"sway" type="hinge" axis="1 0 0"', '"sway" type="hinge" axis="1 1 0"', "'swing' turns, 'sway' turns"),
        ('timestep="0.002"', 'timestep="0.002" viscosity="1"', "moves in a fluid"),
        ("</worldbody>", '</worldbody><equality><joint joint1="reach" joint2="twist"/></equality>', "couples joints"),
        ("<mujoco", "<robot", "MuJoCo cannot read it"),
    ],
)  # fmt: skip
def test_what_no_scene_holds_is_refused_by_name(tmp_path, old, new, said):
    text = CRANE.read_text()
    assert old in text
    with pytest.raises(RobotError) as error:
        read_mjcf(written(tmp_path, text.replace(old, new, 1)))
    assert said in str(error.value)


def test_an_open_loop_is_refused_with_its_gap(tmp_path):
    open_at_the_pin = FOUR_BAR.replace('name="right" pos="1 0 0"', 'name="right" pos="1.1 0 0"')
    assert read_mjcf(written(tmp_path, open_at_the_pin)), "MuJoCo takes the second mark from the pose of the file"
    with pytest.raises(RobotError, match="open at the start by 0"):
        read_mjcf(written(tmp_path, FOUR_BAR), {"l": 0.3})


def test_what_is_ignored_and_assumed_is_said(tmp_path):
    told = " ".join(read_mjcf(CRANE).assumed)
    assert "slew have some in the file" in told
    assert "as the ball that they make away from gimbal lock: arm" in told
    assert "carry them: counterweight" in told
    stiff = CRANE.read_text().replace('name="slew" type="hinge"', 'name="slew" type="hinge" armature=".1"')
    ignored = read_mjcf(written(tmp_path, stiff), {"ignore": "armature", "knot": "locked"})
    assert "left out: rotor inertia (armature) of slew" in " ".join(ignored.assumed)
    assert "locked in their zero pose: knot" in " ".join(ignored.assumed)


def test_names_that_nothing_has_are_refused():
    with pytest.raises(RobotError, match=r"-p slow: no joint has that name.*slew"):
        read_mjcf(CRANE, {"slow": 1.0})
    with pytest.raises(RobotError, match="-p ignore=drag: allowed: armature"):
        read_mjcf(CRANE, {"ignore": "drag"})


def test_every_command_takes_a_model():
    done = CliRunner().invoke(main, ["simulate", str(CRANE), "--t-end", "0.05", "--no-truth"])
    assert done.exit_code == 0, done.output
    assert "assumed: shapes do not collide, and no actuator acts" in done.stderr


def test_three_engines_agree_on_the_scene_of_a_model(tmp_path):
    rigid = CRANE.read_text().replace(' damping="2" stiffness="30"', "")
    scene = read_mjcf(written(tmp_path, rigid), START | {"slew.rate": 1.0, "duration": 0.3}).scene
    times = np.array([0.0, 0.3])
    ours = simulate(scene, Settings(method="dop853", rtol=1e-11, estimate="off"), times)
    by_step, by_tolerance = Settings(method="rk4", step=2.5e-4), Settings(method="dop853", rtol=1e-11)
    for name, settings in (("mujoco", by_step), ("pinocchio", by_tolerance)):
        if name == "pinocchio":
            pytest.importorskip("pinocchio")
        theirs = engines.get(name).run(scene, settings, times)
        assert theirs.ok, theirs.message
        assert np.abs(theirs.position - ours.position).max() < 1e-8, name


def test_names_that_no_scene_allows_are_made_plain(tmp_path):
    """Composed models have slashes in their names; -p takes the file's own names."""
    text = CRANE.read_text().replace('name="slew"', 'name="crane/slew"')
    (tmp_path / "my crane.xml").write_text(text)
    scene = read_mjcf(tmp_path / "my crane.xml", {"crane/slew": 0.2}).scene
    assert scene.name == "my_crane"
    assert "crane_slew" in [joint.name for joint in scene.joints]
