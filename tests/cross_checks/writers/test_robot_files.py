"""Scenes written as URDF and MJCF move, read back by the engines' parsers, as the scenes do."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks import writers
from cross_checks.writers.as_urdf import _remarks
from mbs_ref import scenes
from mbs_ref.scene import Bushing, Force, Prismatic, Revolute, Scene, SpatialBody, TorsionSpring
from mbs_ref.settings import Settings
from tests.cross_checks.engines.engine_runs import engine

RUN = Settings(method="rk4", step=1e-3, t_end=0.3, samples=4)
ROUNDOFF = 1e-12  # m, m/s after 300 steps
TURNED_AXES = 1e-10  # m: a file's moments stand along their own axes, and its body axes along those
UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a plane's x and y among the file's x, y, z


def crane() -> Scene:
    """Return a damped slide that carries a damped hinge, both askew."""
    along, about = (0.6, 0.8, 0.0), (0.0, -0.6, 0.8)
    inertia = (0.02, 0.03, 0.04, 0.001, 0.002, 0.003)
    rate = 2.0 * np.array(about)
    hub, tip = np.array([0.3, 0.4, 1.0]), np.array([0.5, 0.3, 0.9])
    return Scene(
        name="crane", gravity=(0.0, 0.0, -9.81),
        bodies=(
            SpatialBody(name="cart", mass=2.0, inertia=inertia, position=(0.2, 0.1, 1.0), velocity=(0.3, 0.4, 0.0)),
            SpatialBody(name="jib", mass=1.0, inertia=inertia, position=tuple(tip), orientation=(0.8, 0.0, 0.6, 0.0),
                        velocity=tuple(np.array([0.3, 0.4, 0.0]) + np.cross(rate, tip - hub)),
                        angular_velocity=tuple(rate)),
        ),
        joints=(
            Prismatic(name="rail", body_a="ground", body_b="cart", point=(0.0, 0.0, 1.0), axis=along),
            Revolute(name="slew", body_a="cart", body_b="jib", point=tuple(hub), axis=about),
        ),
        loads=(
            Bushing(name="rail_damper", body_a="ground", body_b="cart", point=(0.0, 0.0, 1.0), x_axis=along,
                    y_axis=(-0.8, 0.6, 0.0), stiffness=(0.0,) * 6, damping=(1.5, 0.0, 0.0, 0.0, 0.0, 0.0)),
            TorsionSpring(name="slew_damper", body_a="cart", body_b="jib", stiffness=0.0, damping=0.4, axis=about),
        ),
    )  # fmt: skip


def read_again(text: str, folder: Path) -> Scene:
    """Return the scene of a written URDF file, at the start that its remarks tell."""
    from cross_checks.robots.pinocchio_ import read_urdf

    (folder / "written.urdf").write_text(text)
    rates = re.findall(r"the rate of joint (\S+) is (\S+) -->", text)
    return read_urdf(folder / "written.urdf", {f"{joint}.rate": float(rate) for joint, rate in rates}).scene


@pytest.mark.parametrize("scene", [scenes.make("double_pendulum"), crane()], ids=lambda scene: scene.name)
def test_a_tree_as_urdf_moves_as_the_scene(scene, tmp_path):
    solver = engine("pinocchio")
    again = read_again(writers.write(scene, "urdf"), tmp_path)
    assert again.body_names == scene.body_names
    ours, theirs = solver.run(scene, RUN), solver.run(again, RUN)
    seen = np.eye(3) if scene.dimension == 3 else UP
    assert np.abs(ours.position - theirs.position @ seen.T).max() < ROUNDOFF
    assert np.abs(ours.velocity - theirs.velocity @ seen.T).max() < ROUNDOFF
    assert np.abs(ours.velocity[-1] - ours.velocity[0]).max() > 0.1


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("n_four_bar", "joint 'B1.left' closes a loop"),
        ("heavy_top", "joint 'pivot' is a ball joint"),
        ("pendulum", "body 'bob' is a particle"),
        ("bouncing_ball", "contact 'floor' has a law"),
        ("spring_pendulum", "load 'spring' is a spring_damper"),
        ("driven_pendulum", "joint 'drive' prescribes a motion"),
    ],
)
def test_what_urdf_has_not_is_named(name, named):
    with pytest.raises(writers.NotWritable) as told:
        writers.write(scenes.make(name), "urdf")
    assert named in str(told.value)


def test_all_that_urdf_has_not_is_named_at_once():
    scene = crane()
    push = Force(name="push", body="cart", point=(0.2, 0.1, 1.0), vector=(1.0, 0.0, 0.0))
    spring = scene.loads[1].model_copy(update={"stiffness": 3.0})
    with pytest.raises(writers.NotWritable, match=r"load 'push'.*gravity is \[0.0, -9.81, 0.0\]"):
        writers.write(scene.model_copy(update={"loads": (push,), "gravity": (0.0, -9.81, 0.0)}), "urdf")
    with pytest.raises(writers.NotWritable, match="load 'slew_damper' is not the damper of one joint alone"):
        writers.write(scene.model_copy(update={"loads": (spring,)}), "urdf")


def test_mjcf_has_all_digits_and_reads_back_as_the_mechanism(tmp_path):
    """A loop of six hinges at rest: a file's keyframe is no start of ours."""
    solver, scene = engine("mujoco"), scenes.make("bricard")
    from cross_checks.robots.mujoco_ import read_mjcf

    text = writers.write(scene, "mjcf", RUN)
    assert max(len(number) for number in re.findall(r"[\d.]+", text)) > 15
    (tmp_path / "written.xml").write_text(text)
    again = read_mjcf(tmp_path / "written.xml").scene
    order = [again.body_index(name) for name in scene.body_names]
    ours, theirs = solver.run(scene, RUN), solver.run(again, RUN)
    assert np.abs(ours.position - theirs.position[:, order]).max() < TURNED_AXES
    assert np.abs(ours.velocity[-1]).max() > 0.1


def test_every_rate_of_a_joint_is_stated_where_one_is_not_zero():
    links = [SimpleNamespace(joint=name, name=name, rates=np.array(rates))
             for name, rates in (("still", [0.0, 0.0]), ("half", [0.0, 2.5]), ("one", [-1.5]))]  # fmt: skip
    linkage: Any = SimpleNamespace(scene=scenes.make("heavy_top"), links=links)
    remarks = [line for line in _remarks(linkage, floating=False) if "at t = 0" in line]
    assert remarks == ["at t = 0 the rate of joint half is 0.0, 2.5", "at t = 0 the rate of joint one is -1.5"]
