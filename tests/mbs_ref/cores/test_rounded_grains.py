"""Granules with cores: forces against closed forms, MuJoCo's distances and a second formulation; what is conserved."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbs_ref import Scene, observables, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene import PlanarBody, PointMass, SpatialBody
from mbs_ref.scene.contact import Granules, RegularisedCoulomb, SpringDamperLaw, Wall
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.mbs_ref.cores.grain_features import axes_of, touching_granules

STIFFNESS, RADIUS = 1e5, 0.02  # N/m, m
POINT, CAPSULE, PLATE, BOX = (0.0, 0.0, 0.0), (0.0, 0.0, 0.08), (0.06, 0.0, 0.05), (0.06, 0.05, 0.04)  # m
LEVEL = Rotation.identity()


def _scene(places, turns, halves, **more: Any) -> Scene:
    given: dict[str, Any] = {"law": SpringDamperLaw(stiffness=STIFFNESS, release="force")} | more
    bodies = tuple(
        SpatialBody(name=f"g{k}", mass=1.0, inertia=(1e-3, 2e-3, 2.5e-3, 0.0, 0.0, 0.0), position=tuple(place),
                    orientation=tuple(turn.as_quat(scalar_first=True)))
        for k, (place, turn) in enumerate(zip(places, turns, strict=True))
    )  # fmt: skip
    group = Granules(name="grains", radius=(RADIUS,), half=tuple(halves), **given)
    return Scene(name="grains", duration=0.1, bodies=bodies, loads=(group,))


def _forces(scene: Scene) -> np.ndarray:
    """Return the forces (n, 3), N."""
    system = compile_scene(scene)
    rates = system.derivative(0.0, system.initial_state())[system.n_positions :]
    return rates.reshape(len(scene.bodies), 6)[:, :3]


TURN, LYING = Rotation.from_rotvec((0.0, 0.0, 1.0)), Rotation.from_rotvec((0.0, np.pi / 2, 0.0))
DEPTH = 1e-3  # m
ON_TOP = RADIUS * 2.0 - DEPTH  # m, between cores


@pytest.mark.parametrize(
    ("halves", "place", "turns", "count"),
    [
        ((POINT, POINT), (0.0, 0.0, ON_TOP), (LEVEL, LEVEL), 1),
        ((CAPSULE, CAPSULE), (0.0, 0.0, 0.16 + ON_TOP), (LEVEL, LEVEL), 1),  # end to end
        ((CAPSULE, CAPSULE), (0.0, ON_TOP, 0.0), (LEVEL, LEVEL), 2),  # along each other
        ((CAPSULE, CAPSULE), (0.0, ON_TOP, 0.05), (LEVEL, LEVEL), 2),
        ((CAPSULE, CAPSULE), (0.0, ON_TOP, 0.0), (LEVEL, Rotation.from_rotvec((0.0, 1.2, 0.0))), 1),  # across
        ((CAPSULE, POINT), (0.0, ON_TOP, 0.03), (LEVEL, LEVEL), 1),
        ((BOX, POINT), (0.01, 0.02, 0.04 + ON_TOP), (LEVEL, LEVEL), 1),
        ((BOX, BOX), (0.0, 0.0, 0.08 + ON_TOP), (LEVEL, LEVEL), 4),  # face on equal face
        ((BOX, BOX), (0.03, 0.02, 0.08 + ON_TOP), (LEVEL, LEVEL), 4),
        ((BOX, BOX), (0.0, 0.0, 0.08 + ON_TOP), (LEVEL, TURN), 8),  # eight crossings of edges
        ((BOX, CAPSULE), (0.0, 0.0, 0.04 + ON_TOP), (LEVEL, LYING), 2),
        ((BOX, CAPSULE), (0.05, 0.0, 0.04 + ON_TOP), (LEVEL, LYING), 2),
        ((BOX, CAPSULE), (0.06, 0.05, 0.12 + ON_TOP), (LEVEL, LEVEL), 1),  # end on corner
        ((PLATE, PLATE), (0.0, ON_TOP, 0.0), (LEVEL, LEVEL), 4),
        ((PLATE, POINT), (0.0, ON_TOP, 0.0), (LEVEL, LEVEL), 1),
    ],
)  # fmt: skip
def test_each_point_of_contact_presses_by_the_law_once(halves, place, turns, count):
    force = _forces(_scene(((0.0, 0.0, 0.0), place), turns, halves))
    assert np.abs(force[0] + force[1]).max() < 1e-12 * STIFFNESS * DEPTH
    assert np.linalg.norm(force[1]) == pytest.approx(count * STIFFNESS * DEPTH, rel=1e-9)


@pytest.mark.parametrize(
    ("half", "corners", "low"), [(POINT, 1, 0.0), (CAPSULE, 1, 0.08), (PLATE, 2, 0.05), (BOX, 4, 0.04)]
)
def test_a_floor_presses_every_lowest_corner(half, corners, low):
    floor = (Wall(point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)),)
    force = _forces(_scene([(0.3, 0.0, low + RADIUS - DEPTH)], [LEVEL], [half], walls=floor))
    assert force[0] == pytest.approx((0.0, 0.0, corners * STIFFNESS * DEPTH), rel=1e-9)


def _mujoco(halves) -> Any:
    mujoco = pytest.importorskip("mujoco")
    spec = mujoco.MjSpec()
    for half in halves:
        body = spec.worldbody.add_body()
        body.add_freejoint()
        if half == POINT:
            kind, size = mujoco.mjtGeom.mjGEOM_SPHERE, (RADIUS, 0.0, 0.0)
        elif half == CAPSULE:
            kind, size = mujoco.mjtGeom.mjGEOM_CAPSULE, (RADIUS, half[2], 0.0)
        else:
            kind, size = mujoco.mjtGeom.mjGEOM_BOX, half
        body.add_geom(type=kind, size=size)
    spec.option.ccd_tolerance, spec.option.ccd_iterations = 1e-12, 200
    return spec.compile()


@pytest.mark.parametrize(
    "halves", [(POINT, CAPSULE), (POINT, BOX), (CAPSULE, CAPSULE), (CAPSULE, BOX), (BOX, CAPSULE), (BOX, BOX)]
)
def test_depths_are_those_of_mujoco(halves):
    """MuJoCo's boxes have sharp edges: they stand for the cores."""
    import mujoco

    model, random, depth = _mujoco(halves), np.random.default_rng(7), 1e-5  # m: one point touches
    data, between = mujoco.MjData(model), np.zeros(6)
    inside = RADIUS * sum(half == BOX for half in halves)  # m, that our shapes extend beyond MuJoCo's
    for _ in range(10):
        turns, away = Rotation.random(2, random), random.standard_normal(3)
        places = np.array(((0.0, 0.0, 0.0), 0.3 * away / np.linalg.norm(away)))
        for _ in range(2):  # the second time from the place to which the nearest points were moved
            for k in range(2):
                data.qpos[7 * k : 7 * k + 7] = (*places[k], *turns[k].as_quat(scalar_first=True))
            mujoco.mj_kinematics(model, data)
            gap = mujoco.mj_geomDistance(model, data, 0, 1, 1.0, between)
            if gap > 0.0:
                normal = (between[3:] - between[:3]) / gap
                places[1] += (inside - depth - gap) * normal
        force = _forces(_scene(places, turns, halves))[1]
        if inside:
            assert gap == pytest.approx(inside - depth, abs=1e-9)
        assert np.linalg.norm(force) == pytest.approx(STIFFNESS * depth, rel=1e-4)
        assert force / np.linalg.norm(force) == pytest.approx(normal, abs=1e-5)


