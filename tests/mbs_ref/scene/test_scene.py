"""A scene refuses what makes no sense, and says what."""

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError

from mbs_ref import scene as language
from mbs_ref.scene.signals import HalfSine

ROD = language.PlanarBody(name="rod", mass=1.0, inertia=0.1, position=(0.5, 0.0))
TIP = language.PointMass(name="tip", mass=2.0, position=(1.0, 0.0), velocity=(0.0, 0.0))
PIN = language.Revolute(name="pin", body_a="ground", body_b="rod", point=(0.0, 0.0))


def scene(**changes):
    return language.Scene(**{"name": "trial", "bodies": (ROD,), "joints": (PIN,)} | changes)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["mass", "inertia"])
def test_mass_and_inertia_are_positive_and_finite(field, value):
    with pytest.raises(ValidationError, match=field):
        language.PlanarBody(**{"name": "rod", "mass": 1.0, "inertia": 1.0} | {field: value})


@pytest.mark.parametrize("field", ["position", "velocity"])
def test_a_nan_in_a_vector_is_refused(field):
    with pytest.raises(ValidationError, match="finite"):
        language.PlanarBody(**{"name": "rod", "mass": 1.0, "inertia": 1.0, field: (0.0, math.nan)})


@pytest.mark.parametrize("name", ["", "1rod", "a b", "rod/1", "x" * 65, "<b>"])
def test_a_name_is_a_word(name):
    with pytest.raises(ValidationError, match="name"):
        language.PlanarBody(name=name, mass=1.0, inertia=1.0)


def test_an_unknown_field_is_refused():
    with pytest.raises(ValidationError, match="positon"):
        language.PlanarBody.model_validate({"name": "rod", "mass": 1.0, "inertia": 1.0, "positon": (0.0, 0.0)})


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"bodies": ()}, "at least 1"),
        ({"bodies": (ROD, ROD)}, r"bodies\[1\]: the name 'rod' is taken by bodies\[0\]"),
        ({"joints": (PIN, PIN)}, r"joints\[1\]: the name 'pin' is taken by joints\[0\]"),
        ({"bodies": (ROD.model_copy(update={"name": "ground"}),)}, "reserved"),
        ({"joints": (PIN.model_copy(update={"body_b": "rood"}),)}, "body_b = 'rood' is no body of the scene"),
        ({"joints": (PIN.model_copy(update={"body_a": "rod"}),)}, "must differ"),
        ({"joints": (PIN.model_copy(update={"point": (0.0, 0.0, 0.0)}),)}, "must have 2 components"),
        ({"loads": (language.Torque(name="t", body="ground", torque=1.0),)}, "'ground' is no body"),
        ({"duration": 0.0}, "duration"),
        ({"gravity": (0.0, math.nan)}, "finite"),
    ],
)
def test_a_scene_is_checked_as_a_whole(changes, complaint):
    with pytest.raises(ValidationError, match=complaint):
        scene(**changes)


def test_a_direction_is_not_zero():
    with pytest.raises(ValidationError, match=r"axis = .* has no direction"):
        language.Prismatic(name="s", body_a="ground", body_b="rod", point=(0.0, 0.0), axis=(0.0, 0.0))
    with pytest.raises(ValidationError, match=r"direction = .* has no direction"):
        language.PointDrive.model_validate(
            {"name": "d", "body": "rod", "point": (0, 0), "direction": (0, 0), "motion": {"type": "constant"}}
        )


def test_a_distance_joint_of_no_length_needs_one():
    ends = {"name": "d", "body_a": "ground", "body_b": "rod", "point_a": (0.0, 0.0), "point_b": (0.0, 0.0)}
    with pytest.raises(ValidationError, match="coincide"):
        language.Distance(**ends)
    assert language.Distance(**ends, length=1.0).length == 1.0


def test_a_scene_is_frozen():
    with pytest.raises(ValidationError, match="frozen"):
        scene().duration = 2.0


def test_breakpoints_come_from_loads_and_drives():
    pulse = HalfSine(peak=1.0, duration=0.1, start=0.2)
    load = language.Force(name="hit", body="rod", point=(0.5, 0.0), vector=(1.0, 0.0), factor=pulse)
    assert scene(loads=(load,)).breakpoints() == pytest.approx([0.2, 0.3])


def test_indices_and_dimension():
    both = scene(bodies=(ROD, TIP))
    assert both.dimension == 2
    assert [both.body_index(name) for name in ("ground", "rod", "tip")] == [-1, 0, 1]


def test_every_complaint_is_listed():
    lost = PIN.model_copy(update={"name": "lost", "body_b": "rood"})
    with pytest.raises(ValidationError) as caught:
        scene(joints=(PIN, PIN, lost), gravity=(0.0, 0.0, -9.81))
    for place in ("gravity", "joints[1]", "joints[2] (lost)"):
        assert place in str(caught.value)


def test_a_particle_bears_no_torque_and_is_held_at_its_place():
    drive = {"type": "coordinate_drive", "name": "d", "body": "tip", "motion": {"type": "constant"}}
    away = language.Revolute(name="pin", body_a="ground", body_b="tip", point=(0.0, 0.0))
    for joint, complaint in ((drive | {"coordinate": "angle"}, "no orientation"), (away, "attached at")):
        with pytest.raises(ValidationError, match=complaint):
            scene(bodies=(TIP,), joints=(joint,))
    assert scene(bodies=(TIP,), joints=(drive | {"coordinate": "x"},)).joints


def test_a_particle_bears_no_bushing_s_couple():
    bushing = language.PointBushing(name="pad", body_a="tip", body_b="rod", point=(1.0, 0.0), stiffness=1.0)
    with pytest.raises(ValidationError, match="cannot bear the bushing's couple; let it be body_b"):
        scene(bodies=(ROD, TIP), loads=(bushing,))
    turned = bushing.model_copy(update={"body_a": "rod", "body_b": "tip"})
    assert scene(bodies=(ROD, TIP), loads=(turned,))


def test_a_large_scene_is_checked_in_one_pass():
    bodies = tuple(ROD.model_copy(update={"name": f"b{k}"}) for k in range(20_000))
    joints = tuple(PIN.model_copy(update={"name": f"j{k}", "body_b": f"b{k}"}) for k in range(20_000))
    assert len(scene(bodies=bodies, joints=joints).joints) == 20_000  # minutes if each joint looked at every body
