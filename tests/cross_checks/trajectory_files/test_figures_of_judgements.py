"""Figures of judgements, recomputed from random irregular motions; motions that a tool states in a world of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files import library
from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.columns import _marked
from cross_checks.trajectory_files.formats import Columns
from cross_checks.trajectory_files.judgement import as_truth, judgement
from cross_checks.trajectory_files.library import judged
from cross_checks.trajectory_files.mistakes.terms import _moved
from cross_checks.trajectory_files.motion import DescribedMotion, Read, described_motion
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, SpatialBody
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

SCENE = scenes.make("double_pendulum", length_1=0.7, length_2=2.9)
OFFSETS = {"position": (2,), "orientation": (), "velocity": (2,), "angular_velocity": ()}


def irregular(seed: int, n: int = 9) -> tuple[Trajectory, Truth, dict[str, np.ndarray]]:
    """Return a motion, its truth, and how far each component is off (n, 2), the most at no end of the motion."""
    rng = np.random.default_rng(seed)
    times = np.sort(np.append(rng.uniform(0.01, 0.9, n - 1), 0.0)) * SCENE.duration
    true = {name: rng.normal(size=(n, 2, *shape)) for name, shape in OFFSETS.items()}
    gaps = {name: 10 ** rng.uniform(-5, -2) * rng.uniform(0.1, 1.0, (n, 2)) for name in OFFSETS}
    path = {}
    for name, gap in gaps.items():
        gap[[0, -1]] *= 0.1
        way = rng.normal(size=true[name].shape)
        way /= np.linalg.norm(way, axis=-1, keepdims=True) if way.ndim == 3 else np.abs(way)
        path[name] = true[name] + way * (gap[..., None] if way.ndim == 3 else gap)
    rates = {name: true[name] for name in ("velocity", "angular_velocity")}
    known = {"uncertainty": 1e-12, "kind": "exact", "how": "made up", "rate_uncertainty": np.full(n, 1e-12)}
    return Trajectory(times, **path), Truth(true["position"], true["orientation"], **known, **rates), gaps  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(3))
def test_every_part_of_a_judgement(seed):
    path, truth, gaps = irregular(seed)
    scales = scales_of(SCENE)
    units = (scales.length, 1.0, scales.length / scales.time, 1.0 / scales.time)
    found = judgement(SCENE, DescribedMotion(path, ()), truth, 1e-9)
    parts = {(part.body, part.component): part for part in found.parts}
    shares = []
    for (name, gap), unit in zip(gaps.items(), units, strict=True):
        for k, body in enumerate(SCENE.body_names):
            part, row = parts[body, name.replace("_", " ")], int(np.argmax(gap[:, k]))
            assert part.largest == pytest.approx(gap[row, k], rel=1e-6)
            assert part.relative == pytest.approx(gap[row, k] / unit, rel=1e-6)
            assert part.at == path.times[row]
            assert part.final == pytest.approx(gap[-1, k], rel=1e-6)
        shares.append(gap.max() / unit)
        assert found.curves[name.replace("_", " ")] == pytest.approx((gap.max(axis=1) / unit).tolist(), rel=1e-6)
    assert found.error
    assert found.error.value == pytest.approx(max(shares), rel=1e-6)
    final = max(gap[-1].max() / unit for gap, unit in zip(gaps.values(), units, strict=True))
    for limit, verdict in ((1.01 * max(shares), "agrees"), (0.99 * max(shares), "departs"), (1.01 * final, "departs")):
        assert judgement(SCENE, DescribedMotion(path, ()), truth, limit).verdict == verdict


def test_two_files_are_compared_at_the_times_of_both():
    path, _, _ = irregular(4)
    other = path.at(np.array([0, 2, 3, 7]))
    first, truth = as_truth(SCENE, DescribedMotion(path, ()), DescribedMotion(other, ("no spin",)), "b.csv")
    np.testing.assert_array_equal(first.path.times, other.times)
    np.testing.assert_array_equal(truth.position, other.position)
    assert first.missing == ("no spin (b.csv)",)


def test_mistakes_are_sought_at_the_worst_rows(monkeypatch):
    path, truth, gaps = irregular(5, 2500)
    monkeypatch.setattr(library, "suspicions", lambda case, error: [f"{time:.17g}" for time in case.path.times])
    read = Read(Columns(Path("a.csv"), {"t": path.times}), None, DescribedMotion(path, ()))  # type: ignore[arg-type]
    times = {float(text) for text in judged(SCENE, read, lambda times: truth, 1e-9).suspicions}
    assert times >= {float(path.times[row]) for gap in gaps.values() for row in np.argmax(gap, axis=0).tolist()}
    assert len(times) < 1010


def test_velocities_seen_in_a_turning_world_are_the_slopes_of_its_places():
    scene = scenes.make("torque_free_top")
    body, h = scene.body_names[0], 1e-5
    times = np.array([0.3 - h, 0.3, 0.3 + h]) * scene.duration
    rng = np.random.default_rng(1)
    speed, start = rng.normal(size=3), rng.normal(size=3)
    columns = {"t": times} | {f"p{k}": start[k] + speed[k] * times for k in range(3)}
    columns |= {f"v{k}": np.full(3, speed[k]) for k in range(3)}
    stated = ColumnMap.model_validate({
        "time": {"column": "t", "unit": "s"},
        "world": {"axes": ["y", "z", "x"], "origin": [5.0, -7.0, 3.0], "spin": [0.3, -0.7, 0.2]},
        "bodies": {body: {"position": {"columns": ["p0", "p1", "p2"], "unit": "m"},
                          "velocity": {"columns": ["v0", "v1", "v2"], "unit": "m/s"}}},
    })  # fmt: skip
    found = described_motion(scene, Columns(Path("a.csv"), columns), stated).path
    slope = (found.position[2] - found.position[0]) / (times[2] - times[0])
    np.testing.assert_allclose(found.velocity[1], slope, rtol=1e-6, atol=1e-6)


def test_an_inertia_about_another_point_is_that_of_the_bodys_masses():
    """A turned body of four point masses: in its own axes its inertias about centre and point are their sums."""
    rng = np.random.default_rng(2)
    places, point = rng.normal(size=(4, 3)), rng.normal(size=3)
    places -= places.mean(axis=0)

    def inertia(about: np.ndarray) -> np.ndarray:
        return np.sum([0.75 * (r @ r * np.eye(3) - np.outer(r, r)) for r in places - about], axis=0)

    six = [inertia(np.zeros(3))[pair] for pair in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    turn = Rotation.from_rotvec(rng.normal(size=3))
    ways = {"position": (1.0, 2.0, 3.0), "orientation": tuple(turn.as_quat(scalar_first=True).tolist())}
    body = SpatialBody(name="a", mass=3.0, inertia=tuple(six), **ways)
    moved = _moved(body, turn.apply(point) + np.array(body.position))
    about = inertia(point)
    assert moved == pytest.approx([*np.diag(about), about[0, 1], about[0, 2], about[1, 2]])
    places[:, 2] = point[2] = 0.0
    flat = PlanarBody(name="a", mass=3.0, inertia=float(inertia(np.zeros(3))[2, 2]), position=(1.0, 2.0))
    assert _moved(flat, point[:2] + np.array(flat.position)) == pytest.approx(inertia(point)[2, 2])


def test_rows_just_before_and_after_a_wanted_time_remain():
    times = np.array([0.0, 0.996, 1.004, 1.02, 1.97, 2.003, 3.0])
    marked = _marked(Columns(Path("a.csv"), {"t": times}), "t", (np.array([1.0, 2.0]), 0.005))
    assert times[marked].tolist() == [0.996, 1.004, 2.003]
