"""Files with known faults: each is read, judged, and its fault is named with its size."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.columns import columns_of, read_columns
from cross_checks.trajectory_files.formats import Columns, FileError
from cross_checks.trajectory_files.judgement import as_truth, judgement
from cross_checks.trajectory_files.mistakes import suspicions
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.motion import described_motion, read_motion
from cross_checks.truths import truth_for
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.poses_file import write_poses

ASKED = 1e-6
TOP = scenes.make("torque_free_top", turns=2)  # in closed form by elliptic functions
PENDULUM = scenes.make("pendulum_chain", links=1)  # a rod


@cache
def truth_at(scene_name: str, times: tuple[float, ...]) -> Truth:
    found = truth_for({"torque_free_top": TOP, "pendulum_chain": PENDULUM}[scene_name], np.array(times))
    assert found is not None
    return found


def at(scene: Scene):
    return lambda times: truth_at(scene.name, tuple(times.tolist()))


@cache
def right(scene_name: str) -> Trajectory:
    scene = {"torque_free_top": TOP, "pendulum_chain": PENDULUM}[scene_name]
    return simulate(scene, Settings(method="dop853", rtol=1e-12, samples=41, estimate="off"))


def case_of(scene: Scene, columns: dict[str, np.ndarray], body: dict, world: dict | None = None) -> Case:
    """Return the case of a file with these columns, of the scene's only body."""
    stated = ColumnMap.model_validate({
        "time": {"column": "t", "unit": "s"}, "bodies": {scene.body_names[0]: body}, "world": world or {},
    })  # fmt: skip
    table = Columns(Path("tool.csv"), columns)
    path = described_motion(scene, table, stated).path
    return Case(scene, table, stated, path, at(scene)(path.times))


def top_columns(path: Trajectory) -> dict[str, np.ndarray]:
    turn = Rotation.from_quat(path.orientation[:, 0], scalar_first=True)
    w, x, y, z = path.orientation[:, 0].T
    yaw, pitch, roll = turn.as_euler("ZYX", degrees=True).T
    body_rates = np.degrees(turn.inv().apply(path.angular_velocity[:, 0]))
    columns = dict(t=path.times, w=w, x=x, y=y, z=z, yaw=yaw, pitch=pitch, roll=roll)
    return columns | {axis: body_rates[:, k] for k, axis in enumerate("pqr")}


QUATERNION = {"columns": ["w", "x", "y", "z"], "convention": "quaternion wxyz", "maps": "body to world"}
EULER = {"columns": ["yaw", "pitch", "roll"], "convention": "euler ZYX", "unit": "deg", "maps": "body to world"}
RATES = {"columns": ["p", "q", "r"], "unit": "deg/s", "axes": "body"}


@pytest.mark.parametrize("scene", [PENDULUM, TOP], ids=lambda scene: scene.name)
@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_file_of_simulate_judges_to_what_simulate_said(scene, suffix, tmp_path):
    path = right(scene.name)
    write_poses(path, list(scene.body_names), tmp_path / f"run{suffix}")
    read = read_motion(tmp_path / f"run{suffix}", scene)
    for part in ("times", "position", "velocity", "angular_velocity"):
        np.testing.assert_array_equal(getattr(read.motion.path, part), getattr(path, part))
    np.testing.assert_allclose(read.motion.path.orientation, path.orientation, rtol=0.0, atol=4e-16)
    assert not read.motion.missing
    found = judgement(scene, read.motion, at(scene)(path.times), ASKED)
    assert found.verdict == "agrees"
    assert found.error is not None
    assert found.error.value < 1e-10
    itself, other = as_truth(scene, read.motion, read.motion, "itself")
    again = judgement(scene, itself, other, ASKED)
    assert again.error is not None
    assert again.error.value == 0.0


def test_aerospace_conventions_are_read_when_stated():
    columns = top_columns(right("torque_free_top"))
    for orientation in (QUATERNION, EULER):
        case = case_of(TOP, columns, {"orientation": orientation, "angular_velocity": RATES})
        assert case.error < 1e-10
        assert suspicions(case, ASKED) == []


