"""Frames, plots, names and stored lines: everything they state, computed again from irregular runs."""

from __future__ import annotations

import importlib
import json
import random
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.engine import Engine
from cross_checks.records import bands, figures, frames, lines, numbers, plots
from cross_checks.records import record as records
from cross_checks.records import store as naming
from cross_checks.records.record import Record
from cross_checks.records.store import Run, Store
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.many.ensemble import Coordinate, Statistics
from mbs_ref.trajectory import Trajectory
from tests.cross_checks.records.test_figures_of_records import made

UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
PLANAR, SPATIAL = scenes.make("double_pendulum"), scenes.make("solar_system", formulation="point")
CURVES = {"compliance_position": figures.compliance, "energy_drift": figures.energy, "error": figures.error}


def motion(scene: Scene, n: int = 4) -> Trajectory:
    """Return a motion of no law."""
    rng, bodies = np.random.default_rng(n), len(scene.bodies)
    turns = ((), ()) if scene.dimension == 2 else ((4,), (3,))
    shapes = (scene.dimension,), turns[0], (scene.dimension,), turns[1]
    return Trajectory(np.cumsum(rng.uniform(0.1, 1.0, n)), *(rng.normal(size=(n, bodies, *shape)) for shape in shapes))


def curved(seed: int, count: int = 8) -> list[Record]:
    """Return runs of two engines with curves, of unequal lengths, and counts of their own."""
    chance, runs = random.Random(seed), []
    for k in range(count):
        n = chance.randint(3, 7)
        history = {name: [chance.uniform(-1.0, 1.0) for _ in range(n)] for name in ("t", *CURVES)}
        kept = {"status": "success", "method": f"m{k % 3}", "history": history, "steps": 10 + k, "rhs_calls": 90 + k}
        runs.append(replace(made(chance, "ab"[k % 2]), **kept, measures={"compliance_position": 10.0**-k}))
    return runs


def test_a_frame_holds_every_leaf_of_every_run(monkeypatch):
    monkeypatch.setattr(frames, "_library", lambda name: SimpleNamespace(DataFrame=dict))
    runs = [*curved(1), replace(curved(2)[0], error=None, notes=("late", "busy"), events={"hit": [1.0]})]
    table = frames.frame([Run(runs[0], None), *runs[1:]])
    assert {"error.length", "times.loop_s", "settings.step", "measures.compliance_position"} < table.keys()
    assert not {"final", "history", "events"} & {name.split(".")[0] for name in table}
    for k, run in enumerate(runs):
        for name, column in table.items():
            value: Any = run.to_dict()
            for part in name.split("."):
                value = value.get(part) if isinstance(value, dict) else None
            value = None if isinstance(value, dict) else "; ".join(value) if isinstance(value, tuple) else value
            assert column[k] == value, name
    assert dict(frames._flat({"a": {"b": {"c": 1}, "d": (2, 3)}})) == {"a.b.c": 1, "a.d": "2; 3"}


@pytest.mark.parametrize("scene", [PLANAR, SPATIAL], ids=lambda scene: scene.name)
def test_a_frame_of_samples_holds_every_number_in_si(monkeypatch, scene):
    monkeypatch.setattr(frames, "_library", lambda name: SimpleNamespace(DataFrame=dict))
    path = motion(scene)
    table = frames.samples(scene, path)
    assert table.pop("t") == pytest.approx(path.times)
    parts = (path.position, path.orientation, path.velocity, path.angular_velocity)
    expected = np.concatenate([np.reshape(part, (len(path.times), len(scene.bodies), -1)) for part in parts], axis=2)
    assert np.array_equal(np.array(list(table.values())).T, expected.reshape(len(path.times), -1))
    assert next(iter(table)).startswith(scene.body_names[0])


def test_a_library_that_lacks_a_part_of_its_own_says_which(monkeypatch):
    def fails(name):
        raise ModuleNotFoundError("No module named 'inner'", name="inner")

    monkeypatch.setattr(importlib, "import_module", fails)
    with pytest.raises(ModuleNotFoundError, match="inner"):
        frames._library("pandas")


def titles(figure: Any) -> tuple[str, str]:
    return figure.layout.xaxis.title.text, figure.layout.yaxis.title.text


