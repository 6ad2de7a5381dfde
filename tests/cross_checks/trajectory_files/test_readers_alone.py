"""Parts of the readers and of the search for mistakes, against random rotations, clocks and tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.metrics import every
from cross_checks.trajectory_files import library, mistakes
from cross_checks.trajectory_files.column_map import OWN, _named
from cross_checks.trajectory_files.columns import _checked, _marked, columns_of, read_columns
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.judgement import _ERRORS, as_truth, judgement
from cross_checks.trajectory_files.mistakes import case as cases
from cross_checks.trajectory_files.mistakes.frames import _turned
from cross_checks.trajectory_files.mistakes.terms import _factors
from cross_checks.trajectory_files.motion import DescribedMotion, _Reader
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from tests.cross_checks.trajectory_files.test_figures_of_judgements import SCENE, irregular

RNG = np.random.default_rng(21)


def reader(**own: Any) -> Any:
    """Return a reader of a part of a file, whose columns are given."""
    made: Any = object.__new__(_Reader)
    made.__dict__ |= {"planar": False, "dimension": 3, "body": "rod", "turning": None, "turn": np.eye(3)} | own
    return made


@pytest.mark.parametrize("size", [0.5, 1.5])
def test_numbers_that_are_no_unit_quaternion_are_refused(size):
    numbers = RNG.normal(size=(3, 4))
    numbers *= size / np.linalg.norm(numbers, axis=1, keepdims=True)
    made = reader(_numbers=lambda *given: numbers, columns=SimpleNamespace(place=lambda row, name: f"row {row}"))
    part: Any = SimpleNamespace(convention="quaternion wxyz", columns=("a",), maps="body to world")
    with pytest.raises(FileError, match=r"row 0: no rotation: the norm less one is 0\.5"):
        made._rotation(part, "bodies.rod.orientation")
    numbers /= size
    found = made._rotation(part, "")
    assert found.as_matrix() == pytest.approx(Rotation.from_quat(numbers, scalar_first=True).as_matrix())


def test_a_turned_column_turns_within_the_world_that_spins():
    """A point that is fixed in the file's world is first turned about the world's axis, then carried by the spin."""
    times, spin, angle = RNG.uniform(0.0, 2.0, 5), RNG.normal(size=3), RNG.normal(size=5)
    turned: Any = SimpleNamespace(column="a", unit="rad", about="z")
    columns = SimpleNamespace(values={"a": angle}, place=lambda *given: "")
    made = reader(world=SimpleNamespace(spin=tuple(spin), turned=turned), columns=columns)
    point = np.array([0.3, -1.2, 0.7])
    for t, own, found in zip(times, angle, made._turning(times).apply(point), strict=True):
        c, s = np.cos(own), np.sin(own)
        within = np.array([c * point[0] - s * point[1], s * point[0] + c * point[1], point[2]])
        assert found == pytest.approx(Rotation.from_rotvec(t * spin).apply(within))


def test_a_clock_that_goes_back_is_named_with_both_times():
    part: Any = SimpleNamespace(values={"t": np.array([1.0, 2.0, 1.5])}, place=lambda row, name: f"row {row}")
    with pytest.raises(FileError, match=r"row 2: 1\.5 follows 2; times must increase"):
        _checked(part, "t", 0.0)
    with pytest.raises(FileError, match="row 0: 1 follows 7; times must increase"):
        _checked(part, "t", 7.0)
    part.values["t"][2] = 2.5
    assert _checked(part, "t", 0.0) == 2.5


def test_columns_of_a_part_keep_their_order():
    for world, parts in OWN.items():
        for name, own in _named(world, "x.{}").items():
            assert own["columns"] == [f"x.{column}" for column in parts[name]["columns"]]
            assert own | {"columns": 0} == parts[name] | {"columns": 0}


@pytest.mark.parametrize("shift", [-1e-13, 1e-13])
def test_times_a_rounding_apart_are_common(shift):
    path, _, _ = irregular(7)
    other = replace(path, times=path.times * (1.0 + shift))
    first, truth = as_truth(SCENE, DescribedMotion(path, ()), DescribedMotion(other, ()), "b.csv")
    assert len(first.path.times) == len(truth.position) == len(path.times)


def test_errors_of_a_judgement_are_no_figures_of_its_own():
    path, truth, _ = irregular(8)
    found = judgement(SCENE, DescribedMotion(path, ()), truth, 1e-9)
    own = next(value for value in vars(found).values() if isinstance(value, dict) and "compliance_position" in value)
    assert set(own) == set(every()) - set(_ERRORS)


def test_a_turned_plane_turns_places_and_angles_alike():
    path, _, _ = irregular(9)
    turn = 0.7
    found = _turned(path, Rotation.from_rotvec([0.0, 0.0, turn]))
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    assert found.position == pytest.approx(np.einsum("ij,tbj->tbi", matrix, path.position))
    assert found.velocity == pytest.approx(np.einsum("ij,tbj->tbi", matrix, path.velocity))
    assert found.orientation == pytest.approx(path.orientation + turn)


def test_a_factor_common_to_two_parts_is_tried():
    """Both joints' springs of a scene are off by one factor: a single one explains neither."""
    scene = scenes.make("double_pendulum")
    said = [hypothesis.say(np.array([2.0])) for hypothesis in _factors(scene)]
    assert sum("of every" in sentence for sentence in said) >= 2
    assert any("mass" in sentence and "of every" in sentence for sentence in said)


