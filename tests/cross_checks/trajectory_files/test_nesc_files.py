"""Files in the manner of NASA/TM-2015-218675, check cases 1 and 2, made of truths, with and without known faults.

The published files are not here: they are NASA's. The maps are those of docs/judge-a-file.md.
"""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.formats import Columns, FileError
from cross_checks.trajectory_files.mistakes import suspicions
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.motion import described_motion
from cross_checks.truths import seek_truth, truth_for
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene

ASKED = 1e-7
FOOT, SPIN = 0.3048, 7.292115e-5  # m, rad/s
TIMES = np.linspace(0.0, 30.0, 61)
SPHERE, BRICK = scenes.make("nesc_dropped_sphere"), scenes.make("nesc_tumbling_brick")
DOCS = Path(__file__).parents[3] / "docs" / "judge-a-file.md"


def maps() -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the two maps of the documentation, of the sphere and of the brick."""
    blocks = re.findall(r"(?:^    .*\n)+", DOCS.read_text(), re.MULTILINE)
    read = [tomllib.loads(block) for block in blocks if '"time"' in block]
    return read[0], read[1]


@cache
def truth_at(scene_name: str, times: tuple[float, ...]) -> Truth:
    found = truth_for({"nesc_dropped_sphere": SPHERE, "nesc_tumbling_brick": BRICK}[scene_name], np.array(times))
    assert found is not None
    return found


def true(scene: Scene, times: np.ndarray = TIMES) -> Truth:
    return truth_at(scene.name, tuple(times.tolist()))


def case_of(scene: Scene, columns: dict[str, np.ndarray], stated: dict[str, Any]) -> Case:
    table, read = Columns(Path("sim.csv"), columns), ColumnMap.model_validate(stated)
    path = described_motion(scene, table, read).path

    def again(times: np.ndarray) -> Truth | NoTruth:
        return seek_truth(scene, times)

    return Case(scene, table, read, path, true(scene, path.times))


def fallen(spin: float = SPIN) -> dict[str, np.ndarray]:
    """Return a simulator's file of the falling sphere: Earth-fixed feet."""
    place = Rotation.from_rotvec(np.outer(TIMES, (0.0, 0.0, -spin))).apply(true(SPHERE).position[:, 1]) / FOOT
    return {"time": TIMES} | {f"gePosition_ft_{axis}": place[:, k] for k, axis in enumerate("XYZ")}


