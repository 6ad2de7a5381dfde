"""A random motion written in any unit, axes, origin and convention, by formulas of its own, is read as it was."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy import constants
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.columns import columns_of
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.judgement import as_truth, judgement
from cross_checks.trajectory_files.motion import DescribedMotion, described_motion
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

SI = {
    "m": 1.0, "mm": constants.milli, "cm": constants.centi, "km": constants.kilo, "ft": constants.foot,
    "in": constants.inch, "au": constants.au, "rad": 1.0, "deg": constants.degree, "rev": 2.0 * constants.pi,
    "s": 1.0, "ms": constants.milli, "us": constants.micro, "min": constants.minute, "h": constants.hour,
    "day": constants.day,
}  # fmt: skip
TOP, PENDULUM = scenes.make("torque_free_top"), scenes.make("double_pendulum")
TIMES = np.array([0.0, 0.07, 0.31, 0.4, 0.93])


@pytest.mark.parametrize("kind", ["length", "angle", "time", "velocity", "angular velocity"])
def test_every_unit_is_what_it_is_elsewhere(kind):
    for unit in units.allowed(kind):
        above, _, below = unit.partition("/")
        assert units.factor(kind, unit) == pytest.approx(SI[above] / SI[below or "s"], rel=1e-12)


def read(scene: Any, arrays: dict[str, np.ndarray], body: dict[str, Any], **world: Any) -> DescribedMotion:
    stated = {"time": {"column": "t", "unit": "ms"}, "bodies": {scene.body_names[-1]: body}, "world": world}
    return described_motion(scene, columns_of(arrays), ColumnMap.model_validate(stated))


def named(name: str, count: int) -> list[str]:
    return [f"{name}[{k}]" for k in range(count)]


@pytest.mark.parametrize("maps", ["body to world", "world to body"])
@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (0.3, -0.7, 1.1)])
@pytest.mark.parametrize("axes", ["body", "world"])
def test_space(maps, spin, axes):
    rng, n = np.random.default_rng(3), len(TIMES)
    place, speed, omega = (rng.normal(size=(n, 3)) for _ in range(3))
    turn, origin = Rotation.from_rotvec(rng.normal(size=(n, 3))), rng.normal(size=3)
    swap = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])  # scene x is file -y, y is z, z is -x
    world = [Rotation.from_rotvec(t * np.array(spin)).as_matrix() @ swap for t in TIMES]  # file to scene
    seen = speed - np.cross(spin, place - origin)
    into = lambda vectors: np.array([w.T @ v for w, v in zip(world, vectors, strict=True)])  # noqa: E731
    bodies = Rotation.from_matrix([w.T @ one.as_matrix() for w, one in zip(world, turn, strict=True)])
    written = bodies.inv() if maps == "world to body" else bodies
    arrays = {
        "t": TIMES * 1e3, "r": into(place - origin) / constants.foot, "v": into(seen) * 6e4,  # mm/min
        "q": written.as_quat(), "w": (turn.inv().apply(omega) if axes == "body" else into(omega)) / constants.degree,
    }  # fmt: skip
    body = {
        "position": {"columns": named("r", 3), "unit": "ft"}, "velocity": {"columns": named("v", 3), "unit": "mm/min"},
        "orientation": {"columns": named("q", 4), "convention": "quaternion xyzw", "maps": maps},
        "angular_velocity": {"columns": named("w", 3), "unit": "deg/s", "axes": axes},
    }  # fmt: skip
    path = read(TOP, arrays, body, axes=["-y", "z", "-x"], origin=origin.tolist(), spin=spin).path
    assert np.allclose(path.times, TIMES)
    assert np.allclose(path.position[:, -1], place)
    assert np.allclose(path.velocity[:, -1], speed)
    assert np.allclose(path.angular_velocity[:, -1], omega)
    assert np.allclose(Rotation.from_quat(path.orientation[:, -1], scalar_first=True).as_matrix(), turn.as_matrix())


def test_plane():
    """The file's x axis points along the scene's y axis: an angle of 0 in the file is a quarter turn."""
    arrays = {"t": TIMES * 1e3, "a": np.degrees(TIMES)[:, None], "r": np.column_stack((TIMES, 2.0 * TIMES))}
    body = {"position": {"columns": named("r", 2), "unit": "cm"},
            "orientation": {"columns": ["a[0]"], "convention": "angle", "unit": "deg"}}  # fmt: skip
    path = read(PENDULUM, arrays, body, axes=["-y", "x"], origin=[3.0, -4.0]).path
    assert np.allclose(path.orientation[:, -1], TIMES + np.pi / 2.0)
    assert np.allclose(path.position[:, -1], np.column_stack((3.0 - 0.02 * TIMES, -4.0 + 0.01 * TIMES)))


@pytest.mark.parametrize("times", [[0.0, 0.5, 0.5], [-1e-3, 0.5, 1.0], [0.0, 0.5, 1e9]])
def test_times_that_repeat_or_leave_the_duration_are_refused(times):
    arrays = {"t": np.array(times) * 1e3, "a": np.zeros((3, 1))}
    body = {"orientation": {"columns": ["a[0]"], "convention": "angle", "unit": "deg"}}
    with pytest.raises(FileError, match="row"):
        read(PENDULUM, arrays, body)


def moved(position: np.ndarray, times: np.ndarray = TIMES) -> Trajectory:
    """Return bodies at rest at angle 0."""
    still = np.zeros(position.shape[:2])
    return Trajectory(times, position, still, np.zeros_like(position), still)


def test_the_largest_error_of_each_body_is_shown_in_its_unit_and_the_worst_first():
    """The second body is the worse one, and neither is worst at the end."""
    truth = moved(np.zeros((5, 2, 2)))
    position = np.zeros((5, 2, 2))
    position[:, 0, 0] = 1e-3 * np.array([0.0, 5.0, 1.0, 2.0, 3.0])
    position[:, 1, 1] = 1e-3 * np.array([0.0, 1.0, 2.0, 9.0, 4.0])
    exact = Truth(truth.position, truth.orientation, 0.0, "exact", "", velocity=truth.velocity,
                  angular_velocity=truth.angular_velocity, rate_uncertainty=np.zeros(5))  # fmt: skip
    judged = judgement(PENDULUM, DescribedMotion(moved(position), ()), exact, 1e-9)
    parts = [part for part in judged.parts if part.component == "position"]
    length = scales_of(PENDULUM).length
    figures = [(part.largest, part.at, part.final) for part in parts]
    assert figures == [pytest.approx((5e-3, 0.07, 3e-3)), pytest.approx((9e-3, 0.4, 4e-3))]
    assert [p.relative for p in parts] == pytest.approx([5e-3 / length, 9e-3 / length])
    first, second = PENDULUM.body_names
    assert str(judged).index(f"{second} position: 0.009 m") < str(judged).index(f"{first} position: 0.005 m")


def test_two_files_are_compared_where_their_times_agree():
    other = np.array([0.0, 0.1, 0.31, 0.93])
    first, second = moved(np.random.default_rng(0).normal(size=(5, 2, 2))), moved(np.ones((4, 2, 2)), other)
    ours, truth = as_truth(PENDULUM, DescribedMotion(first, ()), DescribedMotion(second, ()), "second.csv")
    assert ours.path.times.tolist() == [0.0, 0.31, 0.93]
    assert np.array_equal(ours.path.position, first.position[[0, 2, 4]])
    assert truth.position.shape == (3, 2, 2)


PLACE = {"columns": named("r", 3), "unit": "m"}
TURN = {"columns": named("q", 4), "convention": "quaternion wxyz", "maps": "body to world"}
SPIN_AXES = {"columns": named("r", 3), "unit": "rad/s"}
FLAT = {"columns": named("r", 2), "unit": "m"}


@pytest.mark.parametrize(("scene", "body", "world", "message"), [
    (TOP, {"angular_velocity": SPIN_AXES | {"axes": "body"}}, {},
     "angular_velocity.axes = 'body' needs the orientation, which the file does not state"),
    (TOP, {"angular_velocity": SPIN_AXES}, {}, "angular_velocity.axes is missing; allowed: world, body"),
    (TOP, {"orientation": {**TURN, "maps": None}}, {},
     "orientation.maps is missing; allowed: body to world, world to body"),
    (TOP, {"orientation": {"columns": ["t"], "convention": "angle", "unit": "deg"}}, {},
     "orientation.convention = 'angle' does not fit a scene in 3 dimensions"),
    (PENDULUM, {"orientation": TURN}, {},
     "orientation.convention = 'quaternion wxyz' does not fit a scene in 2 dimensions"),
    (PENDULUM, {"orientation": {"columns": ["t"], "convention": "angle"}}, {},
     "orientation.unit is missing; allowed: rad, deg, rev"),
    (TOP, {"position": {"columns": named("r", 2), "unit": "m"}}, {}, "position.columns: 2 are given; expected: 3"),
    (TOP, {"position": PLACE}, {"axes": ["x", "z", "y"]}, "mirrors the world: those axes are left-handed"),
    (TOP, {"position": PLACE}, {"axes": ["x", "y"]}, "has 2 axes; the scene has 3"),
    (PENDULUM, {"position": FLAT}, {"spin": [0.0, 0.0, 1.0]}, "world.spin and world.turned are for scenes in space"),
    (TOP, {"position": PLACE, "velocity": PLACE | {"unit": "m/s"}},
     {"turned": {"column": "t", "unit": "deg"}}, "a frame whose angle is a column is unknown; remove `velocity`"),
])  # fmt: skip
def test_a_statement_that_does_not_fit_is_named_with_what_does(scene, body, world, message):
    n = len(TIMES)
    arrays = {"t": TIMES * 1e3, "r": np.ones((n, 3)), "q": np.tile((1.0, 0.0, 0.0, 0.0), (n, 1))}
    with pytest.raises(FileError, match=re.escape(message)):
        read(scene, arrays, body, **world)


def test_a_body_that_the_scene_lacks_is_named_with_the_nearest():
    stated = {"time": {"column": "t", "unit": "s"}, "bodies": {PENDULUM.body_names[0][:-1]: {"position": FLAT}}}
    with pytest.raises(FileError, match=f"the scene has no such body.*allowed: {', '.join(PENDULUM.body_names)}$"):
        described_motion(PENDULUM, columns_of({"t": TIMES}), ColumnMap.model_validate(stated))