@pytest.mark.parametrize("scene", [PLANAR, SPATIAL], ids=lambda scene: scene.name)
def test_motions_and_quantities_over_time(scene):
    path, few = motion(scene), list(scene.body_names[:0:-1])
    figure = figures.motion(scene, path, few)
    assert [line.name for line in figure.data] == few
    for line in figure.data:
        place = path.position[:, scene.body_names.index(line.name)]
        assert np.array_equal(np.array([line[axis] for axis in "xyz"[: scene.dimension]]).T, place)
    assert len(figures.motion(scene, path).data) == len(scene.bodies)
    if scene.dimension == 2:
        assert titles(figure) == ("x, m", "y, m")
        assert figure.layout.yaxis.scaleanchor == "x"
        assert {figure.layout.xaxis.type, figure.layout.yaxis.type} == {"-"}
    else:
        assert [figure.layout.scene[f"{a}axis"].title.text for a in "xyz"] == ["x, m", "y, m", "z, m"]
        assert figure.layout.scene.aspectmode == "data"
    turn = "rad" if scene.dimension == 2 else "Euler parameters"
    for quantity, unit in (
        ("position", "m"),
        ("orientation", turn),
        ("velocity", "m/s"),
        ("angular_velocity", "rad/s"),
    ):
        body = scene.body_names[-1]
        figure = figures.over_time(scene, path, body, quantity)
        values = getattr(path, quantity)[:, -1].reshape(len(path.times), -1)
        names = {1: ["angle"], 4: ["e0", "e1", "e2", "e3"]}.get(values.shape[1], list("xyz")[: values.shape[1]])
        assert [line.name for line in figure.data] == names
        assert np.array_equal(np.array([line.y for line in figure.data]).T, values)
        assert all(np.array_equal(line.x, path.times) for line in figure.data)
        assert titles(figure) == ("time, s", f"{quantity.replace('_', ' ')} of {body}, {unit}")


@pytest.mark.parametrize("name", CURVES)
def test_curves_of_the_best_runs(name):
    runs = curved(3)
    units = {"compliance_position": "m or rad", "energy_drift": "J", "error": "over the scene's scales"}
    figure = CURVES[name]([Run(runs[0], None), *runs[1:]])
    best = {run.engine: run for run in records.best_of_engines(runs)}
    assert {line.meta["engine"] for line in figure.data} == best.keys()
    for line in figure.data:
        run = best[line.meta["engine"]]
        assert list(line.x) == run.history["t"][1:]
        assert list(line.y) == [abs(x) for x in run.history[name][1:] if x is not None]
        assert line.name == run.method
        assert numbers.setting(run.settings) in line.hovertemplate
    assert titles(figure)[0] == "time, s"
    assert titles(figure)[1].endswith(units[name])
    with pytest.raises(ValueError, match="1 runs, none with"):
        CURVES[name]([replace(runs[0], history={})])


def test_work_and_precision_by_the_hover_of_each_run():
    runs = curved(4)
    figure = figures.work_precision(runs)
    by_step = {numbers.setting(run.settings): run for run in runs}
    drawn = {(line.meta["engine"], line.name) for line in figure.data}
    assert drawn == {(e, n) for r in runs for e, n in ((r.engine, r.method), (r.engine, "frontier"))}
    for line in figure.data:
        for x, y, text in zip(line.x, line.y, line.text, strict=True):
            head, setting, error, joints, loop = text.split("<br>")
            run = by_step[setting]
            assert run.error
            assert head == f"{run.engine} · {run.method}"
            assert (x, y) == (pytest.approx(1e3 * run.times["loop_s"]), run.error.value)
            assert error.startswith(f"error {run.error.value:.1e}".replace("e-0", "e-").replace(".0e", "e"))
            assert f"{numbers.short(run.error.value * run.error.length)} m; worst: {run.error.worst}" in error
            assert joints == f"joints within {numbers.short(run.measures['compliance_position'])} m, rad"
            value, unit, rest = re.match(r"loop (\S+) (\S+) \((.*)", loop).groups()  # type: ignore[union-attr]
            assert float(value) * UNITS[unit] == pytest.approx(run.times["loop_s"], rel=5e-3)
            assert rest == f"one run, beside others), {run.steps} steps, {run.rhs_calls} right-hand sides"
    low, high = figure.layout.yaxis.range  # in decades, as places of labels are on such an axis
    (band,), (label,) = figure.layout.shapes, figure.layout.annotations
    assert low <= label.y <= high
    assert 10**label.y == pytest.approx(band.y1) == pytest.approx(records.floor(runs))
    with pytest.raises(ValueError, match="none with an error and a time"):
        figures.work_precision([replace(run, error=None) for run in runs])
    alone = replace(runs[0], times=runs[0].times | {"loop_runs": 3.0})
    assert "(with a processor to itself)" in plots._hover(alone)