def test_a_matrix_and_an_inverse_are_read_when_stated():
    path = right("torque_free_top")
    rows = Rotation.from_quat(path.orientation[:, 0], scalar_first=True).inv().as_matrix().reshape(-1, 9)
    columns = {"t": path.times} | {f"a{k}": rows[:, k] for k in range(9)}
    stated = {"columns": [f"a{k}" for k in range(9)], "convention": "matrix", "maps": "world to body"}
    assert case_of(TOP, columns, {"orientation": stated}).error < 1e-10


def size_in(sentence: str, pattern: str) -> float:
    found = re.search(pattern, sentence)
    assert found, sentence
    return float(found[1])


@pytest.mark.parametrize(("stated", "expected"), [
    ({"orientation": {**EULER, "unit": "rad"}}, "the orientation columns look like deg; rad is stated"),
    ({"orientation": {**QUATERNION, "columns": ["x", "y", "z", "w"]}},
     "the orientation columns look like quaternion xyzw; quaternion wxyz is stated"),
    ({"orientation": {**QUATERNION, "maps": "world to body"}}, "look like body to world; world to body is stated"),
    ({"orientation": {**EULER, "convention": "euler zyx"}}, "look like euler ZYX; euler zyx is stated"),
    ({"orientation": QUATERNION, "angular_velocity": {**RATES, "unit": "rad/s"}},
     "the angular velocity columns look like deg/s; rad/s is stated"),
    ({"orientation": QUATERNION, "angular_velocity": {**RATES, "axes": "world"}}, "look like body; world is stated"),
])  # fmt: skip
def test_a_convention_that_is_stated_wrongly_is_named(stated, expected):
    case = case_of(TOP, top_columns(right("torque_free_top")), stated)
    assert case.error > 1e-2
    sentences = suspicions(case, ASKED)
    assert len(sentences) == 1
    assert expected in sentences[0]


def plane_columns(path: Trajectory) -> dict[str, np.ndarray]:
    (x, y), (vx, vy) = path.position[:, 0].T, path.velocity[:, 0].T
    return dict(t=path.times, x=x, y=y, angle=path.orientation[:, 0], vx=vx, vy=vy, rate=path.angular_velocity[:, 0])


PLANE = {
    "position": {"columns": ["x", "y"], "unit": "m"},
    "orientation": {"columns": ["angle"], "convention": "angle", "unit": "rad"},
    "velocity": {"columns": ["vx", "vy"], "unit": "m/s"},
    "angular_velocity": {"columns": ["rate"], "unit": "rad/s"},
}


@pytest.mark.parametrize(("scale", "word"), [(1000.0, "mm"), (1.0 / 0.3048, "ft")])
def test_a_length_in_another_unit_is_named(scale, word):
    columns = plane_columns(right("pendulum_chain"))
    for name in ("x", "y"):
        columns[name] = columns[name] * scale
    case = case_of(PENDULUM, columns, PLANE)
    assert f"the position columns look like {word}; m is stated" in suspicions(case, ASKED)[0]


@pytest.mark.parametrize("lag", [1e-3, *(pytest.param(lag, marks=pytest.mark.slow) for lag in (2e-2, -5e-3))])
def test_a_clock_that_lags_is_named_with_its_size(lag):
    times = np.linspace(0.1, PENDULUM.duration - 0.1, 41)
    truth = truth_at("pendulum_chain", tuple((times - lag).tolist()))
    (x, y), angle = truth.position[:, 0].T, truth.orientation[:, 0]
    columns = dict(t=times, x=x, y=y, angle=angle)
    case = case_of(PENDULUM, columns, {part: PLANE[part] for part in ("position", "orientation")})
    sentence = suspicions(case, ASKED)[0]
    assert ("late" if lag > 0.0 else "early") in sentence
    assert size_in(sentence, r"by ([\d.e-]+) s") == pytest.approx(abs(lag), rel=1e-3)


