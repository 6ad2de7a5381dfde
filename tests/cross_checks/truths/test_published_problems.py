"""Scenes whose end is published elsewhere: how many of the published digits the truth and the solver hold."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge.ladder import SAMPLES
from cross_checks.truths import truth_for
from cross_checks.truths.of import sky
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scenes.robot_arms import ARMS, frames_at, pose_at
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

FOOT, SPIN = 0.3048, 7.292115e-5  # m; rad/s, of the Earth
R_EARTH = 6_371_007.1809  # m, mean radius of the check cases


def both(scene: Scene, samples: int, **settings) -> tuple[Truth, Trajectory]:
    """Return the truth and the solver's motion at even samples; both must exist."""
    times = np.linspace(0.0, scene.duration, samples)
    truth = truth_for(scene, times)
    assert truth is not None
    path = simulate(scene, Settings(estimate="off", **settings), times)
    assert path.ok
    return truth, path


# Test Set for Initial Value Problem Solvers, release 2.4, andrews, t = 0.03 s; its own accuracy is about 1e-9 rad.
ANDREWS = {
    "beta": 15.81077119629904, "Theta": -15.75637105984298, "gamma": 0.04082224013073101, "Phi": -0.5347301163226948,
    "delta": 0.5244099658805304, "Omega": 0.5347301163226948, "epsilon": 1.048080741042263,
}  # fmt: skip
HOLDS = 2e-9  # rad
OUT = 1.1e-9  # rad: the published angles are so far from the enclosure, by a theorem


def published_angles() -> np.ndarray:
    q = ANDREWS
    return np.array([q["beta"], q["beta"] + q["Theta"], q["gamma"], q["Phi"] + q["delta"], q["delta"],
                     q["Omega"] + q["epsilon"], q["epsilon"]])  # fmt: skip


def apart(first: np.ndarray, second: np.ndarray) -> float:
    """Return the largest angle between, whole turns apart, rad."""
    return float(np.max(np.abs(np.remainder(first - second + np.pi, 2.0 * np.pi) - np.pi)))


def test_andrews_squeezer_ends_at_the_published_angles():
    scene = scenes.make("andrews")
    truth, path = both(scene, SAMPLES, method="dop853", rtol=1e-12)
    assert (truth.kind, truth.uncertainty < 1e-14) == ("proven", True)
    assert apart(truth.orientation[-1], published_angles()) == pytest.approx(OUT, rel=0.1)
    assert apart(path.orientation[-1], published_angles()) < HOLDS
    assert np.max(np.abs(path.position - truth.position)) < 1e-11  # m; of recomputed values
    assert path.orientation[-1, 0] > 5.0 * np.pi  # two and a half turns of the crank


# The same test set, car axis, t = 3 s, in quadruple precision: left and right end, m. The left end's height is out of
# the enclosure by 1.6e-13 m, whether numbers are those of binary64 or the decimals.
CAR_AXIS = (0.0493455784275402809122, 0.496989460230171153861, 1.04174252488542151681, 0.373911027265361256927)


def test_the_car_axis_ends_at_the_published_place_and_keeps_its_constraints():
    scene = scenes.make("car_axis")
    truth, path = both(scene, SAMPLES, method="dop853", rtol=1e-12)
    for motion in (truth, path):
        np.testing.assert_allclose(motion.position[-1, 1:].ravel(), CAR_AXIS, rtol=0.0, atol=1e-11)
        road, left, right = np.moveaxis(motion.position, 1, 0)
        assert np.max(np.abs(np.sum(road * left, axis=1))) < 1e-13  # m^2: the left end is square above the left wheel
        assert np.max(np.abs(np.linalg.norm(right - left, axis=1) - 1.0)) < 1e-13
    assert (truth.kind, truth.uncertainty < 1e-15) == ("proven", True)
    gaps = np.abs(truth.position[-1, 1:].ravel() - CAR_AXIS)
    assert (gaps.argmax(), gaps.max()) == (1, pytest.approx(1.63e-13, rel=0.01))


def test_the_published_pleiades_are_at_the_proven_places():
    scene = scenes.make("pleiades")
    truth = truth_for(scene, np.linspace(0.0, scene.duration, SAMPLES))
    assert truth is not None
    assert truth.kind == "proven"
    np.testing.assert_allclose(truth.position[-1], np.column_stack((sky.X, sky.Y, np.zeros(7))), rtol=0.0, atol=2e-15)


# NASA's atmospheric check cases 4 (an Earth at rest) and 5 (a turning one): altitude at 30 s, ft, of simulations 4, 5,
# 6 and 2 (files Atmos_04_* and Atmos_05_* of the NASA Engineering and Safety Center, theirs to give; four figures each
# are quoted), and how far ours may be off: what the simulators differ among themselves. The fourth
# begins at 0.01 ft/s and falls with 32.08 ft/s^2 in place of 32.13.
NESC_ALTITUDES = {
    0.0: (16231.3059243, 16231.30690887943, 16231.316664878279, 16249.4161),
    SPIN: (16276.3845488, 16276.385525826365, 16276.395223338157, 16294.5521),
}
NESC_APART = (1e-4, 2e-3, 2e-2, 20.0)  # ft