def test_zeros_and_gaps_of_a_series():
    figure = plots.new_figure("a", "b")
    plots.add_series(figure, "e<", "m<", plots.Style("#1", "star", "dot"), [1.0, 2.0, 3.0], [0.0, None, -2.0])
    (line,) = figure.data
    assert line["y"] == [plots.FLOOR, None, 2.0]
    assert (line["name"], line["legendgroup"]) == ("m&lt;", "e<")
    assert (line["line"]["color"], line["line"]["dash"], line["marker"]["symbol"]) == ("#1", "dot", "star")


def test_every_method_is_drawn_in_its_engines_colour_and_a_dash_of_its_own():
    ours, *others = engines.names()[:3]
    runs = [replace(curved(5)[0], engine=e, method=m) for e in (others[1], others[0], ours) for m in "hgfedcba"]
    found = plots.styles(runs)
    assert list(found) == [(e, m) for e in (ours, *sorted(others)) for m in "abcdefgh"]
    places = [name for name in engines.names() if engines.is_ours(name)]
    for engine in (ours, *others):
        own = [found[engine, m] for m in "abcdefgh"]
        assert {style.colour for style in own} == {plots.COLOURS[places.index(engine) % len(plots.COLOURS)]}
        assert {style.symbol.removesuffix("-open") for style in own} == {plots.SYMBOLS[places.index(engine)]}
        assert len({(style.dash, style.symbol) for style in own}) == 8
    strange = [plots.style_of.__wrapped__(name) for name in ("solver of mine", "another")]
    assert strange[0] != strange[1]


