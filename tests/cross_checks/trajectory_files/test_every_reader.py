"""Readers in small parts, thinning and sentences of a judgement, computed again from random tables."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import constants

from cross_checks.records.record import Error
from cross_checks.trajectory_files import columns, formats, library
from cross_checks.trajectory_files.columns import columns_of, read_columns
from cross_checks.trajectory_files.formats import Columns, FileError
from cross_checks.trajectory_files.judgement import MOST, Judgement, Part, _parts, _verdict, truth_rows
from cross_checks.trajectory_files.mistakes.frames import NONE, frames
from cross_checks.trajectory_files.mistakes.terms import _factor
from cross_checks.trajectory_files.motion import _column, read_motion
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import POSES
from tests.cross_checks.trajectory_files.test_figures_of_judgements import SCENE, irregular


def table(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    return {"t": np.cumsum(rng.uniform(0.1, 1.0, n)), "a": rng.normal(size=n), "b": 1e6 * rng.normal(size=n)}


@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".npz"])
@pytest.mark.parametrize("n", [1, 7, 23])
def test_a_file_is_read_whole_in_small_parts(monkeypatch, tmp_path, suffix, n):
    rng = np.random.default_rng(n)
    made, file, shares = table(rng, n), tmp_path / f"a{suffix}", []
    delimiter = {".csv": ";", ".tsv": "\t"}.get(suffix, ",")
    if suffix == ".npz":
        pair = np.column_stack((made["a"], made["b"]))
        np.savez(
            file,
            t=made["t"],
            p=np.asfortranarray(pair),
            q=pair.astype(np.float32),
            k=pair.astype(np.int64),
            word=np.array(["x"] * n),
        )
    else:
        rows = [delimiter.join(made), "# a remark", *(delimiter.join(f" {x!r}" for x in map(float, row))
                                                     for row in zip(*made.values(), strict=True)), ""]  # fmt: skip
        file.write_text("\ufeff" + "\n".join(rows))
    monkeypatch.setattr(formats, "PART", 15)
    found = read_columns(file, delimiter, report=lambda done, total, what: shares.append((done, total, what)))
    if suffix == ".npz":
        single = {"q[0]": made["a"].astype(np.float32), "q[1]": made["b"].astype(np.float32)}
        whole = {"k[0]": made["a"].astype(np.int64), "k[1]": made["b"].astype(np.int64)}
        made = {"t": made["t"], "p[0]": made["a"], "p[1]": made["b"], **single, **whole}
    assert found.values.keys() == made.keys()
    for name, column in made.items():
        assert np.array_equal(found.values[name], column), name
    first = 3 if suffix != ".npz" else 0
    assert found.counted.tolist() == list(range(first, first + n))
    assert (found.total, found.stride, found.word) == (n, 1, "row" if suffix == ".npz" else "line")
    assert found.place(0, "a") == f"{file.name}: {found.word} {first}, column 'a'"
    assert shares[-1] == (n, n, "")
    assert delimiter != "," or list(columns.read_header(file).values) == list(made)  # in the file's order


def test_a_motion_of_our_own_files_has_the_columns_of_its_csv(tmp_path):
    path, _, _ = irregular(1)
    parts = {name: getattr(path, name) for name in POSES}
    np.savez(tmp_path / "a.npz", estimate=np.zeros(3), times=path.times, bodies=np.array(SCENE.body_names), **parts)
    found = read_columns(tmp_path / "a.npz")
    first, second = SCENE.body_names
    assert np.array_equal(found.values["t"], path.times)
    for name, column in ((f"{first}.x", path.position[:, 0, 0]), (f"{second}.y", path.position[:, 1, 1]),
                         (f"{second}.angle", path.orientation[:, 1]), (f"{first}.vy", path.velocity[:, 0, 1]),
                         (f"{second}.rate", path.angular_velocity[:, 1])):  # fmt: skip
        assert np.array_equal(found.values[name], column), name


@pytest.mark.parametrize("size", [1, 2, 5, 30])
@pytest.mark.parametrize("seed", range(3))
def test_thinning_keeps_every_kth_row_and_those_that_bend_most(monkeypatch, seed, size):
    n, most = 30, 7
    made = table(np.random.default_rng(seed), n)
    parts = [Columns(Path("a"), {k: v[i : i + size] for k, v in made.items()}, np.arange(i, min(i + size, n)))
             for i in range(0, n, size)]  # fmt: skip
    monkeypatch.setattr(columns, "MOST_ROWS", most)
    found = columns._kept(Path("a"), parts, "t", None, None)
    stride = 1
    while len(range(0, n, stride)) > most:
        stride *= 2
    kept = set(range(0, n, stride))
    for start in range(0, n, size):
        own = {k: v[start : start + size] for k, v in made.items()}
        count = len(own["t"])
        kept.add(start + count - 1)
        if count > 2:
            bends = {k: [abs(v[i] - 2.0 * v[i + 1] + v[i + 2]) for i in range(count - 2)] for k, v in own.items()}
            over = [max(bends[k][i] / np.mean(bends[k]) for k in own) for i in range(count - 2)]
            kept.add(start + 1 + int(np.argmax(over)))
    assert found.counted.tolist() == sorted(kept)
    assert (found.total, found.stride) == (n, stride)
    for name, column in made.items():
        assert np.array_equal(found.values[name], column[sorted(kept)])


def test_rows_at_wanted_times_alone():
    made = {"t": np.arange(20.0), "a": np.arange(20.0) ** 2}
    found = columns_of(made, only=(np.array([3.0, 7.4, 19.0]), 0.25))
    assert found.values["t"].tolist() == [0.0, 3.0, 19.0]  # the first row stays
    assert found.stride == 1


def test_rows_that_cannot_be_are_named_by_their_place():
    part = Columns(Path("a.csv"), {"t": np.array([2.0, 3.0, 3.0]), "a": np.zeros(3)}, np.array([5, 6, 9]), "line")
    with pytest.raises(FileError, match="line 9, column 't': 3 follows 3; times must increase"):
        columns._checked(part, "t", -np.inf)
    with pytest.raises(FileError, match="line 5, column 't': 2 follows 2"):
        columns._checked(part, "t", 2.0)
    assert columns._checked(part.at(np.array([0, 1])), "t", 1.9) == 3.0
    part.values["a"][1] = np.inf
    with pytest.raises(FileError, match="line 6, column 'a': inf is not finite"):
        columns._checked(part, "t", -np.inf)
    with pytest.raises(FileError, match="columns differ in length"):
        columns_of({"t": np.zeros(2), "a": np.zeros(3)})
    with pytest.raises(FileError, match="holds no row"):
        columns_of({"t": np.zeros(0)})


def test_every_unit_is_that_of_the_standard():
    """NIST SP 811, table 8 and appendix B.8, as scipy states them."""
    own = {
        "length": {"m": 1.0, "mm": constants.milli, "cm": constants.centi, "km": constants.kilo, "ft": constants.foot,
                   "in": constants.inch, "au": constants.au},
        "angle": {"rad": 1.0, "deg": constants.degree, "rev": 360.0 * constants.degree},
        "time": {"s": 1.0, "ms": constants.milli, "us": constants.micro, "min": constants.minute, "h": constants.hour,
                 "day": constants.day},
    }  # fmt: skip
    for kind, units in own.items():
        assert set(columns.allowed(kind)) == set(units)
        assert {unit: columns.factor(kind, unit) for unit in units} == pytest.approx(units, rel=1e-15)
    for kind, above in (("velocity", "length"), ("angular velocity", "angle")):
        rates = {f"{a}/{t}": x / y for a, x in own[above].items() for t, y in own["time"].items()}
        assert {unit: columns.factor(kind, unit) for unit in columns.allowed(kind)} == pytest.approx(rates, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "doubt", "verdict", "figure"),
    [(8e-4, 1e-4, "agrees", "off by 0.0009 of the scene at most; the limit is 0.001"),
     (9e-4, 1e-4, "agrees", "off by 0.001"), (9.5e-4, 1e-4, "not-judged", "off by 0.00095 of the scene; the truth"),
     (1.05e-3, 1e-4, "not-judged", "off by 0.001"), (1.2e-3, 1e-4, "departs", "off by 0.0012 of the scene in rod")],
)  # fmt: skip
def test_the_verdict_by_the_truths_uncertainty(value, doubt, verdict, figure):
    _, truth, _ = irregular(1)
    word, reason = _verdict(Error(value, "exact", doubt, None, worst="rod"), truth, 1e-3)
    assert word == verdict
    assert reason.startswith(figure)
    assert _verdict(None, NoTruth("why"), 1.0) == ("not-judged", "why")
    assert _verdict(None, truth, 1.0) == ("not-judged", "the error is not finite")


def test_the_text_of_a_judgement_lists_the_largest_of_the_scene_first():
    rng = np.random.default_rng(3)
    parts = [
        Part(f"b{k}", "position", "m", float(s), float(r), float(t)) for k, (s, r, t) in enumerate(rng.random((12, 3)))
    ]
    parts.append(Part("none", "orientation", "rad"))
    found = Judgement("scene", "departs", "because", 1e-6, None, tuple(parts), {}, ("lacks",), (), {}, ("swapped",))
    head, suspicion, *lines, missing = str(found).splitlines()
    assert (head, suspicion.strip(), missing.strip()) == ("scene departs: because", "swapped", "lacks")
    worst = sorted(parts[:12], key=lambda p: p.relative or 0.0, reverse=True)[:MOST]
    assert [line.strip() for line in lines] == [
        f"{p.body} position: {p.largest:.3g} m at t = {p.at:.4g} s" for p in worst
    ]
    plain = found.to_dict()
    assert plain["parts"][0] == parts[0]._asdict()
    assert plain["error"] is None


def test_a_component_that_the_truth_does_not_know_is_stated_with_its_bound():
    path, truth, gaps = irregular(2)
    rough = Truth(truth.position, truth.orientation, 1.0, "exact", "", velocity=truth.velocity,
                  rate_uncertainty=np.full(len(path.times), 1e-12))  # fmt: skip
    parts = {(p.body, p.component): p for p in _parts(SCENE, path, rough)}
    for k, body in enumerate(SCENE.body_names):
        place = parts[body, "position"]
        assert (place.largest, place.at, place.final) == (None, None, None)
        assert place.below == pytest.approx(gaps["position"][:, k].max() + 1.0, rel=1e-6)
        assert parts[body, "velocity"].largest == pytest.approx(gaps["velocity"][:, k].max(), rel=1e-6)
        assert parts[body, "angular velocity"].largest is None
    rows = truth_rows(truth, np.array([4, 1]))
    assert np.array_equal(rows.position, truth.position[[4, 1]])
    assert rows.velocity is not None
    assert truth.velocity is not None
    assert np.array_equal(rows.velocity, truth.velocity[[4, 1]])


def test_a_column_that_is_not_there_is_answered_by_twenty_that_are():
    held = Columns(Path("a.csv"), {f"c{k}": np.zeros(1) for k in range(25)})
    listed = ", ".join(f"c{k}" for k in range(20))
    with pytest.raises(FileError, match=f"time: a.csv has no column 'zz'; it has: {listed}, \\.\\.\\.$"):
        _column(held, "zz", "time")


def test_wanted_times_are_as_near_in_any_unit(tmp_path):
    """Of a scene of 20 s, 1e-8 s is no other time and 4e-8 s is one."""
    file, scene = tmp_path / "map.toml", SCENE.model_copy(update={"duration": 20.0})
    place = 'position = {columns = ["x", "y"], unit = "m"}'
    file.write_text(f'[time]\ncolumn = "t"\nunit = "ms"\n[bodies.{scene.body_names[0]}]\n{place}\n')
    times = np.array([0.0, 1e3, 2e3 + 1e-5, 3e3 + 4e-5, 4e3])  # ms
    found = read_motion({"t": times, "x": times, "y": times}, scene, file, np.array([1.0, 2.0, 3.0]))
    assert found.columns.values["t"].tolist() == times[:3].tolist()


def test_a_change_is_small_over_the_scene_and_a_factor_may_be_negative():
    scene = scenes.make("torque_free_top").model_copy(update={"duration": 1e5})
    case: Any = SimpleNamespace(scene=scene, comparable_turns=False)
    world, turning = frames(case)
    assert not turning.is_none(np.array([0.0, 0.5 * NONE, 0.0]))  # rad/s: over 1e5 s it is large
    assert turning.is_none(np.array([0.0, 0.9e-5 * NONE, 0.0]))
    length = scales_of(scene).length
    units = np.array([1.0, 1.0, 1.0, length, length, length])
    small = NONE * np.array([0.5, -0.9, 0.5, 0.9, -0.5, 0.9])
    assert world.is_none(small * units)
    assert not world.is_none(1.5 * small * units)
    factor = _factor(lambda x: scene, "a term is")
    assert {start[0] > 0.0 for start in factor.starts} == {True, False}
    assert factor.say(np.array([1.23456])) == "a term is 1.235 times the scene's"


@pytest.mark.parametrize("n", [5, 12])
def test_a_parquet_file_is_read_in_batches_of_bounded_size(monkeypatch, tmp_path, n):
    """Batches of so many rows that they hold PART numbers; rows are counted from the start of the file."""
    made, file, asked = table(np.random.default_rng(n), n), tmp_path / "a.parquet", []
    file.write_bytes(b"")

    class Batch(list):
        schema = SimpleNamespace(names=list(made))

    class File:
        schema_arrow = SimpleNamespace(names=list(made))
        metadata = SimpleNamespace(num_rows=n)

        def __init__(self, path: Path) -> None:
            assert path == file

        def iter_batches(self, batch_size: int) -> Any:
            asked.append(batch_size)
            for k in range(0, n, batch_size):
                held = [own[k : k + batch_size] for own in made.values()]
                yield Batch(SimpleNamespace(to_numpy=lambda zero_copy_only, own=own: own) for own in held)

    monkeypatch.setattr(formats, "PART", 13)
    monkeypatch.setattr(formats.importlib, "import_module", lambda name: SimpleNamespace(ParquetFile=File))
    found = list(formats.parts(file))
    assert asked == [4]
    assert [len(part) for part in found] == [min(4, n - k) for k in range(0, n, 4)]
    assert np.concatenate([part.counted for part in found]).tolist() == list(range(n))
    assert [part.share for part in found] == [min(1.0, (k + 4) / n) for k in range(0, n, 4)]
    for name, column in made.items():
        assert np.array_equal(np.concatenate([part.values[name] for part in found]), column)


def test_a_motion_from_a_program_is_read_as_what_it_is():
    """A file, a trajectory, a data frame or arrays by name."""
    scene, (path, *_) = scenes.make("double_pendulum"), irregular(1, 4)
    assert library._source("a.csv", scene) == library._source(Path("a.csv"), scene) == Path("a.csv")
    own: Any = library._source(path, scene)
    assert own.keys() == {"bodies", "times", *POSES}
    assert own["bodies"].tolist() == scene.body_names
    assert all(own[name] is getattr(path, name) for name in ("times", *POSES))
    held = {"t": [0.0, 1.0], "a": [2.0, 3.0]}
    frame = SimpleNamespace(columns=["t", "a"])
    frame_of = type("Frame", (), {"columns": frame.columns, "__getitem__": lambda self, name: held[name]})()
    for given in (held, frame_of):
        found: Any = library._source(given, scene)
        assert {name: column.tolist() for name, column in found.items()} == held


def test_a_program_judges_by_the_machines_store(monkeypatch):
    opened: list[Any] = []
    monkeypatch.setattr(library, "Store", lambda *path: opened.append(path) or nullcontext())
    monkeypatch.setattr(library, "read_motion", lambda *given: given)
    monkeypatch.setattr(library, "truth_at", lambda runs, scene: "at")
    monkeypatch.setattr(library, "judged", lambda *given: given)
    found: Any = library.judge(SCENE, "a.csv", error=1e-3, column_map="m.toml")
    assert found == (SCENE, (Path("a.csv"), SCENE, Path("m.toml")), "at", 1e-3)
    assert opened == [(library.default_path(),)]


@pytest.mark.parametrize("count", [1, 19, 20, 21, 40])
def test_the_message_on_a_missing_column_lists_the_first_twenty(tmp_path, count):
    columns = columns_of({"t": np.arange(2.0), **{f"c{k}": np.zeros(2) for k in range(count - 1)}}, "t", None)
    names = ["t", *(f"c{k}" for k in range(count - 1))]
    with pytest.raises(FileError) as raised:
        _column(columns, "zzzz", "bodies.a.position")
    assert str(raised.value).endswith(f"it has: {', '.join(names[:20])}{', ...' if count > 20 else ''}")


@pytest.mark.parametrize(("value", "doubt", "verdict"), [
    (0.25, 0.0, "agrees"), (0.125, 0.125, "agrees"), (0.375, 0.125, "not-judged"), (0.376, 0.125, "departs"),
    (0.251, 0.0, "departs"), (0.126, 0.125, "not-judged"),
])  # fmt: skip
def test_an_error_equal_to_the_limit_agrees_and_one_that_the_doubt_explains_is_not_judged(value, doubt, verdict):
    _, truth, _ = irregular(1)
    assert _verdict(Error(value, "exact", doubt, None), truth, 0.25)[0] == verdict
