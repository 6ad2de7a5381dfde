"""Small statements of commands, pages and judgements, each against a few lines of its own."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner

from cross_checks.conformance import broken_engines, ladder
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.records import lines
from cross_checks.records.record import Error, Record
from cross_checks.trajectory_files.formats import OWN, FileError, parts
from cross_checks.trajectory_files.mistakes import case
from cross_checks.trajectory_files.motion import read_motion
from mbs_ref import scenes
from mbs_ref.trajectory import Trajectory
from reports import inputs
from reports.cli import main
from reports.commands.judge import check
from reports.commands.maintenance import nightly
from reports.commands.publish import show
from reports.commands.run import inspect
from reports.facts.report_data import ReportData
from reports.page import files
from reports.page.sections import plots, prices
from reports.page.sections.extremes import _index
from reports.page.slug import command
from reports.site import links
from reports.studies import crash
from reports.studies.papers import track_figures

RECORD = Record("pendulum", {}, "exudyn", "rk4", {"step": 0.25, "rtol": 1e-6, "samples": 11}, "success")


def test_a_status_without_a_message_stands_alone():
    assert "success:" not in RECORD._repr_html_()
    assert "success: but late" in replace(RECORD, message="but late")._repr_html_()


def test_the_list_of_commands_fits_the_terminal():
    context = click.Context(main, terminal_width=60)
    formatter = context.make_formatter()
    main.format_commands(context, formatter)
    lines = formatter.getvalue().splitlines()
    assert len(lines) > 20
    assert 50 < max(map(len, lines)) <= 60


@pytest.mark.parametrize(("text", "value"), [("0.5", 0.5), ("0", None), ("-0.5", None), ("inf", None), ("nan", None)])
def test_positive_numbers_are_finite(text, value):
    if value:
        assert inputs.POSITIVE.convert(text, None, None) == value
        return
    with pytest.raises(click.BadParameter, match=r"must be a finite number greater than 0"):
        inputs.POSITIVE.convert(text, None, None)


def test_a_command_has_the_settings_that_a_record_states():
    plain = "mbs-ref simulate pendulum --engine exudyn"
    assert command(RECORD).startswith(f"{plain} --method rk4 --step 0.25 --rtol 1e-06 --samples ")
    assert command(replace(RECORD, method="", settings={})).startswith(f"{plain} --samples ")


@pytest.mark.parametrize(("values", "places"), [
    ((1.0, 10.0, 1000.0), {1.0: 0, 10.0: 1, 1000.0: 2, 10.0**0.5: 0.5, 100.0: 1.5, 1e4: 2.5, 0.1: -1.0}),
    ((1000.0, 10.0, 1.0), {1000.0: 0, 10.0: 1, 1.0: 2, 10.0**0.5: 1.5, 100.0: 0.5}),
    ((0.0, 1.0, 3.0), {0.5: 0.5, 3.0**0.5: 1.5}),
])  # fmt: skip
def test_a_value_between_listed_ones_has_a_place_between_them(values, places):
    assert {value: _index(value, values) for value in places} == pytest.approx(places)


def test_documents_leave_out_engines_that_are_not_installed(monkeypatch):
    cells = [Cell("pendulum", {}, engine, "m", verdict, "why") for engine, verdict in (
        ("here", Verdict.AGREES), ("gone", Verdict.ENGINE_MISSING))]  # fmt: skip
    seen: list[Any] = []
    template = SimpleNamespace(render=lambda context: seen.append(context) or "")
    monkeypatch.setattr(files, "templates", lambda: SimpleNamespace(get_template=lambda name: template))
    monkeypatch.setattr(files, "view", lambda cell: dict.fromkeys(files.VERDICTS.values(), cell.engine))
    data = ReportData(tuple(cells), ())
    files.document(data, "any")
    ((rows,),) = (context["verdicts"].values() for context in seen)
    assert rows == [["here"] * len(files.VERDICTS)]
    assert seen[0]["missing"] == ["gone"]
    assert data.installed == ["here"]


def test_a_check_has_its_time_for_each_scene(monkeypatch):
    asked: list[Any] = []
    monkeypatch.setattr(check, "answers", lambda runs, wanted, progress: asked.append(runs.time_left) or [])
    monkeypatch.setattr(check.inputs, "engine_names", lambda chosen: ["mbs_ref"])
    for names in (["pendulum"], ["pendulum", "kepler", "slider_crank"]):
        CliRunner().invoke(main, ["check", *names, "--engine", "mbs_ref"], prog_name="mbs-ref")
    assert asked == [check.CHECK, 3 * check.CHECK]


def test_an_engine_drives_the_track_at_the_times_of_the_fine_run(monkeypatch):
    asked: list[Any] = []
    path: Any = SimpleNamespace(ok=True, message="it stops")
    solver = SimpleNamespace(run=lambda *given: asked.append(given) or path)
    monkeypatch.setattr(track_figures.engines, "get", {"exudyn": solver}.__getitem__)
    monkeypatch.setattr(track_figures, "farthest", lambda scene, one, other: [(scene, one, other), "no"])
    fine = SimpleNamespace(times="times")
    given: Any = ("scene", "exudyn", "settings", fine)
    assert track_figures._engine(*given) == ("scene", path, fine)
    assert asked == [("scene", "settings", "times")]
    path.ok = False
    assert track_figures._engine(*given) == "it stops"


def test_a_head_that_starts_free_leaves_after_the_start():
    """Depths of the head's contact: free at the start, in the seat, free again, and back."""
    scene: Any = SimpleNamespace(contacts=[SimpleNamespace(name="rest", body_a="head")])
    times, depth = np.arange(6.0) / 4.0, np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
    for shown, back in ((6, 1.25), (5, "never")):
        path: Any = SimpleNamespace(times=times[:shown], contacts={"rest": depth[:shown, None]})
        assert crash._head_contact(scene, path) == {"head_leaves": 0.75, "head_back": back}