def test_bands_of_two_coordinates_stand_one_below_the_other(monkeypatch):
    named = [Coordinate(body, name, unit) for body in ("a", "b") for name, unit in (("x", "m"), ("angle", "rad"))]
    quantiles = np.sort(np.random.default_rng(2).normal(size=(3, 5, 4)), axis=0)
    zero = np.zeros((5, 4))
    one = Statistics(7, zero, zero, quantiles, zero, zero, zero, zero)
    monkeypatch.setattr(bands, "SHOWN", 3)
    monkeypatch.setattr(bands, "coordinates", lambda ensemble: named)
    monkeypatch.setattr(bands, "statistics", lambda ensemble: [one, None, replace(one, count=1)])
    design = SimpleNamespace(grids=("g",), points=[(1.2345,), (2.0,), (1.2346,)])
    ensemble: Any = SimpleNamespace(times=np.arange(5.0), scene=SimpleNamespace(body_names=("a", "b")), design=design)
    figure = bands.bands(ensemble)
    axes = [figure.layout["yaxis"], figure.layout["yaxis2"]]
    assert [axis["title"]["text"] for axis in axes] == ["x, m", "angle, rad"]
    (low1, high1), (low2, high2) = (axis["domain"] for axis in axes)
    assert (high1, low2, high2) == pytest.approx((1.0, 0.0, 0.5))
    assert low1 == pytest.approx(0.5 + bands.GAP)
    assert figure.layout["xaxis"]["anchor"] == "y2"
    assert figure.layout["height"] == 2 * bands.HEIGHT
    medians = [line for line in figure.data if "fill" not in line]
    shown = [(f"{c.body} g = {at}", "y" if c.name == "x" else "y2", k)
             for body in "ab" for at in (1.2345, 1.2346) for k, c in enumerate(named) if c.body == body]  # fmt: skip
    assert [(line["name"], line["yaxis"]) for line in medians] == [(name, axis) for name, axis, _ in shown]
    for line, (_, axis, k) in zip(medians, shown, strict=True):
        assert line["y"] == quantiles[1, :, k].tolist()
        assert line["showlegend"] == (axis == "y")
    assert [line["visible"] for line in medians] == [True if k // 2 < 3 else "legendonly" for k in range(8)]
    assert len(figure.data) - len(medians) == 4  # of the first point; the last has one run


def test_each_line_that_is_no_record_is_named_by_its_number(tmp_path, monkeypatch):
    file, run = tmp_path / "a.jsonl", made(random.Random(3))
    lines.append(file, [run, run])
    good = file.read_bytes().splitlines()[0]
    file.write_bytes(good + b"\n\n{]\n" + good + b"\n[1]\n" + good.replace(b'"steps":0', b'"steps":NaN'))
    found, problems = lines.read(file)
    assert found == [run, run]
    assert [problem.split(":")[1] for problem in problems] == ["3", "5", "6"]
    assert "NaN is not a number" in problems[2]
    wrong = good.replace(b'"steps":0', b'"steps":"many"').replace(b'"t_end":0.0', b'"t_end":[]')
    file.write_bytes(wrong)
    ((problem,), _) = lines.read(file)[::-1]
    assert re.fullmatch(rf"{re.escape(str(file))}:1: no record, skipped: t_end: [^:;]+; steps: [^:;]+", problem)
    file.write_bytes(good + b"\n\n{]\n" + good + b"\n")
    monkeypatch.setattr(lines, "LONGEST_LINE", len(good))
    assert len(lines.read(file)[0]) == 2
    monkeypatch.setattr(lines, "LONGEST_LINE", len(good) - 1)
    assert lines.read(file)[0] == []
    monkeypatch.setattr(lines, "LONGEST_LINE", 3 * 2**20)
    with pytest.raises(ValueError, match="longer than 3 MiB"):
        lines._parsed(b" " * (3 * 2**20 + 1))


def test_a_store_keeps_its_own_run_of_a_key_and_gets_the_others(tmp_path):
    run = made(random.Random(3))
    with Store(tmp_path / "a.sqlite") as mine, Store(tmp_path / "b.sqlite") as other:
        mine.keep_run("both", Run(replace(run, steps=1), None))
        other.keep_run("both", Run(replace(run, steps=2), None))
        other.keep_run("theirs", Run(replace(run, steps=3), None))
        mine.keep_run("both", Run(replace(run, steps=4), None))
        assert mine.merge(tmp_path / "b.sqlite") == 1
        kept = {key: getattr(mine.run(key), "record").steps for key in ("both", "theirs")}  # noqa: B009
        assert (kept, len(mine), len(other)) == ({"both": 1, "theirs": 3}, 2, 2)
        mine.keep_arrays("a", {"kind": "x"}, {"y": np.arange(3.0)})
        mine.keep_arrays("a", {"kind": "z"}, {"y": np.arange(4.0)})
        facts, arrays = mine.arrays("a") or ({}, {})
        assert (facts, arrays["y"].tolist()) == ({"kind": "z"}, [0.0, 1.0, 2.0, 3.0])


def test_a_stored_motion_comes_back_whole():
    path = motion(SPATIAL)
    with Store() as store:
        store.keep_run("a", Run(made(random.Random(3)), path))
        back = store.run("a")
    assert back
    for name in ("times", "position", "orientation", "velocity", "angular_velocity"):
        assert np.array_equal(getattr(back.path, name), getattr(path, name)), name


def test_what_a_notebook_shows_of_a_run(monkeypatch):
    shown: dict[str, Any] = {}
    monkeypatch.setattr(records, "facts", lambda title, rows: shown.update({"title": title, **dict(rows)}))
    run = curved(6)[0]
    run = replace(run, settings={"rtol": 3e-5, "method": Settings().method}, bounds={"reach": 0.25}, notes=("n", "o"),
                  times={"loop_s": 2.5, "build_s": 7.5}, message="well", measures={"a": 4.0})  # fmt: skip
    run._repr_html_()
    error = run.error
    assert error
    assert shown["title"] == "pendulum: a m0"
    assert shown["settings"] == {"rtol": 3e-5}
    assert shown["status"] == "success: well"
    assert shown["error"] == f"{error.value:.2g} of the scene (position), {error.value * error.length:.2g} m"
    assert shown["truth"] == f"exact, known to {error.uncertainty:.2g} of the scene"
    assert (shown["loop, s"], shown["a"], shown["reach"], shown["notes"]) == (2.5, 4.0, "below 0.25", "n; o")


def test_one_run_stands_for_each_engine_and_the_last_of_equals():
    runs = curved(7)
    twin = replace(runs[0], steps=77)
    found = records.best_of_engines([*runs, twin])
    assert [run.engine for run in found] == ["a", "b"]
    first, last = (replace(made(random.Random(1), "z"), status="timeout", steps=k) for k in (1, 2))
    assert records.best_of_engines([first, last]) == [last]
    assert records.best_of_engines([twin, replace(twin, steps=78)])[0].steps == 78


def test_a_run_is_usable_where_it_ended_with_an_error_and_a_time():
    run = made(random.Random(3))
    good = replace(run, status="success", times={"loop_s": 1e-9})
    bad = (replace(good, times={"loop_s": 0.0}), replace(good, times={}), replace(good, error=None),
           replace(good, status="timeout"))  # fmt: skip
    assert [records.usable(one) for one in (good, *bad)] == [True, False, False, False, False]
    exact = replace(good, error=replace(good.error, value=6e-7, uncertainty=4e-7)) if good.error else good
    close = replace(exact, error=replace(exact.error, value=1e-9), times={"loop_s": 2.0}) if exact.error else exact
    assert records.best_of_engines([exact, close]) == [exact]  # 1e-6 is within 1e-6


def test_numbers_at_the_ends_of_their_classes():
    assert [numbers.of_scene(x) for x in (0.01, 0.00999, None)] == ["1 % of the scene", "0.01", "–"]
    ends = 0.0, -0.0, 0.01, 0.0099, 0.00999, 9949.0, 9950.0, 1e4, float("nan")
    assert [numbers.short(x) for x in ends] == ["0", "0", "0.01", "9.9e-3", "0.01", "9900", "1e4", "1e4", "–"]
    assert [numbers.metres(x) for x in (0.5, None, float("inf"))] == ["0.5 m", "–", "–"]
    assert [numbers.count(k, "cell") for k in (0, 1, 2)] == ["0 cells", "1 cell", "2 cells"]
    assert [numbers.duration(x) for x in (1.0, 1e-3, 9.99e-4, None)] == ["1 s", "1 ms", "999 µs", "–"]
    day = 24 * 3600
    spans = [
        numbers.duration(float(x)) for x in (599, 600, 7199, 7200, 2 * day - 3600, 2 * day, 730 * day, 730.5 * day)
    ]
    assert spans == ["599 s", "10 min", "120 min", "2 h", "47 h", "2 days", "730 days", "2 years"]
    given = ("step=0.00201613", "rtol=1e-06, atol=1e-09", "rtol=1e-06, mass=2", "defaults")
    assert [numbers.in_words(text) for text in given] == ["h = 2e-3 s", "rtol = 1e-6, atol = 1e-9", *given[2:]]
    assert numbers.setting({"step": 0.5, "stabilization": "none"}) == "h = 0.5 s, none"


def test_a_key_holds_name_version_adapter_and_contract(monkeypatch):
    monkeypatch.setattr(naming, "code_of", lambda module: f"code of {module}")
    engine: Any = type("Mine", (), {"__module__": "my.adapter", "name": "mine", "made_of": "",
                                    "version": lambda self: "7"})()  # fmt: skip
    parts = ["mine", "7", "code of my.adapter", f"code of {Engine.__module__}"]
    assert naming.engine_key(engine) == parts
    engine.made_of = "another file"
    assert naming.engine_key(engine) == [*parts, "another file"]
    kept: list[Any] = []
    monkeypatch.setattr(naming, "digest_of", kept.append)
    naming.run_name(PLANAR, engine, Settings(rtol=1e-3), np.array([0.0, 1.0]))
    assert kept[0]["measured by"] == f"code of {naming.MEASURING}"
    assert kept[0]["settings"]["rtol"] == 1e-3
    assert None not in kept[0]["settings"].values()


def test_a_digest_depends_on_contents_and_not_on_their_order():
    assert naming.digest_of({"a": 1, "b": 2}) == naming.digest_of({"b": 2, "a": 1})
    assert naming.digest_of({"a": 1, "b": 2}) != naming.digest_of({"a": 2, "b": 1})
    assert json.loads(lines.key_of(made(random.Random(1))))[0] == "pendulum"


def test_the_code_of_an_adapter_is_that_of_its_whole_folder(monkeypatch):
    monkeypatch.setattr(naming, "source_digest", lambda name: name)
    monkeypatch.setattr(naming, "digest_of", lambda names: names)
    found = naming.code_of.__wrapped__("cross_checks.engines.mujoco_")
    assert {"cross_checks.engines.mujoco_", "cross_checks.engines.mujoco_.forces"} < set(found)
    listed = naming.code_of.__wrapped__(naming.MEASURING)
    assert {"cross_checks.metrics.errors", "cross_checks.metrics.drifts"} < set(listed)


@pytest.mark.parametrize("logs", [(True, False), (False, True)])
def test_each_axis_of_a_figure_is_logarithmic_on_its_own(logs):
    made = plots.new_figure("a", "b", *logs)
    assert [made.layout[axis]["type"] == "log" for axis in ("xaxis", "yaxis")] == list(logs)
    assert [made.layout[axis]["title"]["text"] for axis in ("xaxis", "yaxis")] == ["a", "b"]