def tumbled(
    spin: float = SPIN, longitude: float = 2e-4, frame: Rotation | None = None, times: np.ndarray = TIMES
) -> dict[str, np.ndarray]:
    """Return a simulator's file of the brick over a longitude (deg) that it reaches at the end.

    Angles are against local north, east and down, rates are the body's.
    """
    truth = true(BRICK, times)
    east = longitude * (times / 30.0) ** 3
    turn = Rotation.from_rotvec(np.outer(times * spin + np.radians(east), (0.0, 0.0, 1.0)))
    level = Rotation.from_matrix([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # columns: north, east, down
    body = Rotation.from_quat(truth.orientation[:, 0], scalar_first=True)
    assert truth.angular_velocity is not None
    rates = np.degrees(body.inv().apply(truth.angular_velocity[:, 0]))
    told = (turn * level).inv() * (body if frame is None else body * frame)
    angles = told.as_euler("ZYX", degrees=True)
    names = ("Yaw", "Pitch", "Roll")
    columns = {f"eulerAngle_deg_{name}": angles[:, k] for k, name in enumerate(names)}
    columns |= {f"bodyAngularRateWrtEi_deg_s_{name}": rates[:, k] for k, name in enumerate(reversed(names))}
    quaternion = told.as_quat(scalar_first=True)
    columns |= {f"quaternion_{k}": quaternion[:, k] for k in range(4)}
    return {"time": times, "longitude_deg": east} | columns


def without_rates(stated: dict[str, Any]) -> dict[str, Any]:
    return stated | {"bodies": {"brick": {"orientation": stated["bodies"]["brick"]["orientation"]}}}


def size_in(sentence: str, pattern: str) -> float:
    found = re.search(pattern, sentence)
    assert found, sentence
    return float(found[1])


def test_the_sphere_falls_as_a_body_does_near_the_ground():
    """Over 30 s: g t^2 / 2, and the eastward drift w g t^3 / 3 (Goldstein, sec. 4-10)."""
    place = Rotation.from_rotvec(np.outer(TIMES, (0.0, 0.0, -SPIN))).apply(true(SPHERE).position[:, 1])
    pull = 32.1065364063 * FOOT - SPIN**2 * place[0, 0]  # m/s^2: the published gravitation, less the centrifugal share
    assert place[0, 0] - place[-1, 0] == pytest.approx(0.5 * pull * 900.0, rel=1e-3)
    assert place[-1, 1] == pytest.approx(SPIN * pull * 27000.0 / 3.0, rel=1e-3)


def test_right_files_of_both_cases_agree():
    sphere, brick = maps()
    assert case_of(SPHERE, fallen(), sphere).error < 1e-9
    assert case_of(BRICK, tumbled(), brick).error < 1e-9


def test_five_simulators_are_ranked_by_how_far_they_are_off():
    """As NASA's five are: from roundoff to degrees, each a steady turn more."""
    _, brick = maps()
    degrees = (3.5e-9, 5.2e-9, 1.2e-4, 1e-2, 3.7)
    found = []
    for off in degrees:
        frame = Rotation.from_euler("z", off, degrees=True)
        found.append(case_of(BRICK, tumbled(frame=frame), without_rates(brick)).error)
    assert found == sorted(found)
    assert np.degrees(found[2:]) == pytest.approx(degrees[2:], rel=1e-6)
    assert np.degrees(found[:2]) == pytest.approx(degrees[:2], abs=2e-9)  # truth and angles are known to 1e-9 deg


@pytest.mark.parametrize("off", [0.01, 3.7])
def test_turned_body_axes_are_named_with_their_angle(off):
    _, brick = maps()
    frame = Rotation.from_euler("x", off, degrees=True)
    sentence = suspicions(case_of(BRICK, tumbled(frame=frame), without_rates(brick)), ASKED)[0]
    assert size_in(sentence, r"brick by ([\d.e-]+) deg") == pytest.approx(off, rel=0.1)


def test_axes_that_turn_with_the_earth_are_named_with_their_rate():
    for scene, columns, stated in ((SPHERE, fallen(), maps()[0]), (BRICK, tumbled(), without_rates(maps()[1]))):
        still = stated | {"world": {name: x for name, x in stated["world"].items() if name != "spin"}}
        sentence = suspicions(case_of(scene, columns, still), ASKED)[0]
        assert size_in(sentence, r"world turns by ([\d.e-]+) deg/s about \(0, 0, 1\)") == pytest.approx(
            np.degrees(SPIN), rel=0.1
        )


@pytest.mark.parametrize("lag", [1e-3, pytest.param(0.02, marks=pytest.mark.slow)])
def test_a_lag_is_named_with_its_size(lag):
    _, brick = maps()
    columns = tumbled(times=TIMES[4:-4] - lag) | {"time": TIMES[4:-4]}
    still = without_rates(brick) | {"world": {"axes": brick["world"]["axes"]}}
    columns |= {k: v for k, v in tumbled(0.0, 0.0, times=TIMES[4:-4] - lag).items() if k != "time"}
    sentence = suspicions(case_of(BRICK, columns, still), ASKED)[0]
    assert size_in(sentence, r"late by ([\d.e-]+) s") == pytest.approx(lag, rel=0.1)


def test_degrees_and_a_swapped_quaternion_are_named():
    _, brick = maps()
    angles = brick["bodies"]["brick"]["orientation"] | {"unit": "rad"}
    sentence = suspicions(case_of(BRICK, tumbled(), brick | {"bodies": {"brick": {"orientation": angles}}}), ASKED)[0]
    assert "look like deg; rad is stated" in sentence
    swapped = {"columns": [f"quaternion_{k}" for k in (1, 2, 3, 0)], "convention": "quaternion wxyz",
               "maps": "body to world"}  # fmt: skip
    sentence = suspicions(case_of(BRICK, tumbled(), brick | {"bodies": {"brick": {"orientation": swapped}}}), ASKED)[0]
    assert "look like quaternion xyzw; quaternion wxyz is stated" in sentence


def test_gravity_of_a_round_earth_is_named():
    round_earth = truth_for(scenes.make("nesc_dropped_sphere", j2=0.0), TIMES)
    assert round_earth is not None
    place = Rotation.from_rotvec(np.outer(TIMES, (0.0, 0.0, -SPIN))).apply(round_earth.position[:, 1]) / FOOT
    columns = {"time": TIMES} | {f"gePosition_ft_{axis}": place[:, k] for k, axis in enumerate("XYZ")}
    assert "without the load 'earth_j2'" in suspicions(case_of(SPHERE, columns, maps()[0]), ASKED)[0]


def test_velocities_in_turning_axes_are_read_with_the_positions_that_carry_them():
    sphere, _ = maps()
    truth = true(SPHERE)
    assert truth.velocity is not None
    turn = Rotation.from_rotvec(np.outer(TIMES, (0.0, 0.0, -SPIN)))
    seen = turn.apply(truth.velocity[:, 1] - np.cross((0.0, 0.0, SPIN), truth.position[:, 1]))
    columns = fallen() | {f"v{axis}": seen[:, k] for k, axis in enumerate("xyz")}
    velocity = {"columns": ["vx", "vy", "vz"], "unit": "m/s"}
    body = sphere["bodies"]["sphere"] | {"velocity": velocity}
    assert case_of(SPHERE, columns, sphere | {"bodies": {"sphere": body}}).error < 1e-9
    with pytest.raises(FileError, match="needs the position"):
        case_of(SPHERE, columns, sphere | {"bodies": {"sphere": {"velocity": velocity}}})
