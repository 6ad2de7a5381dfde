"""A scene whose bodies were stopped but one gets its own velocities back: the joints have one freedom."""

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.scene import GROUND, Distance, PointMass, Scene
from mbs_ref.simulate.start_checks import InconsistentScene, fitted_rates

CLOSED = 1e-9  # m/s, rad/s


def stopped(scene: Scene, but: str) -> Scene:
    """Return the scene with the velocities of one body alone."""
    still = {2: {"velocity": (0.0, 0.0), "angular_velocity": 0.0},
             3: {"velocity": (0.0,) * 3, "angular_velocity": (0.0,) * 3}}[scene.dimension]  # fmt: skip
    bodies = tuple(b if b.name == but else b.model_copy(update=still) for b in scene.bodies)
    return scene.model_copy(update={"bodies": bodies})


@pytest.mark.parametrize("name", ["slider_crank", "spatial_n_four_bar"])
def test_the_others_follow_from_the_one_that_is_kept(name):
    scene = scenes.make(name)
    fastest = max(scene.bodies, key=lambda body: np.linalg.norm(body.angular_velocity))
    found = fitted_rates(stopped(scene, fastest.name), [f"{fastest.name}.angular_velocity"], CLOSED)
    for body, original in zip(found.bodies, scene.bodies, strict=True):
        assert np.allclose(body.velocity, original.velocity, atol=1e-9), body.name
        assert np.allclose(body.angular_velocity, original.angular_velocity, atol=1e-9), body.name


def test_what_no_joint_allows_is_refused():
    scene = scenes.make("slider_crank")
    crank = scene.bodies[0].model_copy(update={"angular_velocity": 9.0})
    faster = scene.model_copy(update={"bodies": (crank, *scene.bodies[1:])})
    with pytest.raises(InconsistentScene, match="crank"):
        fitted_rates(faster, ["crank.angular_velocity", "slider.velocity"], CLOSED)


def test_a_particle_on_a_rod_keeps_what_goes_around():
    """A rod along x lets its bob go along y alone; a second rod along y carries that to the other bob."""
    first = PointMass(name="first", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 3.0))
    second = PointMass(name="second", mass=1.0, position=(1.0, 1.0), velocity=(5.0, 0.0))
    rods = (
        Distance(name="rod", body_a=GROUND, body_b="first", point_a=(0.0, 0.0), point_b=(1.0, 0.0), length=1.0),
        Distance(name="link", body_a="first", body_b="second", point_a=(1.0, 0.0), point_b=(1.0, 1.0), length=1.0),
    )
    scene = Scene(name="bobs", bodies=(first, second), joints=rods)
    found = fitted_rates(scene, ["first.velocity"], CLOSED)
    assert np.allclose(found.bodies[0].velocity, (0.0, 3.0), atol=1e-12)
    assert np.allclose(found.bodies[1].velocity, (5.0, 3.0), atol=1e-12)


def test_an_unknown_name_is_told():
    with pytest.raises(ValueError, match="allowed: BODY"):
        fitted_rates(scenes.make("slider_crank"), ["crnk.angular_velocity"], CLOSED)
