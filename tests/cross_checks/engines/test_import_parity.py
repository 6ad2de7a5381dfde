"""One URDF, read by Pinocchio, MuJoCo, Drake and us: the same mass matrix, gravity and bias forces anywhere?

Damping, friction and shapes are no part of these; each reader gets the file without shapes, whose meshes need not be
there. Our mass matrix comes from the kinetic energy of the scene's bodies, our gravity from their height.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest

from cross_checks.workshop.initial_state import initial_sample
from mbs_ref.observables import kinetic_energy, potential_energy

pinocchio = pytest.importorskip("pinocchio")

from cross_checks.engines.pinocchio_.urdf import RobotError, read_urdf  # noqa: E402

ROBOT = Path(__file__).parents[2] / "data" / "two_links_and_a_slider.urdf"
REAL = ("ur_description/urdf/ur5_robot.urdf", "panda_description/urdf/panda.urdf", "z1_description/urdf/z1.urdf")
REFUSED = {REAL[1]: "mimics another", REAL[2]: "dry friction"}  # by our own reader, and why
GRAVITY = 9.81  # m/s^2
NUDGE = 1e-5  # rad, m: of a central difference, whose error is its square


class Dynamics(NamedTuple):
    """What moves a robot's joints, in the order of their names: SI units."""

    mass: np.ndarray  # (n, n)
    gravity: np.ndarray  # (n,) what holds it still
    bias: np.ndarray | None  # (n,) gravity and what its motion costs; None of a reader that does not say


Values = dict[str, float]  # by joint name


def by_pinocchio(path: Path, q: Values, v: Values) -> Dynamics:
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    index = [model.joints[model.getJointId(name)].idx_v for name in q]
    turned, rates = np.zeros((2, model.nv))
    turned[index], rates[index] = list(q.values()), list(v.values())
    places = pinocchio.integrate(model, pinocchio.neutral(model), turned)
    upper = np.triu(pinocchio.crba(model, data, places))
    mass = upper + np.triu(upper, 1).T
    gravity = pinocchio.computeGeneralizedGravity(model, data, places).copy()
    bias = pinocchio.nonLinearEffects(model, data, places, rates).copy()
    return Dynamics(mass[np.ix_(index, index)], gravity[index], bias[index])


def by_mujoco(path: Path, q: Values, v: Values) -> Dynamics:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    index = [int(model.joint(name).dofadr[0]) for name in q]
    places = [int(model.joint(name).qposadr[0]) for name in q]
    data.qpos[places] = list(q.values())
    mujoco.mj_forward(model, data)
    gravity, mass = data.qfrc_bias.copy(), np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    data.qvel[index] = list(v.values())
    mujoco.mj_forward(model, data)
    return Dynamics(mass[np.ix_(index, index)], gravity[index], data.qfrc_bias[index].copy())


def by_drake(path: Path, q: Values, v: Values) -> Dynamics:
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser  # pyright: ignore[reportMissingImports]
    from pydrake.multibody.plant import MultibodyPlant  # pyright: ignore[reportMissingImports]

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    if (root := base_of(path)) != "world":  # which Drake takes for its own
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name) for name in q]
    places, rates = np.zeros(plant.num_positions()), np.zeros(plant.num_velocities())
    index = [joint.velocity_start() for joint in joints]
    places[[joint.position_start() for joint in joints]], rates[index] = list(q.values()), list(v.values())
    plant.SetPositions(context, places)
    plant.SetVelocities(context, rates)
    mass = plant.CalcMassMatrix(context)
    gravity = -plant.CalcGravityGeneralizedForces(context)
    return Dynamics(mass[np.ix_(index, index)], gravity[index], (plant.CalcBiasTerm(context) + gravity)[index])


def base_of(path: Path) -> str:
    """Return the link that no joint carries."""
    robot = ElementTree.parse(path).getroot()
    carried = {child.get("link") for child in robot.iter("child")}
    (base,) = (str(link.get("name")) for link in robot.findall("link") if link.get("name") not in carried)
    return base


def by_us(path: Path, q: Values, v: Values) -> Dynamics:
    def energy(places: Values, rates: Values) -> tuple[float, float]:
        scene = read_urdf(path, {**places, **{f"{name}.rate": rate for name, rate in rates.items()}}).scene
        scene, start = scene.model_copy(update={"loads": ()}), initial_sample(scene)
        return float(kinetic_energy(scene, start)[0]), float(potential_energy(scene, start)[0])

    names = list(q)
    one = [energy(q, {name: 1.0})[0] for name in names]
    mass = np.diag(one) * 2.0
    for i, a in enumerate(names):
        for j, b in enumerate(names[:i]):
            mass[i, j] = mass[j, i] = energy(q, {a: 1.0, b: 1.0})[0] - one[i] - one[j]
    height = [[energy(q | {name: q[name] + side * NUDGE}, {})[1] for side in (1.0, -1.0)] for name in names]
    return Dynamics(mass, np.array([(up - down) / (2.0 * NUDGE) for up, down in height]), None)


READERS: dict[str, Callable[[Path, Values, Values], Dynamics]] = {
    "mujoco": by_mujoco, "drake": by_drake, "mbs_ref": by_us,
}  # fmt: skip


def differences(mine: Dynamics, theirs: Dynamics) -> dict[str, float]:
    """Return by how much the two differ, over the largest entry; only what both say."""
    pairs = {name: (getattr(mine, name), getattr(theirs, name)) for name in Dynamics._fields}
    return {
        name: float(np.abs(a - b).max() / np.abs(a).max())
        for name, (a, b) in pairs.items()
        if a is not None and b is not None
    }


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
    apart = differences(by_pinocchio(path, q, v), READERS[reader](path, q, v))
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
            READERS[reader](path, q, v)
        return
    theirs = READERS[reader](path, q, v)
    assert max(differences(by_pinocchio(path, q, v), theirs).values()) < 1e-8
