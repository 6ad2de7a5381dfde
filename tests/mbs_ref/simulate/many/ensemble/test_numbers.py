"""Every number of a scene has a name, and changing it changes that number alone."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from mbs_ref import scenes
from mbs_ref.scene import Force, PlanarBody, PointMass, Scene, SpatialBody, SpringDamper
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.signals import Table
from mbs_ref.scene.toml import dumps
from mbs_ref.simulate.many.ensemble.variants import place_of, value_at, with_values

FORCE = Force(name="push", body="a", point=(0.0, 0.0), vector=(1.0, 2.0),
              factor=Table(times=(0.0, 1.0, 2.0), values=(3.0, 4.0, 5.0)))  # fmt: skip
SPRING = SpringDamper(name="a.spring", body_a="a", body_b="a.b", point_a=(0.0, 0.0), point_b=(7.0, 0.0), stiffness=9.0)
PLANE = Scene(
    name="names", gravity=(0.5, -9.5), loads=(FORCE, SPRING),
    bodies=(PlanarBody(name="a", mass=1.0, inertia=2.0),
            PlanarBody(name="a.b", mass=3.0, inertia=4.0, position=(7.0, 8.0), angle=0.25)),
)  # fmt: skip
PAIR = Scene(
    name="pair", gravity=(0.0, 0.0, 0.0), loads=(Newton(name="newton", gm=(1.0, 2.0), radius=(0.1, 0.2)),),
    bodies=tuple(PointMass(name=f"p{k}", mass=1.0, position=(k, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)) for k in (0, 1)),
)  # fmt: skip
SPACE = Scene(name="space", gravity=(0.0, 0.0, -1.0), bodies=(
    SpatialBody(name="brick", mass=1.0, inertia=(1.0, 1.1, 1.2, 0.01, 0.02, 0.03), angular_velocity=(4.0, 5.0, 6.0)),
))  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "name", "value"),
    [(PLANE, "a.mass", 1.0), (PLANE, "a.b.mass", 3.0), (PLANE, "a.b.position.y", 8.0), (PLANE, "a.b.angle", 0.25),
     (PLANE, "a.spring.stiffness", 9.0), (PLANE, "a.spring.point_b.x", 7.0), (PLANE, "a.spring.rest_length", None),
     (PLANE, "a.spring.damping", 0.0), (PLANE, "push.vector.y", 2.0), (PLANE, "push.factor.values.1", 4.0),
     (PLANE, "push.factor.times.2", 2.0), (PAIR, "newton.gm.1", 2.0), (PAIR, "newton.radius.0", 0.1),
     (PAIR, "p1.position.x", 1.0), (PLANE, "gravity.y", -9.5),
     (SPACE, "brick.inertia.yz", 0.03), (SPACE, "brick.angular_velocity.z", 6.0)],
)  # fmt: skip
def test_a_name_leads_to_its_number_and_changes_it_alone(scene, name, value):
    place = place_of(scene, name)
    assert value_at(scene, place) == value
    other = (value or 0.0) + 0.001
    changed = with_values(scene, {place: other})
    assert value_at(changed, place) == other
    assert with_values(changed, {place: value}) == scene
    before, after = dumps(scene).split(), dumps(changed).split()
    assert sum(word not in before for word in after) <= 2  # the number; its name too where it had been left open


@pytest.mark.parametrize(
    ("name", "said"),
    [("a.mas", "did you mean 'mass'"), ("b.mass", "it begins with gravity or a part: a, a.b, push, a.spring"),
     ("mass", "it begins with"), ("gravity.z", "gravity.x, gravity.y"), ("a.name", "numbers of 'a'"), ("", "unknown"),
     ("a.position", "position.x"), ("a.b", "numbers of 'a'"), ("a.spring.tension_only", "stiffness")],
)  # fmt: skip
def test_a_name_that_is_none_says_what_there_is(name, said):
    with pytest.raises(ValueError, match=said):
        place_of(PLANE, name)


def test_euler_parameters_are_not_varied_one_by_one():
    with pytest.raises(ValueError, match=r"'brick\.orientation\.0' is unknown.*turn\.x, turn\.y, turn\.z"):
        place_of(SPACE, "brick.orientation.0")


def test_several_numbers_change_at_once_and_the_scene_is_checked():
    places = [place_of(PLANE, name) for name in ("a.mass", "a.b.velocity.x", "push.factor.times.2")]
    changed = with_values(PLANE, dict(zip(places, (5.0, 6.0, 7.0), strict=True)))
    assert [value_at(changed, place) for place in places] == [5.0, 6.0, 7.0]
    with pytest.raises(ValidationError, match="greater than 0"):
        with_values(PLANE, {places[0]: -1.0})


def test_every_scene_of_the_library_has_names_for_its_bodies():
    for name in ("slider_crank", "heavy_top", "kepler", "bouncing_ball", "flyball_governor"):
        scene = scenes.make(name)
        for body in scene.bodies:
            assert value_at(scene, place_of(scene, f"{body.name}.mass")) == body.mass
