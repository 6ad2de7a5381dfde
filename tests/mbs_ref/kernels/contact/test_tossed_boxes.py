"""Boxes tossed on a frictionless floor, eight rigid corners each: bounces, edges and faces that land all at once."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators.loop.events import event_tables, settle
from mbs_ref.integrators.loop.leg import RUNNING, progress
from mbs_ref.kernels.contact.laws import MODE_CLOSED, MODE_OPEN
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.contact import RigidLaw, SphereOnPlane
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

MASS, G = 0.37, 9.81
SIGNS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def _box(half, turn: Rotation, height, velocity, spin, restitution) -> Scene:
    corners = turn.apply(SIGNS * half)
    squares = half**2
    box = SpatialBody(
        name="box", mass=MASS, inertia=(*(MASS / 3.0 * (squares.sum() - squares)), 0.0, 0.0, 0.0),
        position=(0.0, 0.0, height), orientation=tuple(turn.as_quat(scalar_first=True)), velocity=tuple(velocity),
        angular_velocity=tuple(spin),
    )  # fmt: skip
    touch = tuple(
        SphereOnPlane(name=f"corner{k}", body_a="box", center=(x, y, z + height), radius=0.0, body_b="ground",
                      point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0), law=RigidLaw(restitution=restitution))
        for k, (x, y, z) in enumerate(corners)
    )  # fmt: skip
    return Scene(name="box", gravity=(0.0, 0.0, -G), duration=1.0, bodies=(box,), contacts=touch)


def _tossed(seed: int) -> tuple[Scene, np.ndarray]:
    random = np.random.default_rng(seed)
    half = random.uniform(0.03, 0.08, 3) if seed % 2 else np.full(3, random.uniform(0.03, 0.08))
    turn = Rotation.from_quat(random.normal(size=4))
    height = random.uniform(0.0, 0.02) - turn.apply(SIGNS * half)[:, 2].min()
    restitution = float(random.uniform(0.0, 0.4)) if seed % 3 else 0.0
    return _box(half, turn, height, random.normal(0.0, 0.5, 3), random.normal(0.0, 3.0, 3), restitution), half


@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(k, marks=pytest.mark.slow) for k in range(6, 120))])
def test_a_tossed_box_loses_energy_and_rests_on_a_face(seed):
    scene, half = _tossed(seed)
    run = simulate(scene, Settings(method="dop853", rtol=1e-8, estimate="off", reactions=False, samples=201))
    assert run.ok, run.message
    inertia = np.array(scene.bodies[0].inertia[:3])
    turns = Rotation.from_quat(run.orientation[:, 0], scalar_first=True)
    turning = turns.inv().apply(run.angular_velocity[:, 0])
    energy = MASS * (0.5 * (run.velocity[:, 0] ** 2).sum(axis=1) + G * run.position[:, 0, 2])
    energy += 0.5 * (inertia * turning**2).sum(axis=1)
    assert np.diff(energy).max() < 1e-9
    corners = run.position[-1, 0] + turns[-1].apply(SIGNS * half)
    assert np.sort(corners[:, 2])[:4] == pytest.approx(0.0, abs=1e-12)
    assert run.events < 300


@pytest.mark.parametrize("rate", [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_box_that_rocks_within_roundoff_gains_no_speed(side, rate):
    """It lies on two opposite corners; the others touch at a speed (rad/s) at which a gap shows no time of landing."""
    half, restitution = np.full(3, 0.043), 0.15
    system = compile_scene(_box(half, Rotation.identity(), half[2], (0.4, 0.1, 0.0), (0.0, 0.0, -1.0), restitution))
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    modes = system.groups.contact_modes
    reach = np.linalg.norm(half[:2])
    axis, up = np.array([half[0], half[1], 0.0]) / reach, np.array([0.0, 0.0, half[2]])
    tilt = side * 3.0 * modes.noise[0] / reach
    y[3:7] = np.cos(0.5 * tilt), *(np.sin(0.5 * tilt) * axis)
    y[:3] += np.cross(tilt * axis, up)
    y[7:10] += np.cross(rate * axis, up)
    y[10:13] += rate * axis
    for k, (first, second, below) in enumerate(SIGNS):
        modes.mode[k] = MODE_CLOSED if below < 0.0 and first == second else MODE_OPEN
    before, run = y.copy(), progress(0.0)
    run.span = 1.0
    _, table = event_tables(system.model)
    assert settle(system.model, system.work, 0.0, y, table, run, 1000) == RUNNING
    assert np.abs(y[:7] - before[:7]).max() < 100.0 * modes.noise[0]
    assert np.abs(y[10:12]).max() <= rate + 10.0 * modes.noise[1] / reach