def test_a_turned_and_a_shifted_world_are_named_with_their_sizes():
    path = right("pendulum_chain")
    turn, away = np.radians(30.0), np.array([0.5, -0.25])
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    seen = Trajectory(path.times, path.position @ matrix.T + away, path.orientation + turn, path.velocity @ matrix.T,
                      path.angular_velocity)  # fmt: skip
    sentence = suspicions(case_of(PENDULUM, plane_columns(seen), PLANE), ASKED)[0]
    assert "world is turned by -30 deg" in sentence or "world is turned by 30 deg about (0, 0, -1)" in sentence
    assert case_of(PENDULUM, plane_columns(path), PLANE).error < 1e-10


def test_a_world_with_y_up_is_named_and_read_when_stated():
    path = right("torque_free_top")
    up = Rotation.from_euler("x", -90.0, degrees=True)  # scene's z is the file's y
    turned = (up * Rotation.from_quat(path.orientation[:, 0], scalar_first=True)).as_quat(scalar_first=True)
    columns = {"t": path.times} | dict(zip("wxyz", turned.T, strict=True))
    wrong = case_of(TOP, columns, {"orientation": QUATERNION})
    assert size_in(suspicions(wrong, ASKED)[0], r"world is turned by ([\d.]+) deg about \(1, 0, 0\)") == 90.0
    assert case_of(TOP, columns, {"orientation": QUATERNION}, {"axes": ["x", "-z", "y"]}).error < 1e-10


def test_body_axes_that_are_turned_are_named_with_their_angle():
    path = right("torque_free_top")
    frame = Rotation.from_euler("z", 10.0, degrees=True)
    turned = (Rotation.from_quat(path.orientation[:, 0], scalar_first=True) * frame).as_quat(scalar_first=True)
    case = case_of(TOP, {"t": path.times} | dict(zip("wxyz", turned.T, strict=True)), {"orientation": QUATERNION})
    assert size_in(suspicions(case, ASKED)[0], r"body axes are turned: \w+ by ([\d.]+) deg") == pytest.approx(10.0)


def test_positions_of_another_point_are_named_with_its_place():
    path = right("pendulum_chain")
    arm = 0.5 * np.stack([np.cos(path.orientation[:, 0]), np.sin(path.orientation[:, 0])], axis=-1)
    away = np.stack([-arm[:, 1], arm[:, 0]], axis=-1) * path.angular_velocity
    seen = Trajectory(path.times, path.position + arm[:, None], path.orientation, path.velocity + away[:, None],
                      path.angular_velocity)  # fmt: skip
    sentence = suspicions(case_of(PENDULUM, plane_columns(seen), PLANE), ASKED)[0]
    assert "at (0.5, 0) m in body axes" in sentence


def test_two_mistakes_are_named_both_the_larger_first():
    times = np.linspace(0.1, 1.0, 41)
    truth = truth_at("pendulum_chain", tuple((times - 5e-3).tolist()))
    (x, y), angle = 1e3 * truth.position[:, 0].T, truth.orientation[:, 0]
    stated = {part: PLANE[part] for part in ("position", "orientation")}
    sentences = suspicions(case_of(PENDULUM, dict(t=times, x=x, y=y, angle=angle), stated), ASKED)
    assert "look like mm" in sentences[0]
    assert size_in(sentences[1], r"late by ([\d.e-]+) s") == pytest.approx(5e-3, rel=1e-3)


def test_a_term_that_was_left_out_is_named():
    scene = scenes.make("spring_pendulum")
    truth = truth_for(scene, np.linspace(0.0, scene.duration, 41))
    assert truth is not None
    settings = Settings(rtol=1e-11, samples=41, estimate="off")
    spring = f"without the load {scene.loads[0].name!r}"
    for changed, expected in (({"gravity": (0.0, 0.0)}, "without gravity"), ({"loads": ()}, spring)):
        path = simulate(scene.model_copy(update=changed), settings)
        columns, name = plane_columns(path), scene.body_names[0]
        stated = ColumnMap.model_validate({"time": {"column": "t", "unit": "s"}, "bodies": {name: PLANE}})
        table = Columns(Path("tool.csv"), columns)
        seen = described_motion(scene, table, stated)
        case = Case(scene, table, stated, seen.path, truth)
        sentences = suspicions(case, ASKED)
        assert expected in sentences[0]