def test_angles_that_are_wrong_are_so_since_the_start():
    scene, times, turn = scenes.make("double_pendulum"), np.arange(3.0), np.array([[1.0, 2.0], [3.0, 2.0], [5.0, 0.0]])
    path = Trajectory(times, np.zeros((3, 2, 2)), turn, np.zeros((3, 2, 2)), 2.0 * turn)
    found = broken_engines._angles_off(scene, path)
    assert found.orientation == pytest.approx(np.array([[1.0, 2.0], [3.02, 2.0], [5.04, -0.02]]))
    assert found.angular_velocity == pytest.approx(2.02 * turn)


def test_the_work_of_a_scene_counts_its_bodies(monkeypatch):
    monkeypatch.setattr(case, "simulate", lambda scene, settings: SimpleNamespace(rhs_calls=70.0))
    given: Any = SimpleNamespace(scene=scenes.make("double_pendulum"))
    assert case.Case.work.func(given) == 140.0  # type: ignore[attr-defined]


@pytest.mark.parametrize(("off", "said"), [(0.5, False), (2.0, True)])
@pytest.mark.parametrize("roundoff", [None, 1e-6])
def test_a_start_may_be_off_by_the_finest_target_or_by_the_methods_rounding(monkeypatch, off, said, roundoff):
    """Of the scene: the finest target of a search; methods of coarse rounding may err by a multiple of it."""
    method: Any = SimpleNamespace(roundoff=roundoff or 1e-16)
    allowed = TARGETS[-1] if roundoff is None else ladder.ROUNDED * roundoff
    assert allowed >= min(TARGETS)
    scene, times = scenes.make("pendulum"), np.linspace(0.0, 1.0, 5)
    monkeypatch.setattr(ladder, "relative", lambda *given: np.array([[off * allowed, 0.0, math.nan, 0.0]]))
    monkeypatch.setattr(ladder, "slope_misses", lambda *given: (np.zeros((4, 2)), 0.0))
    monkeypatch.setattr(ladder, "impossible_time", lambda runs: "")
    still = np.zeros((5, 1, 2))
    run = SimpleNamespace(path=Trajectory(times, still, still[..., 0], still, still[..., 0]), setting="s")
    rising: Any = SimpleNamespace(question=SimpleNamespace(scene=scene, times=times), method=method, runs=[run],
                                  deviation=lambda *given: "")  # fmt: skip
    found = dict(ladder._always(rising))
    assert found["start"].startswith("the first sample is off: position by") == said
    assert bool(found["start"]) == said


@pytest.mark.parametrize(("link", "why"), [
    ("mailto:someone", ""), ("https://host", ""), ("https://host/page", ""), ("https:", "names no host"),
])  # fmt: skip
def test_a_link_to_elsewhere_names_a_host_or_a_person(tmp_path, link, why):
    assert links._trouble(tmp_path, {}, tmp_path / "index.html", link) == why


def test_facts_of_any_kind_are_shown():
    given = {"a": 1.5, "b": None, "c": "word", "d": [], "e": [True, 2], "f": [[-1.0, 0.0], [0.0, 2.0], [0.0, -2.0]]}
    text = "a 1.5, b not limited by stability, c word, d none, e True, 2, f -1, 0 ± 2i"
    assert inspect._cell(given) == text


