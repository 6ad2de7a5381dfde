"""Each hypothesis on a file's mistake undoes just that mistake of a random motion, and its sentence states the size."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files.column_map import ColumnMap, blank_map, read_map
from cross_checks.trajectory_files.columns import columns_of
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.mistakes import integration_errors
from cross_checks.trajectory_files.mistakes.case import Case, Hypothesis
from cross_checks.trajectory_files.mistakes.frames import clocks, conventions, frames, signs
from cross_checks.trajectory_files.mistakes.terms import terms
from cross_checks.trajectory_files.motion import described_motion
from cross_checks.truths.truth import Truth
from mbs_ref import Settings, scenes
from mbs_ref.cores.system import Poses
from mbs_ref.observables.distance import turn_between, units_of
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

PLANE = scenes.make("double_pendulum", length_1=0.7, length_2=2.9)
SPACE = scenes.make("spatial_chain", links=2)
PARTS = ("position", "orientation", "velocity", "angular_velocity")


def motion(scene: Scene, seed: int, n: int = 6) -> Trajectory:
    """Return a motion of no law."""
    rng, bodies = np.random.default_rng(seed), len(scene.bodies)
    times = np.sort(rng.uniform(0.0, scene.duration, n))
    place, speed = rng.normal(size=(2, n, bodies, scene.dimension))
    if scene.dimension == 2:
        return Trajectory(times, place, rng.normal(size=(n, bodies)), speed, rng.normal(size=(n, bodies)))
    turn = rng.normal(size=(n, bodies, 4))
    turn /= np.linalg.norm(turn, axis=2, keepdims=True)
    return Trajectory(times, place, turn, speed, rng.normal(size=(n, bodies, 3)))


def case_of(scene: Scene, path: Trajectory, true: Trajectory | None = None) -> Case:
    """Return a case whose file holds a path, and whose truth is another."""
    true = true or path
    truth = Truth(true.position, true.orientation, 0.0, "exact", "", velocity=true.velocity,
                  angular_velocity=true.angular_velocity, rate_uncertainty=np.zeros(len(path.times)))  # fmt: skip
    return Case(scene, None, None, path, truth)  # type: ignore[arg-type]


def turned(path: Trajectory, turn: Rotation, about: np.ndarray | None = None) -> Trajectory:
    """Return a motion whose places, turns and rates are seen in axes that are turned back by `turn` (of each time)."""
    d, n = path.position.shape[2], len(path.times)
    matrices = np.broadcast_to(turn.as_matrix(), (n, 3, 3))[:, :d, :d]
    place, speed = (np.einsum("tij,tbj->tbi", matrices, part) for part in (path.position, path.velocity))
    if d == 2:
        return replace(path, position=place, velocity=speed, orientation=path.orientation + turn.as_rotvec()[2])
    spin = np.einsum("tij,tbj->tbi", matrices, path.angular_velocity)
    return replace(
        path, position=place, velocity=speed, angular_velocity=spin, orientation=after(turn, path.orientation)
    )


def after(turn: Rotation, orientation: np.ndarray) -> np.ndarray:
    """Return Euler parameters (n, bodies, 4) that a further turn, one or one of each time, follows."""
    return np.stack([(turn * Rotation.from_quat(own, scalar_first=True)).as_quat(scalar_first=True)
                     for own in orientation.swapaxes(0, 1)], axis=1)  # fmt: skip


def alike(one: Trajectory, other: Trajectory) -> None:
    """Assert that two motions are one; Euler parameters have two signs."""
    for name in ("position", "velocity", "angular_velocity"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=1e-9), name
    apart = turn_between(one.orientation, other.orientation, one.position.shape[2] == 3)
    assert np.abs(apart).max() < 1e-7


def vectors(sentence: str) -> list[list[float]]:
    """Return the vectors in a sentence."""
    return [[float(x) for x in text.split(", ")] for text in re.findall(r"\(([-\d.e+, ]+)\)", sentence)]


def found(case: Case, start: str) -> list[Hypothesis]:
    """Return the hypotheses on frames whose sentence begins so, for some numbers."""
    return [one for one in frames(case) if one.say(np.full(len(one.starts[0]), 0.3)).startswith(start)]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("scene", [PLANE, SPACE], ids=["plane", "space"])
def test_a_turned_and_shifted_world(scene, seed):
    rng, true = np.random.default_rng(seed), motion(scene, seed)
    d = scene.dimension
    vector, shift = rng.normal(size=3) * ((0.0, 0.0, 1.0) if d == 2 else 1.0), rng.normal(size=d)
    written = turned(replace(true, position=true.position + shift), Rotation.from_rotvec(vector))
    x = np.concatenate((vector[2:] if d == 2 else vector, shift))
    (world,) = found(case_of(scene, written), "the file's world is turned")
    alike(world.change(case_of(scene, written), x).path, true)  # type: ignore[union-attr]
    sentence = world.say(x)
    size = np.linalg.norm(Rotation.from_rotvec(vector).as_rotvec())
    assert float(re.search(r"turned by ([\d.]+) deg", sentence)[1]) == pytest.approx(math.degrees(size), rel=1e-3)  # type: ignore[index]
    axis, moved = vectors(sentence)
    assert axis == pytest.approx(-vector / np.linalg.norm(vector), abs=2e-3)
    assert moved == pytest.approx(shift, rel=1e-3, abs=2e-3)
    only = world.say(np.concatenate((np.zeros(len(x) - d), shift)))
    assert (" turned " in only, " shifted " in only) == (False, True)
    assert not world.is_none(x)
    assert world.is_none(0.0 * x)


@pytest.mark.parametrize("seed", range(3))
def test_a_world_that_turns_steadily(seed):
    rng, true = np.random.default_rng(seed), motion(SPACE, seed)
    spin = rng.normal(size=3)
    back = Rotation.from_rotvec(-true.times[:, None] * spin)
    carried = replace(true, velocity=true.velocity - np.cross(spin, true.position))
    written = turned(carried, back)
    (world,) = found(case_of(SPACE, written), "the file's world turns")
    alike(world.change(case_of(SPACE, written), spin).path, true)  # type: ignore[union-attr]
    speed = float(np.linalg.norm(spin))
    assert float(re.search(r"by ([\d.]+) deg/s", world.say(spin))[1]) == pytest.approx(math.degrees(speed), rel=1e-3)  # type: ignore[index]
    assert vectors(world.say(spin))[0] == pytest.approx(spin / speed, abs=2e-3)


@pytest.mark.parametrize("scene", [PLANE, SPACE], ids=["plane", "space"])
def test_other_axes_of_each_body(scene):
    rng, true = np.random.default_rng(1), motion(scene, 1)
    x = rng.uniform(0.3, 1.0, len(scene.bodies) * (1 if scene.dimension == 2 else 3))
    if scene.dimension == 2:
        written = replace(true, orientation=true.orientation + x)
    else:
        turns = [Rotation.from_rotvec(x[3 * k : 3 * k + 3]) for k in range(2)]
        own = [Rotation.from_quat(true.orientation[:, k], scalar_first=True) * turns[k] for k in range(2)]
        written = replace(true, orientation=np.stack([one.as_quat(scalar_first=True) for one in own], axis=1))
    (axes,) = found(case_of(scene, written), "body axes are turned")
    alike(axes.change(case_of(scene, written), x).path, true)  # type: ignore[union-attr]
    sizes = [np.degrees(np.linalg.norm(row)) for row in x.reshape(len(scene.bodies), -1)]
    said = re.findall(r"(\w+) by ([\d.]+) deg", axes.say(x))
    assert [name for name, _ in said] == list(scene.body_names)
    assert [float(size) for _, size in said] == pytest.approx(sizes, rel=1e-3)
    first = x * (np.arange(len(x)) < len(x) // 2)
    assert len(re.findall(" by ", axes.say(first))) == 1


@pytest.mark.parametrize("rates", [True, False])
@pytest.mark.parametrize("scene", [PLANE, SPACE], ids=["plane", "space"])
def test_positions_of_another_point(scene, rates):
    rng, true = np.random.default_rng(2), motion(scene, 2)
    d, n = scene.dimension, len(scene.bodies)
    arms, away = rng.normal(size=(n, d)), np.zeros_like(true.position)
    for k in range(n):
        vector = [Rotation.from_rotvec([0.0, 0.0, turn]) for turn in true.orientation[:, k]] if d == 2 else [
            Rotation.from_quat(turn, scalar_first=True) for turn in true.orientation[:, k]]  # fmt: skip
        away[:, k] = [turn.apply(np.pad(arms[k], (0, 3 - d)))[:d] for turn in vector]
    spin = true.angular_velocity if d == 3 else true.angular_velocity[..., None] * (0.0, 0.0, 1.0)
    carried = np.cross(spin, np.pad(away, ((0, 0), (0, 0), (0, 3 - d))))[..., :d]
    written = replace(true, position=true.position + away, velocity=true.velocity + carried * rates)
    both = found(case_of(scene, written, true), "positions are not of the centre of mass")
    undone = [one.change(case_of(scene, written, true), arms.ravel()).path for one in both]  # type: ignore[union-attr]
    alike(undone[0 if rates else 1], true)
    assert np.abs(undone[1 if rates else 0].velocity - true.velocity).max() > 0.1
    assert vectors(both[0].say(arms.ravel())) == [pytest.approx(arm, rel=1e-3, abs=2e-3) for arm in arms]


def unmirrored(path: Trajectory, axis: int) -> Trajectory:
    """Return a motion seen in a mirror across an axis, by its matrices."""
    d = path.position.shape[2]
    mirror = np.ones(d)
    mirror[axis] = -1.0
    seen = replace(path, position=path.position * mirror, velocity=path.velocity * mirror)
    if d == 2:
        return replace(seen, orientation=-path.orientation, angular_velocity=-path.angular_velocity)
    matrices = Rotation.from_quat(path.orientation.reshape(-1, 4), scalar_first=True).as_matrix() * np.outer(
        mirror, mirror
    )
    turns = Rotation.from_matrix(matrices).as_quat(scalar_first=True).reshape(path.orientation.shape)
    return replace(seen, orientation=turns, angular_velocity=-path.angular_velocity * mirror)


@pytest.mark.parametrize("scene", [PLANE, SPACE], ids=["plane", "space"])
def test_mirrors_and_signs(scene):
    """A mirrored world is undone in all parts; other signs change the parts that are named, and those alone."""
    true = motion(scene, 3)
    said = set()
    for one in signs(case_of(scene, true)):
        sentence = one.say(np.zeros(0))
        said.add(sentence)
        changed = one.change(case_of(scene, true), np.zeros(0)).path  # type: ignore[union-attr]
        different = {name for name in PARTS if not np.array_equal(getattr(changed, name), getattr(true, name))}
        axis = "xyz".index(sentence[-1]) if " along " in sentence else 0
        if sentence.startswith("the file's world"):
            alike(changed, unmirrored(true, axis))
        elif sentence.startswith("positions and velocities"):
            assert different == {"position", "velocity"}
            assert changed.position[..., axis] == pytest.approx(-true.position[..., axis])
        elif sentence.startswith("orientation and"):
            assert different == {"orientation", "angular_velocity"}
            assert changed.orientation == pytest.approx(-true.orientation)
        else:
            (name,) = different
            assert sentence == f"the {name.replace('_', ' ')} has the other sign along {'xyz'[axis]}"
            old, new = getattr(true, name), getattr(changed, name)
            if old.ndim == 2:
                assert np.array_equal(new, -old)
            else:
                column = axis + (name == "orientation")  # the first Euler parameter has no axis
                signs_of = np.where(np.arange(old.shape[2]) == column, -1.0, 1.0)
                assert np.array_equal(new, old * signs_of)
    assert len(said) == 6 * scene.dimension + (scene.dimension == 2)


def test_clocks_that_lag():
    """Numbers are seconds by which samples, or rates besides, are late; half of the motion is too much."""
    asked: list[dict[str, float]] = []
    case: Any = SimpleNamespace(scene=PLANE, late=0.25, rates_late=0.5, rerun=lambda **given: asked.append(given))
    samples, rates = clocks(case)
    for one in (samples, rates):
        one.change(case, np.array([-0.125]))
    assert asked == [{"late": 0.125}, {"rates_late": 0.375}]
    assert samples.say(np.array([0.5])) == "samples are late by 0.5 s"
    assert rates.say(np.array([-0.25])).endswith("are early by 0.25 s")
    half = 0.5 * PLANE.duration
    assert [samples.is_none(np.array([x])) for x in (0.0, 1e-12, 0.01, 0.99 * half, -1.01 * half)] == [
        True, True, False, False, True]  # fmt: skip


def columns_and_map(scene: Scene, path: Trajectory) -> tuple[Any, ColumnMap]:
    """Return the columns of a motion in metres and degrees, and their map."""
    arrays, bodies = {"t": path.times}, {}
    for k, name in enumerate(scene.body_names):
        own = [np.atleast_3d(getattr(path, part))[:, k] for part in PARTS]
        for part, values in zip(PARTS, own, strict=True):
            arrays[f"{name} {part}"] = values.reshape(len(path.times), -1)
        of = {part: [f"{name} {part}[{c}]" for c in range(arrays[f"{name} {part}"].shape[1])] for part in PARTS}
        turn = {"convention": "angle", "unit": "rad"} if scene.dimension == 2 else {
            "convention": "quaternion wxyz", "maps": "body to world"}  # fmt: skip
        rate = {"unit": "rad/s"} | ({} if scene.dimension == 2 else {"axes": "world"})
        units: dict[str, dict[str, str]] = {
            "position": {"unit": "m"},
            "orientation": turn,
            "velocity": {"unit": "m/s"},
            "angular_velocity": rate,
        }
        bodies[name] = {part: {"columns": of[part], **units[part]} for part in PARTS}
    stated = ColumnMap.model_validate({"time": {"column": "t", "unit": "s"}, "bodies": bodies})
    return columns_of(arrays), stated


@pytest.mark.parametrize("scene", [PLANE, SPACE], ids=["plane", "space"])
def test_other_readings_of_the_columns(scene):
    """Each other reading changes one statement of one part, of all bodies, and states both words."""
    path = motion(scene, 4)
    columns, stated = columns_and_map(scene, path)
    case = Case(scene, columns, stated, path, case_of(scene, path).truth)
    lengths, angles, times = 7, 3, 6
    counts = dict.fromkeys(PARTS, 0)
    for one in conventions(case):
        sentence = one.say(np.zeros(0))
        part, other, given = re.fullmatch(r"the (.+) columns look like (.+); (.+) is stated", sentence).groups()  # type: ignore[union-attr]
        assert "_" not in part
        name = part.replace(" ", "_")
        counts[name] += 1
        changed = one.change(case, np.zeros(0))
        assert changed
        for body, old in stated.bodies.items():
            new = changed.stated.bodies[body]
            plain_old, plain_new = old.model_dump(), new.model_dump()
            fields = {key for key in plain_old[name] if plain_old[name][key] != plain_new[name][key]}
            assert {key for key in PARTS if plain_old[key] != plain_new[key]} == {name}
            (field,) = fields
            assert (plain_old[name][field], plain_new[name][field]) == (given, other)
        again = described_motion(scene, columns, changed.stated).path
        assert np.array_equal(again.position, changed.path.position)
        assert np.array_equal(again.orientation, changed.path.orientation)
    turned_words = {2: angles - 1, 3: 2}[scene.dimension]  # another unit, or quaternion and direction
    axes = 0 if scene.dimension == 2 else 1
    assert counts == {"position": lengths - 1, "orientation": turned_words, "velocity": lengths * times - 1,
                      "angular_velocity": angles * times - 1 + axes}  # fmt: skip


def changes(one: Any, other: Any, place: str = "") -> dict[str, tuple[Any, Any]]:
    """Return where two plain values differ, and both values there."""
    if isinstance(one, dict) and isinstance(other, dict):
        return {key: pair for name in one.keys() | other.keys()
                for key, pair in changes(one.get(name), other.get(name), f"{place}.{name}").items()}  # fmt: skip
    if isinstance(one, list | tuple) and isinstance(other, list | tuple) and len(one) == len(other):
        return {key: pair for k, pair in enumerate(zip(one, other, strict=True))
                for key, pair in changes(*pair, f"{place}.{k}").items()}  # fmt: skip
    return {} if one == other else {place: (one, other)}


@pytest.mark.parametrize("name", ["spring_pendulum", "double_pendulum", "heavy_top", "slider_crank", "sliding_block"])
def test_terms_change_what_they_say_and_nothing_else(name):
    scene = scenes.make(name)
    asked: list[Scene] = []
    case: Any = SimpleNamespace(scene=scene, assumed=None, work=1.0, rerun=lambda assumed: asked.append(assumed))
    before, factor = scene.model_dump(), 1.75
    said = []
    for one in terms(case):
        x = np.full(len(one.starts[0]), factor)
        one.change(case, x)
        sentence, moved = one.say(x), changes(before, asked[-1].model_dump())
        said.append(sentence)
        places = {place.split(".")[1] for place in moved}
        if sentence.startswith("the file moves as the scene does without the load"):
            (left,) = (load.name for load in scene.loads if repr(load.name) in sentence)
            assert [load.name for load in asked[-1].loads] == [load.name for load in scene.loads if load.name != left]
        elif "gravity" in sentence.split("times")[0]:
            assert places == {"gravity"}
            pull = np.array(asked[-1].gravity)
            size = np.linalg.norm(scene.gravity)
            if "without" in sentence:
                assert not pull.any()
            elif "along" in sentence:
                assert pull == pytest.approx(size * np.array(vectors(sentence)[0]))
            else:
                assert pull == pytest.approx(factor * np.array(scene.gravity))
        elif "inertia of" in sentence and "is about the point" in sentence:
            body, of = re.match(r"the inertia of (.+) is about the point of '(.+)' instead", sentence).groups()  # type: ignore[union-attr]
            (part,) = (part for part in (*scene.joints, *scene.loads) if part.name == of)
            marks = [part.mark(end) for end in ("body", "body_a", "body_b") if getattr(part, end, None) == body]
            (centre,) = (one.position for one in scene.bodies if one.name == body)
            assert {place.split(".")[3] for place in moved} == ({"inertia"} if marks != [centre] else set())
        elif "other sign" in sentence:
            assert all(old == -new for old, new in moved.values())
        else:
            field, whose = re.match(r"the (.+) of (every [\w ]+|'.+'|\".+\") is", sentence).groups()  # type: ignore[union-attr]
            assert all(new == pytest.approx(factor * old) for old, new in moved.values())
            for place in moved:
                _, kind, k, *path = place.split(".")
                part = getattr(scene, kind)[int(k)]
                assert " ".join(word for word in path if not word.isdigit()).replace("_", " ") == field
                assert whose in (repr(part.name), f"every {part.type.replace('_', ' ')}")
            if whose.startswith("every"):
                every = [part for kind in ("bodies", "joints", "loads", "contacts") for part in getattr(scene, kind)
                         if whose == f"every {part.type.replace('_', ' ')}"]  # fmt: skip
                assert 1 < len({tuple(place.split(".")[1:3]) for place in moved}) <= len(every)  # none of 0 moves
            assert one.is_none(np.array([1.00005]))
            assert not one.is_none(np.array([1.0002]))
    assert len(set(said)) == len(said) > 3
    case.work = 1e9
    assert list(terms(case)) == []


def test_departures_from_sample_to_sample():
    """A file of a run has none; samples that are off by unrelated amounts are, by what the sentence states."""
    scene = scenes.make("double_pendulum")
    path = simulate(scene, Settings(rtol=1e-11, samples=15, estimate="off", t_end=1.0, reactions=False))
    noise = 1e-6 * np.random.default_rng(3).normal(size=path.velocity.shape)
    file = replace(path, velocity=path.velocity + noise)
    limits = r"(?:by|at most) (\d\S*?),? (?:of the scene|as)"
    sentences = [integration_errors(case_of(scene, one)) for one in (path, file)]
    (_, exact), (median, largest) = ([float(x) for x in re.findall(limits, sentence)] for sentence in sentences)
    assert exact < 1e-10
    units, sizes = units_of(scales_of(scene)), []
    for k in range(14):
        start = Poses(*(part[k : k + 1] for part in Poses.of(file)))
        again = Settings(rtol=1e-11, estimate="off", reactions=False, project_initial=True)
        end = simulate(scene, again, file.times[k : k + 2] - file.times[k], start)
        sizes.append(max(np.abs(getattr(file, name)[k + 1] - getattr(end, name)[-1]).max() / unit
                         for name, unit in zip(PARTS, units, strict=True)))  # fmt: skip
    assert (median, largest) == pytest.approx((np.median(sizes), max(sizes)), rel=0.06)


def test_a_blank_map_names_every_column_and_statement(tmp_path):
    for scene in (PLANE, SPACE):
        file = tmp_path / f"{scene.dimension}.toml"
        file.write_text(blank_map(["a", "b"], list(scene.body_names), scene.dimension))
        assert "# The file's columns: a, b" in file.read_text()
        stated = read_map(file)
        assert list(stated.bodies) == list(scene.body_names)
        for body in stated.bodies.values():
            assert body.missing == []
            assert len(body.position.columns) == len(body.velocity.columns) == scene.dimension  # type: ignore[union-attr]
            assert len(body.orientation.columns) == {2: 1, 3: 4}[scene.dimension]  # type: ignore[union-attr]
    file.write_text('[time]\ncolumn = "t"\nunit = "week"\n[bodies.a]\nposition = {columns = ["x"]}\n')
    with pytest.raises(FileError, match=r"unit = .week. is no unit of time.*; bodies.a.position.unit: Field required"):
        read_map(file)
