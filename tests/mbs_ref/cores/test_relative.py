"""Trees in relative coordinates against the redundant cores, which solve other equations for the same motion."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.relative import RelativeSystem
from mbs_ref.scene import PlanarBody, PointMass, Prismatic, Revolute, Scene, SpatialBody, Spherical, SpringDamper, Weld
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.start_checks import InconsistentScene

SAME = 1e-10  # m, rad: of motions at tolerances of 1e-12
ROUNDOFF = 1e-9  # relative, of accelerations of some hundred at general states


def compiled(scene: Scene) -> RelativeSystem:
    system = compile_scene(scene, "relative")
    assert isinstance(system, RelativeSystem)
    system.set_mode_time(0.0)
    return system


def particle(name: str, mass: float, position: tuple[float, ...]) -> PointMass:
    return PointMass(name=name, mass=mass, position=position, velocity=(0.0,) * len(position))


def planar_tree() -> Scene:
    """Every planar joint on ground, on a free body and on one another, in both orders of its ends, and particles."""
    rng = np.random.default_rng(0)

    def body(name):
        x, y, angle = rng.normal(size=3).tolist()
        return PlanarBody(name=name, mass=1.0 + rng.random(), inertia=0.5 + rng.random(), position=(x, y), angle=angle)

    def point():
        x, y = rng.normal(size=2).tolist()
        return x, y

    return Scene(
        name="tree", gravity=(1.0, -9.81),
        bodies=(*(body(name) for name in "abcdefg"), particle("p", 0.7, (0.3, 0.2)),
                particle("s", 0.5, (2.0, 0.2))),
        joints=(
            Revolute(name="j1", body_a="b", body_b="a", point=point()),
            Prismatic(name="j2", body_a="b", body_b="c", point=point(), axis=point()),
            Weld(name="j3", body_a="d", body_b="c", point=point()),
            Revolute(name="j4", body_a="d", body_b="p", point=(0.3, 0.2)),
            Revolute(name="j5", body_a="e", body_b="ground", point=point()),
            Prismatic(name="j6", body_a="f", body_b="e", point=point(), axis=point()),
            Prismatic(name="j7", body_a="ground", body_b="g", point=point(), axis=point()),
        ),
        loads=(SpringDamper(name="k", body_a="s", body_b="f", point_a=(2.0, 0.2), point_b=point(), stiffness=20.0,
                            damping=1.0),),
    )  # fmt: skip


def spatial_tree() -> Scene:
    """The same in space, with balls."""
    rng = np.random.default_rng(1)

    def body(name):
        root = rng.normal(size=(3, 3))
        j = np.trace(root @ root.T) * np.eye(3) - root @ root.T
        theta = rng.normal(size=4)
        return SpatialBody(
            name=name, mass=1.0 + rng.random(), position=point(), orientation=tuple(theta / np.linalg.norm(theta)),
            inertia=(j[0, 0], j[1, 1], j[2, 2], j[0, 1], j[0, 2], j[1, 2]),
        )  # fmt: skip

    def point():
        x, y, z = rng.normal(size=3).tolist()
        return x, y, z

    return Scene(
        name="tree", gravity=(1.0, 2.0, -9.81),
        bodies=(*(body(name) for name in "abcdefghi"), particle("p", 0.7, (0.3, 0.2, 0.1)),
                particle("s", 0.5, (2.0, 0.2, 0.1))),
        joints=(
            Revolute(name="j1", body_a="b", body_b="a", point=point(), axis=point()),
            Prismatic(name="j2", body_a="b", body_b="c", point=point(), axis=point()),
            Weld(name="j3", body_a="d", body_b="c", point=point()),
            Spherical(name="j4", body_a="d", body_b="p", point=(0.3, 0.2, 0.1)),
            Spherical(name="j5", body_a="e", body_b="ground", point=point()),
            Prismatic(name="j6", body_a="f", body_b="e", point=point(), axis=point()),
            Revolute(name="j7", body_a="f", body_b="g", point=point(), axis=point()),
            Spherical(name="j8", body_a="g", body_b="h", point=point()),
            Revolute(name="j9", body_a="ground", body_b="i", point=point(), axis=point()),
        ),
        loads=(SpringDamper(name="k", body_a="s", body_b="f", point_a=(2.0, 0.2, 0.1), point_b=point(), stiffness=20.0,
                            damping=1.0),),
    )  # fmt: skip


def general_state(system: RelativeSystem) -> np.ndarray:
    rng = np.random.default_rng(5)
    y = system.initial_state()
    y += rng.normal(size=len(y))
    system.project(0.0, y)
    return y


@pytest.mark.parametrize("scene", [planar_tree(), spatial_tree()], ids=["plane", "space"])
class TestEveryJoint:
    def test_a_general_state_keeps_every_joint(self, scene):
        system = compiled(scene)
        y = general_state(system)
        gaps = system.residuals(0.0, y)
        assert len(gaps) == len(scene.joints)
        assert max(float(np.abs(values).max()) for pair in gaps.values() for values in pair) < 1e-13

    def test_the_states_tell_each_other(self, scene):
        system = compiled(scene)
        y = general_state(system)
        angles = np.abs(system.full(system.reduced(system.full(y))) - system.full(y))
        assert angles.max() < 1e-12

    def test_accelerations_are_those_of_the_augmented_system(self, scene):
        """[M C_q^T; C_q 0] solved by the redundant core, and the articulated bodies, at a general state."""
        system = compiled(scene)
        y = general_state(system)
        expected = system.accelerations(0.0, y)
        system.derivative(0.0, y)
        found = system.scratch.recursion.acceleration[: len(scene.bodies)]
        found = found[np.argsort(system.redundant.groups.bodies.scene_index)]
        turning = [k for k, body in enumerate(scene.bodies) if not isinstance(body, PointMass)]
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found[:, : scene.dimension], expected[:, : scene.dimension], atol=ROUNDOFF * scale)
        np.testing.assert_allclose(found[turning], expected[turning], atol=ROUNDOFF * scale)

    def test_the_rates_of_places_are_their_velocities(self, scene):
        system = compiled(scene)
        y = general_state(system)
        h = 1e-6
        rate = system.derivative(0.0, y)
        ahead, behind, here = (system.poses((y + s * rate)[None]) for s in (h, -h, 0.0))
        np.testing.assert_allclose((ahead.position - behind.position) / (2.0 * h), here.velocity, atol=1e-7)

    def test_the_motion_is_that_of_the_redundant_core(self, scene):
        runs = [
            simulate(scene, Settings(coordinates=kind, rtol=1e-12, t_end=0.5, samples=6, estimate="off"))
            for kind in ("cartesian", "relative")
        ]
        assert all(run.ok for run in runs), [run.message for run in runs]
        assert np.abs(runs[0].position - runs[1].position).max() < SAME
        for name in runs[0].reactions:
            np.testing.assert_allclose(runs[0].reactions[name], runs[1].reactions[name], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "parameters", "t_end"),
    [
        ("pendulum_chain", {"links": 10}, 1.0),
        ("spatial_chain", {}, 1.0),
        ("heavy_top", {}, 1.0),
        ("torque_free_top", {}, 10.0),
        ("android_simplified", {"model": "paper"}, 0.2),
        ("android_simplified", {"impact": "rear"}, 0.2),
        ("android_vertebral", {"model": "paper"}, 0.03),
    ],
)
def test_chains_tops_and_androids_move_alike(name, parameters, t_end):
    scene = scenes.make(name, **parameters)
    settings = Settings(rtol=1e-12, t_end=t_end, samples=6, estimate="off", reactions=False)
    runs = [
        simulate(scene, settings.model_copy(update={"coordinates": kind})) for kind in ("cartesian", "relative")
    ]  # fmt: skip
    assert all(run.ok for run in runs), [run.message for run in runs]
    assert np.abs(runs[0].position - runs[1].position).max() < SAME
    assert np.abs(runs[0].orientation - runs[1].orientation).max() < SAME
    assert set(runs[0].event_names) == set(runs[1].event_names)


@pytest.mark.parametrize(("method", "accuracy"), [("rk4", {"step": 1e-3}), ("lsodar", {"rtol": 1e-10})])
def test_other_methods_run_in_them(method, accuracy):
    scene = scenes.make("double_pendulum")
    fine = simulate(scene, Settings(rtol=1e-12, t_end=0.5, samples=2, estimate="off"))
    run = simulate(scene, Settings(method=method, coordinates="relative", t_end=0.5, samples=2, **accuracy))
    assert run.ok, run.message
    assert np.abs(run.position[-1] - fine.position[-1]).max() < 1e-7


def test_the_order_of_rk4_holds_in_them():
    scene = scenes.make("heavy_top")
    settings = Settings(coordinates="relative", t_end=0.2, samples=2, estimate="off")
    exact = simulate(scene, settings.model_copy(update={"rtol": 1e-13})).position[-1]
    runs = [simulate(scene, settings.model_copy(update={"method": "rk4", "step": h})) for h in (2e-3, 1e-3)]
    coarse, fine = (np.abs(run.position[-1] - exact).max() for run in runs)
    assert np.log2(coarse / fine) == pytest.approx(4.0, abs=0.35)


def test_impulses_reach_the_joints_rates():
    runs = [
        simulate(scenes.make("newtons_cradle"), Settings(coordinates=kind, rtol=1e-10, estimate="off"))
        for kind in ("cartesian", "relative")
    ]  # fmt: skip
    assert runs[0].events == runs[1].events > 0
    assert np.abs(runs[0].position - runs[1].position).max() < SAME


@pytest.mark.parametrize(
    ("name", "words"),
    [("slider_crank", "closes a loop"), ("spherical_pendulum", "is a distance"), ("driven_pendulum", "drive")],
)
def test_what_is_no_tree_of_known_joints_is_refused(name, words):
    with pytest.raises(ValueError, match=f"coordinates = 'relative' needs a tree.*{words}"):
        simulate(scenes.make(name), Settings(coordinates="relative", estimate="off"))


@pytest.mark.parametrize("body", [PlanarBody, SpatialBody])
def test_what_cannot_move_has_no_coordinates_and_is_refused(body):
    """A state without entries has no error that controls a step: such a run did not end."""
    place, inertia = ((0.0, 0.0), 0.1) if body is PlanarBody else ((0.0, 0.0, 0.0), (0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    bodies = (body(name="a", mass=1.0, inertia=inertia, position=place),)
    held = Weld(name="w", body_a="ground", body_b="a", point=place)
    scene = Scene(name="still", bodies=bodies, joints=(held,), gravity=tuple(9.81 for _ in place), duration=1.0)
    with pytest.raises(ValueError, match="every body is welded to ground, which leaves no coordinates"):
        simulate(scene, Settings(coordinates="relative"))
    resting = simulate(scene, Settings())
    assert resting.ok, resting.message
    assert np.abs(resting.position).max() < 1e-12


def test_methods_on_the_rows_are_refused():
    with pytest.raises(ValueError, match="is for planar, spatial scenes"):
        simulate(scenes.make("pendulum"), Settings(method="radau", coordinates="relative", estimate="off"))
    with pytest.raises(ValueError, match="they have no rows"):
        simulate(scenes.make("pendulum"), Settings(coordinates="relative", stabilization="baumgarte", estimate="off"))


def test_a_start_that_breaks_a_joint_is_refused_as_ever():
    """The joints' own rates could not even hold it: it must not be dropped unsaid."""
    scene = scenes.make("double_pendulum")
    first, *rest = scene.bodies
    moved = first.model_copy(update={"velocity": (1.0, 1.0)})
    broken = scene.model_copy(update={"bodies": (moved, *rest)})
    with pytest.raises(InconsistentScene, match="velocity gap"):
        simulate(broken, Settings(coordinates="relative", estimate="off"))
    mended = [
        simulate(broken, Settings(coordinates=kind, project_initial=True, rtol=1e-11, samples=5, estimate="off"))
        for kind in ("cartesian", "relative")
    ]
    assert np.abs(mended[0].position - mended[1].position).max() < SAME