def test_a_lagging_clock_shows_the_motion_of_earlier_times(monkeypatch):
    path, truth, _ = irregular(10)
    monkeypatch.setattr(cases, "simulate", lambda scene, settings, times: replace(
        path, times=times, position=np.tile(times[:, None, None], (1, 2, 2)), orientation=np.tile(times[:, None], 2),
        velocity=np.tile(times[:, None, None], (1, 2, 2)), angular_velocity=np.tile(times[:, None], 2)))  # fmt: skip
    case: Any = cases.Case(SCENE, None, None, path, truth)  # type: ignore[arg-type]
    lag = 0.05 * SCENE.duration
    found = case.rerun(late=lag, rates_late=0.5 * lag)
    for part, late in ((found.truth.position, lag), (found.truth.velocity, 1.5 * lag)):
        seen = path.times - late
        inside = (seen >= 0.0) & (seen <= SCENE.duration)
        assert part[inside, 0, 0] == pytest.approx(seen[inside])
        assert np.isnan(part[~inside]).all()
        assert not inside.all()


def made_case(error: float) -> Any:
    return SimpleNamespace(error=error)


@pytest.mark.parametrize(("left", "named"), [
    ({"a": (0, 0.2)}, None),  # a fifth of the error may be chance
    ({"a": (1, 2e-3), "b": (0, 5e-3), "c": (0, 9e-2)}, "b"),  # of two that leave as little, the one without a number
    ({"a": (1, 1e-4), "b": (0, 5e-3)}, "a"),
])  # fmt: skip
def test_the_simplest_mistake_that_explains_an_error_is_named(monkeypatch, left, named):
    found = [cases.Explanation(name, made_case(error), numbers) for name, (numbers, error) in left.items()]
    monkeypatch.setattr(mistakes, "_every", lambda case: found if case.error == 1.0 else [])
    monkeypatch.setattr(mistakes, "integration_errors", lambda case: "")
    said = mistakes.suspicions(made_case(1.0), 1e-5)
    assert [sentence.split(":")[0] for sentence in said] == ([] if named is None else [named])


def test_a_single_part_of_a_large_scene_is_tried_alone(monkeypatch):
    monkeypatch.setitem(_factors.__globals__, "MOST", 0)
    said = [hypothesis.say(np.array([2.0])) for hypothesis in _factors(scenes.make("bouncing_ball"))]
    assert any("'ball'" in sentence for sentence in said)
    assert not any("of every" in sentence for sentence in said)


def test_the_rows_of_a_consensus_are_those_of_the_requested_times(monkeypatch):
    times = np.array([0.4, 1.1, 2.0])
    asked: list[np.ndarray] = []

    def consensus(runs: Any, scene: Any, why: str) -> Truth:
        asked.append(runs.times)
        place = np.tile(runs.times[:, None, None], (1, 2, 2))
        return Truth(place, place[..., 0], 1e-9, "agreed", "")

    @dataclass
    class Known:
        times: Any = None

        def truth(self, scene, times):
            return NoTruth("none is certified")

    monkeypatch.setattr(library, "working_truth", consensus)
    found = library.truth_at(Known(), SCENE)(times)  # type: ignore[arg-type]
    assert isinstance(found, Truth)
    assert asked[0].tolist() == [0.0, *times]
    assert found.position[:, 0, 0].tolist() == times.tolist()


@pytest.mark.parametrize(("text", "said"), [
    ("", "is empty"), ("1,2\n3,4", "line 1 holds numbers"), ("t,a,a\n0,1,2", "line 1, column 'a' stands 2 times"),
    ("t,a\n0\n", "line 2 has 1 cells; expected: 2"), ("t,a\n0,x\n", "line 2, column 'a': 'x' is no number"),
    ("t,a\n0,nan\n", "line 2, column 'a': nan is not finite"), ("t,a\n1,1\n0,1\n", "times must increase"),
    ("t,a\n", "no row"),
])  # fmt: skip
def test_every_complaint_about_a_file_begins_with_its_name(tmp_path, text, said):
    file = tmp_path / "poses.csv"
    file.write_text(text)
    with pytest.raises(FileError) as complaint:
        read_columns(file)
    words = str(complaint.value)
    assert words.removeprefix(str(file)).removeprefix(file.name).startswith(":")
    assert said in words


def test_of_three_rows_the_one_that_bends_remains():
    rows = {"t": np.arange(3.0), "x": np.array([0.0, 5.0, 0.0])}
    assert _marked(columns_of(rows), "t", None).tolist() == [False, True, True]


def test_a_file_that_cannot_be_read_is_named_with_the_reason(tmp_path):
    (tmp_path / "folder.csv").mkdir()
    for name, said in (("poses.xyz", "suffix '.xyz' is unknown; allowed: "), ("gone.csv", "there is no such file"),
                       ("folder.csv", "not a file")):  # fmt: skip
        with pytest.raises(FileError) as complaint:
            read_columns(tmp_path / name)
        assert str(complaint.value).startswith(f"{tmp_path / name}: {said}")