def _cloud(seed: int, spread: float, count: int = 24, **more: Any) -> Scene:
    """Return grains of all shapes near each other, with velocities towards their middle."""
    random = np.random.default_rng(seed)
    cell = np.stack(np.unravel_index(np.arange(count), (3, 3, 3)), axis=1) - 1.0
    scene = _scene(spread * (cell + 0.1 * random.standard_normal(cell.shape)), Rotation.random(count, random),
                   [(POINT, CAPSULE, PLATE, BOX)[k % 4] for k in range(count)], **more)  # fmt: skip
    bodies = tuple(
        body.model_copy(update={"velocity": tuple(-5.0 * np.array(body.position)),
                                "angular_velocity": tuple(5.0 * random.standard_normal(3))}) for body in scene.bodies
    )  # fmt: skip
    return scene.model_copy(update={"bodies": bodies})


def test_forces_and_torques_are_those_of_a_second_formulation():
    most = 0
    for seed in range(5):
        scene = _cloud(seed, 0.11)
        (part,) = scene.loads
        assert isinstance(part, Granules)
        centres = np.array([body.position for body in scene.bodies])
        turned = axes_of(np.array([body.orientation for body in scene.bodies]), centres)
        ends, gap, normal, place, sign = touching_granules(part, centres, turned)
        load = np.zeros((len(centres), 6))
        for (a, b), depth, n, x, s in zip(ends, -gap, normal, place, sign, strict=True):
            force = s * STIFFNESS * depth * n
            load[a] += np.concatenate((force, np.cross(x - RADIUS * n - centres[a], force)))
            load[b] -= np.concatenate((force, np.cross(x - RADIUS * n - centres[b], force)))
        system = compile_scene(scene)
        y = system.initial_state()
        rates = [system.derivative(0.0, y)]
        system = compile_scene(scene.model_copy(update={"loads": ()}))
        rates.append(system.derivative(0.0, y))
        change = (rates[0] - rates[1])[system.n_positions :].reshape(-1, 6)
        torque = np.einsum("nij,nj->ni", turned, np.array((1e-3, 2e-3, 2.5e-3)) * change[:, 3:])  # from body axes
        found = np.concatenate((change[:, :3], torque), axis=1)
        assert np.abs(found - load).max() < 1e-10 * np.abs(load).max()
        most = max(most, int(np.sum(sign < 0.0)))
    assert most > 5  # features that are counted twice