@pytest.mark.parametrize("spin", NESC_ALTITUDES, ids=["case 4", "case 5"])
def test_the_sphere_in_air_ends_where_nasas_simulators_say(spin):
    scene = scenes.make("nesc_sphere_in_air", spin=spin)
    truth, path = both(scene, 4, method="gauss", rtol=1e-13)
    for motion in (truth, path):
        altitude = (np.linalg.norm(motion.position[-1, 1]) - R_EARTH) / FOOT
        apart = np.abs(altitude - np.array(NESC_ALTITUDES[spin]))
        assert np.all(apart < NESC_APART), apart


# Published closed forms: Euler's disk, and the force of Painleve's rod (Genot and Brogliato 1999)
@pytest.mark.parametrize("tilt", [20.0, 60.0])
def test_eulers_disk_precesses_steadily_about_its_resting_centre(tilt):
    scene = scenes.make("euler_disk", tilt=tilt)
    truth, path = both(scene, SAMPLES, method="dop853", rtol=1e-10)
    assert np.abs(path.position - truth.position).max() < 1e-11  # m
    turned = np.abs(np.einsum("tbk,tbk->tb", path.orientation, truth.orientation))
    assert np.abs(turned - 1.0).max() < 1e-12
    rate = np.sqrt(4.0 * 9.81 / (0.0375 * np.sin(np.radians(tilt))))
    assert path.angular_velocity[0, 0] @ (0.0, 0.0, 1.0) == pytest.approx(rate * np.sin(np.radians(tilt)) ** 2)


@pytest.mark.parametrize(("friction", "p"), [(0.5, 1.75), (2.5, -1.25)])
def test_the_force_on_painleves_rod_swings_or_grows_as_p_says(friction, p):
    """On springs m d'' = m g - p k d: about the rigid force m g / p where p > 0, away from it else."""
    scene = scenes.make("painleve_rod", friction=friction, angle=45.0)
    rate = np.sqrt(abs(p) * scene.contacts[0].law.stiffness)  # 1/s, of 1 kg
    times = np.linspace(0.0, 2.0 / rate, 21)
    path = simulate(scene, Settings(rtol=1e-10, estimate="off"), times)
    swing = 1.0 - np.cos(rate * times) if p > 0.0 else np.cosh(rate * times) - 1.0
    assert path.contacts["ground"][:, 2] == pytest.approx(9.81 / abs(p) * swing, rel=2e-3, abs=1e-9)


def test_the_tippe_top_turns_over_and_keeps_jelletts_integral():
    """L . r from the centre of mass to the lowest point of the ball is constant, whatever friction does."""
    scene = scenes.make("tippe_top")
    path = simulate(scene, Settings(method="dop853", rtol=1e-8, estimate="off"), np.linspace(0.0, 3.0, 301))
    axes = rotation_matrices(path.orientation[:, 0])
    spun = np.einsum("tij,j,tkj,tk->ti", axes, (8e-7, 8e-7, 7e-7), axes, path.angular_velocity[:, 0])
    jellett = np.sum(spun * (0.003 * axes[:, :, 2] - (0.0, 0.0, 0.015)), axis=1)
    on_ball = np.cumsum(path.contacts["stem"][:, 3] != 0.0) == 0
    assert np.abs(jellett[on_ball] / jellett[0] - 1.0).max() < 1e-9
    height = axes[:, 2, 2]
    assert height[on_ball][-1] < 0.0
    assert height[-1] < np.cos(np.radians(170.0))  # on its stem
    assert path.angular_velocity[-1, 0, 2] > 90.0  # rad/s: still spinning the same way, upside down


# The toy with rigid contacts and the same geometry, by Moreau's steps of 20 us (computed apart): time (s) and fall (m)
# of the first peck. With geometry linear in the angles, as published, 0.0810 s and 0.0073 m, and a period of 0.1461 s
FIRST_PECK = (0.0827, 0.00898)


def test_the_woodpecker_jams_and_pecks_as_with_rigid_contacts():
    scene = scenes.make("woodpecker")
    times = np.linspace(0.0, 0.1, 1001)
    first, second = (simulate(scene, Settings(method=method, rtol=1e-8, estimate="off"), times)
                     for method in ("dop853", "radau"))  # fmt: skip
    assert np.abs(first.position - second.position).max() < 1e-8  # m
    pecking = int(np.argmax(first.contacts["beak"][:, 1] != 0.0))
    assert times[pecking] == pytest.approx(FIRST_PECK[0], rel=0.01)
    assert -first.position[pecking, 0, 1] == pytest.approx(FIRST_PECK[1], rel=0.01)
    jammed = (times > 0.03) & (times < 0.05)
    assert np.ptp(first.position[jammed, 0, 1]) < 1e-5  # m: it does not fall