def test_bars_of_phases_state_whose_they_are():
    error, spans = Error(1e-7, "exact", 0.0, None), {"build_s": 0.5, "first_call_s": 0.25}
    runs = [replace(RECORD, engine=engine, times=spans | {"loop_s": loop}, error=error)
            for engine, loop in (("one", 1.0), ("other", 2.0))]  # fmt: skip
    shown = plots.time_split(runs)
    assert shown
    assert [bar["y"] for bar in shown["data"]] == [["other · rk4", "one · rk4"]] * 3
    for bar, phase in zip(shown["data"], ("build", "first call", "loop"), strict=True):
        assert [text.split("<br>")[0] for text in bar["text"]] == bar["y"]
        assert all(phase in text.lower() for text in bar["text"])


def test_scenes_without_runs_have_no_plot_of_prices():
    cell = Cell("kepler", {}, "exudyn", "m", Verdict.CANNOT, "why")
    run = replace(RECORD, times={"loop_s": 1.0}, error=Error(1e-7, "exact", 0.0, None))
    found = prices.context(ReportData((cell,), (run,)))
    assert found["plots"].keys() == {"pendulum"}
    assert found["tables"].keys() == {"kepler", "pendulum"}


def test_a_report_in_the_terminal_lists_verdicts_apart_from_refusals(monkeypatch):
    seen: dict[str, Any] = {}
    monkeypatch.setattr(show, "show_table", lambda title, head, rows: seen.update({title.strip(): list(rows)}))
    monkeypatch.setattr(show, "price_plot", lambda data: "")
    cells = [Cell("pendulum", {}, "exudyn", f"m{k}", verdict, "why") for k, verdict in enumerate(
        (Verdict.AGREES, Verdict.CANNOT, Verdict.FAILED))]  # fmt: skip
    show._tables(ReportData(tuple(cells), ()), "pendulum", [["price"]])
    assert [[cell for cell in row if cell in ("m0", "m1", "m2")] for row in seen["Verdicts"]] == [["m0"], ["m2"]]
    assert len(seen["Refused"]) == 1
    assert seen["pendulum: cost at equal error, over the scene's own scales"] == [["price"]]


def test_sweeps_of_a_night_have_files_without_blanks(monkeypatch, tmp_path):
    """Records of the night before are in the folder beside, under the same name."""
    files_asked: list[str] = []
    folder = tmp_path / "sweeps"
    folder.mkdir()
    for name, parameters in nightly.SWEPT:
        label = scenes.label(name, scenes.make(name, **parameters).parameters)
        lines.append(folder / f"{label.replace(' ', '_')}.jsonl", [RECORD])
    monkeypatch.setattr(nightly, "sweep_records", lambda scene, *given: files_asked.append(given[-1].name) or [RECORD])
    entries, changes = nightly._sweep(folder, "", ("job", "2026-01-01", "abc", "box"))
    assert all(" " not in name for name in files_asked)
    assert len(changes) == len(files_asked) == len(nightly.SWEPT)
    assert entries == []  # the record has no error


def test_an_angle_of_the_other_sign_starts_where_it_does():
    """In space the quaternion has another sign from one sample to the next."""
    scene, turn = scenes.make("double_pendulum"), np.array([[1.0, 2.0], [3.0, 2.5]])
    still = np.zeros((2, 2, 2))
    found = broken_engines._turned_back(scene, Trajectory(np.arange(2.0), still, turn, still, turn))
    assert found.orientation == pytest.approx(np.array([[1.0, 2.0], [-1.0, 1.5]]))
    assert np.array_equal(found.angular_velocity, turn)


def test_columns_of_another_program_need_a_map(tmp_path):
    (tmp_path / "tool.csv").write_text("t,x\n0,1\n1,2\n")
    text = "tool.csv: its columns are not those that mbs-ref writes of pendulum; state what they mean by --map"
    with pytest.raises(FileError, match=re.escape(text)):
        read_motion(tmp_path / "tool.csv", scenes.make("pendulum"))
    (tmp_path / "tool.npz").write_text("no archive")
    with pytest.raises(FileError, match="cannot be read as NPZ: "):
        list(parts(tmp_path / "tool.npz"))
    shapes = {"position": (2, 1, 2), "orientation": (2, 1), "velocity": (2, 1, 2), "angular_velocity": (2, 1)}
    assert shapes.keys() | {"bodies", "times"} == OWN
    arrays = {name: np.zeros(shape) for name, shape in shapes.items()}
    np.savez(tmp_path / "own.npz", times=np.arange(2.0), bodies=np.array(["a"]), **arrays)
    (whole,) = parts(tmp_path / "own.npz")
    assert {"t", "a.x", "a.y"} <= whole.values.keys()
