"""What a crash's measures are made of: signs, constants and bodies, each against a case known by hand."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.crash import injury
from mbs_ref.crash.results import Motion, _head_and_neck, _neck_axial, _powers, _restoring, crash_results
from mbs_ref.scene import Force, PlanarBody, Revolute, Scene, TorsionSpring
from mbs_ref.scene.contact import CircleOnCircle, SpringDamperLaw
from mbs_ref.scene.signals import values
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory


@pytest.mark.parametrize("order", [("ground", "head"), ("head", "ground")])
@pytest.mark.parametrize(("g", "wanted"), [(9.81, -1.0), (-9.81, 1.0)], ids=["carried", "drawn"])
def test_a_neck_that_carries_the_head_is_compressed_and_one_that_holds_it_back_is_stretched(g, wanted, order):
    """4 kg at rest above the joint, drawn down or up."""
    mass = 4.0
    head = PlanarBody(name="head", mass=mass, inertia=0.1, position=(0.0, 0.2))
    neck = Revolute(name="-".join(order), body_a=order[0], body_b=order[1], point=(0.0, 0.0))
    scene = Scene(name="neck", gravity=(0.0, -g), bodies=(head,), joints=(neck,))
    run = simulate(scene, Settings(method="dop853", rtol=1e-10, t_end=1e-3, samples=2, estimate="off"))
    assert _neck_axial(Motion(scene, run)) == pytest.approx(wanted * mass * abs(g), rel=1e-6)


@pytest.mark.parametrize("order", [("ground", "head"), ("head", "ground")])
def test_a_necks_moment_is_what_turns_a_head_that_it_holds_at_its_centre_of_mass(order):
    """Euler: inertia times angular acceleration, by stiffness and by damping alike."""
    inertia, place = 0.02, (0.0, 0.2)
    head = PlanarBody(name="head", mass=4.0, inertia=inertia, position=place, angular_velocity=3.0)
    neck = Revolute(name="neck", body_a=order[0], body_b=order[1], point=place)
    spring = TorsionSpring(name="spring", body_a=order[0], body_b=order[1], stiffness=30.0, damping=0.5)
    scene = Scene(name="nod", gravity=(0.0, 0.0), bodies=(head,), joints=(neck,), loads=(spring,))
    run = simulate(scene, Settings(method="dop853", rtol=1e-11, t_end=0.1, samples=1001, estimate="off"))
    felt = inertia * np.gradient(run.angular_velocity[:, 0], run.times, edge_order=2)
    found = _restoring(Motion(scene, run), spring, "head")
    assert found[0] == pytest.approx(-0.5 * 3.0)
    np.testing.assert_allclose(found[1:-1], felt[1:-1], atol=1e-4 * np.abs(felt).max())


def test_the_viscous_criterion_has_the_dummys_scale():
    """Lau and Viano 1986, as regulated for Hybrid III: 1.3 times rate times compression."""
    times = np.linspace(0.0, 0.02, 201)
    depth, speed = 0.229, 3.0  # m, m/s
    found = injury.viscous_criterion(times, speed * times, depth)
    assert found == pytest.approx(1.3 * speed * (speed * 0.02) / depth, rel=1e-9)


def test_measures_of_a_head_that_is_slowed_evenly_and_of_a_neck_that_is_drawn_and_pushed():
    """By hand: HIC = window * a^2.5 for 15 and 36 ms, GSI over all of the time, Nij and forces at their worst."""
    times = np.linspace(0.0, 0.2, 2001)
    head = np.full(2001, 50.0)
    head[1500:1510] = 60.0  # g, after 150 ms and for 1 ms: not an early peak, nor long enough for the clip
    axial = np.interp(times, [0.0, 0.1, 0.2], [300.0, -700.0, 100.0])
    found = _head_and_neck(times, head, axial, np.linspace(0.2, 0.7, 2001))
    assert found["HIC15"] == pytest.approx(0.015 * 50.0**2.5, rel=0.05)
    assert found["HIC36"] == pytest.approx(0.036 * 50.0**2.5, rel=0.05)
    assert found["GSI"] == pytest.approx(0.199 * 50.0**2.5 + 0.001 * 60.0**2.5, rel=0.005)
    assert found["head 3 ms clip, g"] == pytest.approx(50.0)
    assert found["head peak before 120 ms, g"] == 50.0
    assert (found["neck tension, N"], found["neck compression, N"]) == (300.0, 700.0)
    assert found["Nij"] == 0.7


def test_contacts_take_from_two_bodies_what_their_speeds_lose():
    """Two discs meet while both fly on: what the damped contact has done by then is what their energies have lost."""
    slow = PlanarBody(name="slow", mass=2.0, inertia=1.0, position=(0.3, 0.0), velocity=(3.0, 0.0))
    fast = PlanarBody(name="fast", mass=1.0, inertia=1.0, velocity=(4.0, 0.0))
    ends = {"body_a": "fast", "center_a": fast.position, "body_b": "slow", "center_b": slow.position}
    law = SpringDamperLaw(stiffness=1e4, damping=20.0)
    touch = CircleOnCircle(name="touch", radius_a=0.1, radius_b=0.1, law=law, **ends)  # type: ignore[arg-type]
    scene = Scene(name="discs", gravity=(0.0, 0.0), bodies=(slow, fast), contacts=(touch,))
    run = simulate(scene, Settings(rtol=1e-10, t_end=0.3, samples=3001, estimate="off"))
    assert run.ok, run.message
    speeds = run.velocity[[0, -1], :, 0]
    lost = np.diff(0.5 * speeds**2 @ [2.0, 1.0])[0]
    assert lost < -0.05  # J
    assert np.trapezoid(_powers(Motion(scene, run))["contacts"], run.times) == pytest.approx(lost, rel=1e-2)


@cache
def _crash() -> tuple[Scene, Trajectory]:
    scene = scenes.make("android_vertebral", model="paper")
    run = simulate(scene, Settings(rtol=1e-8, t_end=0.06, samples=601, estimate="off"))
    assert run.ok, run.message
    return scene, run


def test_the_chests_deflection_is_what_the_fourth_ribs_tip_comes_nearer_to_the_seventh_vertebra():
    """The tip is 6.4 cm before and 3.9 cm below the rib's centre of mass at the start, and turns with the rib."""
    scene, run = _crash()
    rib, spine = scene.body_index("rib4"), scene.body_index("T7")
    start = np.array([-0.07337, 0.74669]) - run.position[0, rib]
    turned = run.orientation[:, rib] - run.orientation[0, rib]
    arm = np.stack([np.cos(turned) * start[0] - np.sin(turned) * start[1],
                    np.sin(turned) * start[0] + np.cos(turned) * start[1]], axis=1)  # fmt: skip
    depth = np.linalg.norm(run.position[:, rib] + arm - run.position[:, spine], axis=1)
    found = crash_results(scene, run).chest_deflection
    assert found is not None
    assert np.ptp(found) > 1e-3
    np.testing.assert_allclose(found, depth[0] - depth, atol=1e-5)


def test_the_thoracic_index_adds_the_ribs_and_the_twelfth_vertebras_peaks():
    """Accelerations are differences of the velocities, less the pulse of the seat's frame; constants by hand."""
    scene, run = _crash()
    found = crash_results(scene, run).measures["TTI at 45 years, g"]

    def peak(name: str) -> float:
        k = scene.body_index(name)
        felt = np.gradient(run.velocity[:, k], run.times, axis=0, edge_order=2)
        for load in scene.loads:
            if isinstance(load, Force) and load.body == name and load.name.startswith("crash."):
                felt -= values(load.factor, run.times)[:, None] * np.array(load.vector) / scene.bodies[k].mass
        return float(np.max(np.hypot(*felt.T)) / 9.80665)

    mass = sum(body.mass for body in scene.bodies if not body.name.startswith("seat"))
    wanted = 1.4 * 45.0 + 0.5 * (peak("rib4") + peak("T12")) * mass / 75.0
    assert abs(peak("rib4") - peak("T12")) > 2.0  # g: neither stands for the other
    assert found == pytest.approx(wanted, rel=0.02)