# Robotics Toolbox for Python, tests of its Puma560 at the nominal pose: gravload, coriolis at rates of its pattern,
# without friction, and itorque at such accelerations, with rotors; N m, four decimals
PUMA_GRAVITY = (0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0)
PUMA_CORIOLIS = (
    (-0.1735, -2.0494, -0.1178, -0.0002, -0.0045, 0.0001), (0.6274, 1.1572, 1.9287, -0.0015, -0.0003, 0.0),
    (-0.3608, -0.7734, -0.0018, -0.0009, -0.0064, 0.0), (0.0011, 0.0005, -0.0001, 0.0002, 0.0002, -0.0001),
    (-0.0002, 0.0028, 0.0046, -0.0002, 0.0, 0.0), (0.0001, 0.0, 0.0, 0.0, 0.0, 0.0),
)  # fmt: skip
PUMA_INERTIA = (3.1500, 9.4805, 3.6189, 0.1901, 0.3519, 0.5823)
PUMA_PATTERN = np.array(ARMS["puma560"]["pattern"])
four_decimals = 5e-5  # N m


def puma_torques(rate: float, acceleration: float) -> np.ndarray:
    """Return what the drives give at t = 0 (6,), N m, less the share of the moment that was added to link 3."""
    scene = scenes.make("puma560", rate=rate, acceleration=acceleration)
    truth, path = both(scene, 11, rtol=1e-10)
    assert np.abs(path.position - truth.position).max() < 1e-13  # m
    frames = frames_at("puma560", pose_at("puma560", 0.0, rate, acceleration))
    axes, rates = frames[:6, :3, 2], rate * PUMA_PATTERN
    turning = rates[:3] @ axes[:3]
    rising = acceleration * PUMA_PATTERN[:3] @ axes[:3]
    for k in range(1, 3):
        rising += np.cross(rates[:k] @ axes[:k], rates[k] * axes[k])
    added = ARMS["puma560"]["links"][2]["inertia_added_zz"] * np.outer(frames[3, :3, 2], frames[3, :3, 2])
    share = np.where(np.arange(6) < 3, axes @ (added @ rising + np.cross(turning, added @ turning)), 0.0)
    return np.array([path.reactions[f"drive{k + 1}"][0, 3:] @ axes[k] for k in range(6)]) - share


def test_the_drives_of_a_puma_give_the_published_torques():
    gravity, moving, rising = puma_torques(0.0, 0.0), puma_torques(1.0, 0.0), puma_torques(0.0, 1.0)
    rotors = np.array([link["rotor"] * link["gear"] ** 2 for link in ARMS["puma560"]["links"]]) * PUMA_PATTERN
    assert np.abs(gravity - PUMA_GRAVITY).max() < four_decimals
    assert np.abs(rising - gravity + rotors - PUMA_INERTIA).max() < four_decimals
    rounded = four_decimals * PUMA_PATTERN.sum()  # of the sum over six rates
    assert np.abs(moving - gravity - np.array(PUMA_CORIOLIS) @ PUMA_PATTERN).max() < rounded


@pytest.mark.parametrize(("rate", "acceleration"), [(0.0, 0.0), (1.0, 0.0), (0.7, -1.3)])
def test_the_drives_of_a_stanford_arm_give_what_pinocchio_computes(rate, acceleration):
    """No torques of it are published where we could read them: recursive Newton-Euler is the second source."""
    pin = pytest.importorskip("pinocchio")
    arm, model, fixed = ARMS["stanford_arm"], pin.Model(), pin.SE3.Identity()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    for k, link in enumerate(arm["links"]):
        slides = link.get("slides", False)
        placed = fixed * pin.SE3(pin.utils.rotate("z", np.radians(link["theta_deg"])), np.zeros(3)) if slides else fixed
        joint = model.addJoint(k, pin.JointModelPZ() if slides else pin.JointModelRZ(), placed, f"joint{k + 1}")
        offset = np.array([link["a"], 0.0, link.get("d", 0.0)])
        fixed = pin.SE3(pin.utils.rotate("x", np.radians(link["alpha_deg"])), offset)
        inertia = pin.Inertia(link["mass"], np.array(link["centre"], dtype=float), np.diag(link["inertia"]))
        model.appendBodyToJoint(joint, inertia, fixed)
    pattern, t = np.array(arm["pattern"]), 0.3
    scene = scenes.make("stanford_arm", rate=rate, acceleration=acceleration)
    path = simulate(scene, Settings(rtol=1e-11, estimate="off"), np.array([0.0, t]))
    assert path.ok, path.message
    for sample, time in enumerate((0.0, t)):
        pose = pose_at("stanford_arm", time, rate, acceleration)
        rates = pattern * (rate + acceleration * time)
        expected = pin.rnea(model, model.createData(), pose, rates, pattern * acceleration)
        axes = frames_at("stanford_arm", pose)[:6, :3, 2]
        found = [path.reactions[f"drive{k + 1}"][sample].reshape(2, 3)[int(k != 2)] @ axes[k] for k in range(6)]
        assert found == pytest.approx(expected, abs=1e-9)  # N m, N
    truth = truth_for(scene, path.times)
    assert truth is not None
    assert np.abs(path.position - truth.position).max() < 1e-12  # m