def test_an_elastic_cloud_conserves_momentum_and_energy():
    scene = _cloud(3, 0.22, count=12)
    path = simulate(
        scene, Settings(method="dop853", rtol=1e-9, samples=11, t_end=0.08, estimate="off", reactions=False)
    )
    assert path.ok, path.message
    momentum = observables.momentum_drift(scene, path)
    assert momentum is not None
    assert np.max(momentum) < 1e-10  # measured 8e-12: the moment of momentum is integrated
    kinetic = [sum(_kinetic(path, scene, i, k) for i in range(len(scene.bodies))) for k in (0, -1)]
    (part,) = scene.loads
    assert isinstance(part, Granules)
    stored = [_stored(part, path, k) for k in (0, -1)]
    turned = np.linalg.norm(path.angular_velocity[-1] - path.angular_velocity[0], axis=1)
    assert np.sum(turned > 1.0) > 5  # they do collide
    assert kinetic[1] + stored[1] == pytest.approx(kinetic[0] + stored[0], rel=1e-6)


def _kinetic(path, scene: Scene, i: int, k: int) -> float:
    turned = Rotation.from_quat(path.orientation[k, i], scalar_first=True)
    spin = turned.inv().apply(path.angular_velocity[k, i])
    return 0.5 * float(path.velocity[k, i] @ path.velocity[k, i] + spin @ (np.array((1e-3, 2e-3, 2.5e-3)) * spin))


def _stored(part: Granules, path, k: int) -> float:
    touch = touching_granules(part, path.position[k], axes_of(path.orientation[k], path.position[k]))
    return float(np.sum(touch.sign * 0.5 * STIFFNESS * touch.gap**2))


def test_rubbing_and_damped_grains_lose_energy_whose_work_is_unknown():
    law = SpringDamperLaw(stiffness=STIFFNESS, damping=20.0)
    scene = _cloud(3, 0.22, count=12, law=law, friction=RegularisedCoulomb(coefficient=0.4, speed=0.05))
    path = simulate(scene, Settings(method="dop853", rtol=1e-6, samples=11, t_end=0.08, estimate="off"))
    assert path.ok, path.message
    momentum, energy = observables.momentum_drift(scene, path), observables.energy_balance(scene, path)
    assert momentum is not None
    assert np.max(momentum) < 1e-7  # of rtol
    assert energy.energy[-1] < 0.98 * energy.energy[0]  # measured 0.962
    assert energy.drift is None
    assert "half" in energy.reason


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["capsule", "box"])
def test_grains_of_other_shapes_fall_into_their_box_and_stay_there(shape):
    scene = scenes.make("granular_column", grains=8, across=2, space=True, search=True, shape=shape, friction=0.5)
    path = simulate(scene, Settings(method="rk4", step=2e-4, t_end=0.4, samples=5, estimate="off", reactions=False))
    assert path.ok, path.message
    width = max(wall.point[0] for wall in scene.loads[0].walls)
    assert np.all(path.position[-1] > 0.01)
    assert path.position[-1, :, :2].max() < width - 0.01
    assert np.mean(path.position[-1, :, 2]) < 0.6 * np.mean(path.position[0, :, 2])


def test_planar_cores_press_at_their_corners():
    half = (0.06, 0.04)
    bodies = tuple(PlanarBody(name=f"b{k}", mass=1.0, inertia=1.0, position=(0.01 * k, k * (0.08 + ON_TOP)))
                   for k in range(2))  # fmt: skip
    law = SpringDamperLaw(stiffness=STIFFNESS)
    group = Granules(name="g", radius=(RADIUS,), half=(half,), law=law)
    system = compile_scene(Scene(name="s", duration=1.0, bodies=bodies, loads=(group,)))
    rates = system.derivative(0.0, system.initial_state())[system.n_positions :]
    assert rates[4] == pytest.approx(2.0 * STIFFNESS * DEPTH)
    assert rates[3] == pytest.approx(0.0, abs=1e-9)


def test_what_cores_cannot_have_is_named():
    scene = _cloud(0, 0.2, count=4)
    (part,) = scene.loads
    given, halves = scene.model_dump(), (BOX,) * 4
    particles = [PointMass(name=f"p{k}", mass=1.0, position=(k, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)) for k in range(4)]
    for change, named in (
        ({"half": halves[:3]}, r"half has 3 entries; allowed: 1, or 4, one a body"),
        ({"half": ((0.1, 0.1),)}, r"half\[0\] = \(0.1, 0.1\) must have 3 components here"),
        ({"radius": (0.0, 0.1, 0.1, 0.1), "half": halves}, r"radius = 0 rounds the edges of 'g0', half = .*positive"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=named):
            Scene.model_validate(given | {"loads": [part.model_copy(update=change).model_dump()]})
    with pytest.raises(ValueError, match="half turns with 'p1', a point mass, and has no orientation"):
        Scene.model_validate(given | {"bodies": [p.model_dump() for p in particles]})
    with pytest.raises(ValueError, match=r"half.0.0"):
        Granules(name="g", radius=(0.1,), half=((-0.1, 0.0, 0.0),), law=part.law)
    with pytest.raises(ValueError, match="shape = 'box' needs search = true and space = true"):
        scenes.make("granular_column", shape="box")