def test_what_the_file_does_not_tell_is_said_and_not_counted():
    columns = plane_columns(right("pendulum_chain"))
    case = case_of(PENDULUM, columns, {"position": PLANE["position"]})
    seen = described_motion(PENDULUM, case.columns, case.stated)
    name = PENDULUM.body_names[0]
    assert seen.missing == (f"the file does not state orientation, velocity, angular velocity of {name}",)
    found = judgement(PENDULUM, seen, case.truth, ASKED)
    assert found.verdict == "agrees"
    assert [part.below is None for part in found.parts] == [False, True, True, True]
    assert all(part.largest is None for part in found.parts)  # right to what the truth knows
    assert found.measures["energy_drift"] is None


def file_of(folder: Path, text: str) -> Path:
    target = folder / "tool.csv"
    target.write_text(text)
    return target


@pytest.mark.parametrize(("text", "message"), [
    ("", "is empty; expected: a header"),
    ("t,x\n", "holds no row of numbers"),
    ("0,1\n1,2\n", "line 1 holds numbers; expected: the names of the columns"),
    ("t,x\n0,1\n1\n", "line 3 has 1 cells; expected: 2"),
    ("t,x\n0,1\n\n1,two\n", "line 4, column 'x': 'two' is no number"),
    ("t,x\n0,1\n1,nan\n", "line 3, column 'x': nan is not finite"),
    ("t,x,x\n0,1,1\n", "column 'x' stands 2 times"),
])  # fmt: skip
def test_a_bad_file_is_refused_with_the_line_and_what_is_expected(text, message, tmp_path):
    with pytest.raises(FileError, match=re.escape(message)):
        read_columns(file_of(tmp_path, text))


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_the_delimiter_is_the_one_of_the_header_unless_stated(mark, tmp_path):
    text = f"# run, of 3; tools\n\nt{mark}7\n0{mark}1\n2{mark}3\n"  # a name may be a number, as long as not all are
    for stated in ("", mark):
        read = read_columns(file_of(tmp_path, text), stated)
        assert {name: list(column) for name, column in read.values.items()} == {"t": [0.0, 2.0], "7": [1.0, 3.0]}
    with pytest.raises(FileError, match="line 4"):
        read_columns(file_of(tmp_path, text), "|")


PLACE, SPIN = ["x", "y"], {**RATES, "axes": None}


def refusal(columns: dict, body: dict, scene: Scene = PENDULUM) -> str:
    with pytest.raises((FileError, ValueError)) as refused:
        case_of(scene, columns, body)
    return str(refused.value)


def test_a_bad_map_or_table_is_refused_with_what_is_allowed():
    columns = plane_columns(right("pendulum_chain"))
    assert "did you mean 'x'" in refusal(columns, {"position": {"columns": ["xx", "y"], "unit": "m"}})
    assert "expected: 2" in refusal(columns, {"position": {"columns": ["x"], "unit": "m"}})
    assert "is no unit of length; allowed: m, mm" in refusal(columns, {"position": {"columns": PLACE, "unit": "mile"}})
    assert "unit" in refusal(columns, {"position": {"columns": PLACE}})
    assert "does not fit a scene in 2 dimensions" in refusal(columns, {"orientation": QUATERNION})
    with pytest.raises(FileError, match="times must increase"):
        columns_of(columns | {"t": columns["t"][::-1]})
    late = columns | {"t": columns["t"] + 1.0}
    assert "lies outside of the scene's 0 to" in refusal(late, PLANE)
    top = top_columns(right("torque_free_top"))
    assert "axes is missing" in refusal(top, {"orientation": QUATERNION, "angular_velocity": SPIN}, TOP)
    assert "maps is missing" in refusal(top, {"orientation": {**QUATERNION, "maps": None}}, TOP)
    assert "no rotation: the norm less one" in refusal(top | {"w": 2.0 * top["w"]}, {"orientation": QUATERNION}, TOP)
