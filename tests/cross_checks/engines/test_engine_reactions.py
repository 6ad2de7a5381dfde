"""Joint reactions of every engine that gives them, against a closed form and against the reference solver."""

from __future__ import annotations

import pytest

from mbs_ref import scenes
from mbs_ref.scene import GROUND, Distance, PlanarBody, Revolute, Scene
from tests.cross_checks.engines.engine_runs import run

GIVERS = [("mujoco", "rk4"), ("pinocchio", "dop853"), ("pinocchio", "rk4"), ("exudyn", "generalized_alpha")]


@pytest.mark.parametrize(("name", "method"), GIVERS)
def test_the_pendulums_rod_pulls_as_the_closed_form_says(name, method):
    """Tension = 3 m g |y| / L when released horizontally: m v^2 / L + m g |y| / L with v^2 = 2 g |y|."""
    result = run(name, method, scenes.make("pendulum"), t_end=1.0, samples=11)
    place = result.position[:, 0]
    expected = 3.0 * 9.81 * place[:, 1:] * place  # towards the pivot: |y| = -y, direction -place
    accuracy = 1e-3 if name == "exudyn" else 1e-6  # N
    assert result.reactions["rod"][1:, :2] == pytest.approx(expected[1:], abs=accuracy)
    assert result.reactions["rod"][:, 2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("name", "method"), GIVERS)
@pytest.mark.parametrize("scene", ["double_pendulum", "slider_crank"])
def test_reactions_equal_the_references(name, method, scene):
    made = scenes.make(scene)
    if name == "mujoco" and scene == "slider_crank":
        method = "rk4_tight"
    result = run(name, method, made, step=2e-4, t_end=0.2, samples=5)
    reference = run("mbs_ref", "dop853", made, t_end=0.2, samples=5)
    common = result.reactions.keys() & reference.reactions.keys()
    assert len(common) >= 2
    accuracy = {"exudyn": 1e-2, "pinocchio": 1e-5}.get(name, 1e-6 if scene == "double_pendulum" else 0.1)  # N, N m
    for joint in common:
        # Exudyn's multipliers at t = 0 precede its first step; MuJoCo's soft loop settles in its first
        first = 0 if name == "pinocchio" else 1
        assert result.reactions[joint][first:] == pytest.approx(reference.reactions[joint][first:], abs=accuracy), joint


def test_a_rod_between_bodies_and_pins_are_told_apart():
    rods = [
        PlanarBody(name=name, mass=1.0, inertia=0.1, position=(x, 0.0)) for name, x in (("left", 0.5), ("right", 2.5))
    ]
    joints = (
        Revolute(name="a", body_a=GROUND, body_b="left", point=(0.0, 0.0)),
        Distance(name="tie", body_a="left", body_b="right", point_a=(1.0, 0.0), point_b=(2.0, 0.5)),
        Revolute(name="b", body_a="right", body_b=GROUND, point=(3.0, 0.0)),
    )
    scene = Scene(name="tied", gravity=(0.3, -9.81), bodies=tuple(rods), joints=joints)
    result = run("exudyn", "generalized_alpha", scene, step=2e-4, t_end=0.05, samples=3)
    reference = run("mbs_ref", "dop853", scene, t_end=0.05, samples=3)
    assert result.reactions.keys() == reference.reactions.keys()
    for joint, force in reference.reactions.items():
        assert result.reactions[joint][1:] == pytest.approx(force[1:], abs=1e-2), joint
    assert not run("exudyn", "generalized_alpha", scene, t_end=0.01, samples=2, reactions=False).reactions
