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
from scipy.spatial.transform import Rotation

from cross_checks.conformance import apart, broken_engines, ladder, loading, probes, symmetry
from cross_checks.conformance.symmetry.placement import Placement
from cross_checks.extremes import fate
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.prices.pick import Choice
from cross_checks.records import lines
from cross_checks.records import plots as of_runs
from cross_checks.records.record import Error, Record
from cross_checks.trajectory_files.formats import OWN, FileError, parts
from cross_checks.trajectory_files.mistakes import case
from cross_checks.trajectory_files.motion import read_motion
from mbs_ref import Settings, scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.trajectory import Trajectory
from reports import inputs
from reports.cli import main
from reports.commands.choose import pick as pick_command
from reports.commands.judge import check
from reports.commands.maintenance import nightly
from reports.commands.publish import show
from reports.commands.run import inspect
from reports.facts.report_data import ReportData
from reports.film import drawing
from reports.page import files
from reports.page.sections import plots, prices
from reports.page.sections.extremes import _index
from reports.page.slug import command
from reports.site import links
from reports.studies import crash, models
from reports.studies import papers as formulations
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
    (mistake,) = [one for one in broken_engines.mistakes() if one.name == "angles wrong, positions right"]
    assert mistake.spoil is not None
    found = mistake.spoil(scene, path)
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


def test_marks_below_a_resting_surface_are_a_pitch_apart_and_slant():
    """At whole multiples of the pitch along the surface; a surface that moves, or is a point, has none."""
    ends = np.array([[0.5, 1.0], [1.7, 1.0]])
    moving = np.stack((ends + 7.0, ends + 7.1))
    found = drawing._hatching([np.stack((ends, ends)), moving, np.zeros((2, 2, 2))], 0.5)
    assert [line.shape for line in found] == [(2, 2, 2)] * 3
    assert np.array([line[0] for line in found]) == pytest.approx(
        np.array([[[x, 1.0], [x - 0.15, 0.85]] for x in (0.5, 1.0, 1.5)])
    )


@pytest.mark.parametrize(("turned", "count"), [(3.0, 0), (3.3, drawing.SPOKES)])
def test_spokes_are_of_wheels_that_turn_by_more_than_half_a_turn(turned, count):
    scene, still = scenes.make("rolling_disc"), np.zeros((2, 1, 2))
    place = still + np.array(scene.bodies[0].position)
    path = Trajectory(np.arange(2.0), place, np.array([[0.0], [turned]]), still, still[..., 0])
    assert len(drawing._turning(Motion(scene, path))) == count


def test_a_rectangle_in_space_is_drawn_with_its_own_size():
    scene = scenes.make("rolling_sphere")
    (contact,) = scene.contacts
    plate: Any = contact.model_copy(update={"size": (4.0, 2.0), "edge": (1.0, 0.0, 0.0), "extent": "rectangle"})
    start = np.array([scene.bodies[0].position])
    path = Trajectory(np.zeros(1), start[None], np.array([[[1.0, 0.0, 0.0, 0.0]]]), *np.zeros((2, 1, 1, 3)))
    sides = drawing._sides(Motion(scene, path), [plate])
    assert [float(np.linalg.norm(side[0, 1] - side[0, 0])) for side in sides] == pytest.approx([2.0, 4.0, 2.0, 4.0])
    assert np.mean([side[0] for side in sides], axis=(0, 1)) == pytest.approx(np.array(plate.point))


def test_rates_of_euler_angles_turn_a_body_at_its_angular_velocity():
    """About z by the precession, then about x by the nutation, then about z by the spin; by differences."""
    angles, rates, step = np.array([0.4, 0.9, -1.3]), np.array([0.7, -0.2, 1.1]), 1e-6
    one, other = (Rotation.from_euler("ZXZ", angles + sign * 0.5 * step * rates) for sign in (-1.0, 1.0))
    spin = (other * one.inv()).as_rotvec() / step
    assert formulations._rate_matrix(angles[0], angles[1]) @ spin == pytest.approx(rates[[0, 1, 2]], abs=1e-8)


def test_a_curve_of_runs_has_a_linear_axis_of_time_and_leaves_out_the_start():
    run = replace(RECORD, times={"loop_s": 1.0}, error=Error(1e-7, "exact", 0.0, None),
                  history={"t": [0.0, 1.0, 2.0], "error": [0.0, 1e-9, 2e-9]})  # fmt: skip
    other = replace(run, engine="mujoco", history={})
    shown = of_runs._history([run, other], "error", "error of the scene")
    assert shown
    (line,) = shown["data"]
    assert (line["x"], line["y"]) == ([1.0, 2.0], [1e-9, 2e-9])
    assert shown["layout"]["xaxis"].get("type", "-") != "log"
    assert of_runs._history([replace(run, history={})], "error", "") is None


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_cells_of_the_extremes_are_lines_or_a_table(monkeypatch, form):
    cell = fate.Cell("overflow", "numbers", "mbs_ref", "rk4", False, fate.Fate.SURVIVED, 1.0, (), "why")
    tables: list[Any] = []
    monkeypatch.setattr("cross_checks.extremes.run.matrix", lambda *given, **more: iter([cell]))
    monkeypatch.setattr("reports.commands.explore.extremes._show", tables.append)
    done = CliRunner().invoke(main, ["extremes", "--only", "overflow", "--engine", "mbs_ref", *form])
    assert done.exit_code == 0, done.output
    assert len([line for line in done.stdout.splitlines() if '"overflow"' in line]) == len(form)
    assert len(tables) == 1 - len(form)


def test_a_sweep_is_written_as_a_table_of_columns(monkeypatch, tmp_path):
    monkeypatch.setattr(inputs, "_has_pyarrow", lambda: True)
    monkeypatch.setattr("reports.commands.choose.sweep.sweep_records", lambda *given, **more: [RECORD])
    monkeypatch.setattr("reports.poses_file.parquet_table", lambda columns: repr(sorted(columns)).encode())
    done = CliRunner().invoke(main, ["sweep", "pendulum", "-o", str(tmp_path / "a.parquet")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "a.parquet").read_bytes() == repr(sorted(files.record_columns([RECORD]))).encode()


def test_an_engine_is_called_by_its_name_where_it_runs_apart(monkeypatch):
    asked: list[Any] = []
    solver = SimpleNamespace(run=lambda *given: asked.append(given) or "path")
    monkeypatch.setattr(apart.engines, "get", {"toy": solver}.__getitem__)
    given: Any = ("scene", "settings", "times")
    found = apart._call_by_name("toy", *given)
    assert (asked, found.settings, found.path) == ([given], "settings", "path")


def test_names_of_vectors_stand_for_their_first_components():
    name, vector = next((name, own) for name, own in probes.WORLDS["vectors"].items() if len(own) == 3)
    given = {"a": name, "b": [name, 2.0, "word"], "c": {"d": name}}
    for d in (2, 3):
        short = vector[:d]
        assert probes._resolved(given, d) == {"a": short, "b": [short, 2.0, "word"], "c": {"d": short}}


@pytest.mark.parametrize("margin", [None, 1.01])
def test_a_choice_without_a_runner_up_is_confirmed_by_no_duel(monkeypatch, margin):
    choice = Choice(RECORD, None if margin else RECORD, margin, "the sentence")
    monkeypatch.setattr(pick_command.pick, "duel", None)
    assert pick_command._confirmed(scenes.make("pendulum"), choice, True) == (choice, None)


def test_a_ladder_of_models_has_the_words_that_are_stated(monkeypatch):
    stated = models.LADDERS["planets"] | {"models": []}
    monkeypatch.setitem(models.LADDERS, "planets", stated)
    monkeypatch.setattr(models, "ladder", lambda *given: given)
    found: Any = models.built("planets")
    words = (stated["title"], stated["note"], stated["measured"])
    assert found == (*words, [], models.SHOWS[stated["shows"]], stated.get("by_last", False))


def test_an_image_is_run_for_as_long_as_its_clock_says(monkeypatch):
    """Lengths twice, times thrice as large: the end and the step are thrice as far."""
    scene, asked = scenes.make("double_pendulum"), []
    placed = Placement(np.eye(2), np.zeros(2), length=2.0, time=3.0)
    monkeypatch.setattr(symmetry, "_run", lambda engine, own, settings, times: asked.append((settings, times)) or "run")
    monkeypatch.setattr(symmetry, "_gap", lambda own, run, wanted: np.array([5.0, 9.0]))
    monkeypatch.setattr(symmetry, "moved", lambda plain, own: (plain.position,))
    plain: Any = SimpleNamespace(times=np.array([0.0, 0.5, 1.0]), position=np.zeros((3, 2, 2)))
    settings = Settings(method="rk4", step=0.25, t_end=1.0)
    assert symmetry._seen(lambda own: placed)("engine", scene, settings, plain) == 2.5
    ((chosen, times),) = asked
    assert (chosen.step, chosen.t_end, times.tolist()) == (0.75, 3.0, [0.0, 1.5, 3.0])


@pytest.mark.parametrize(("engine", "where"), [("toy", "set"), ("toy_.py", "rename the file to other_.py, or set")])
def test_a_class_of_another_name_is_told_to_change_it(monkeypatch, engine, where):
    """Only who named a file may rename it."""
    made: Any = SimpleNamespace(name="other", package="numpy", part_types=frozenset())
    monkeypatch.setattr(loading, "name_of", lambda given: "toy")
    with pytest.raises(loading.NoEngine, match=re.escape(f"its class is named 'other'; {where} name = 'toy'")):
        loading._named(made, engine)


def test_a_run_that_ends_with_other_samples_is_named_by_its_setting(monkeypatch):
    lost: Any = SimpleNamespace(path=SimpleNamespace(ok=False, message="it stops"))
    monkeypatch.setattr(ladder, "called", lambda *given: lost)
    run = SimpleNamespace(setting="step=0.1", settings=Settings(step=0.1), path="a path")
    question = SimpleNamespace(scene=scenes.make("pendulum"), times=np.linspace(0.0, 1.0, 41))
    rising: Any = SimpleNamespace(runs=[run], question=question)
    assert ladder._other_end(None, rising) == "step=0.1: with other samples the run ends: it stops"  # type: ignore[arg-type]


def test_points_of_errors_are_of_runs_that_have_one(monkeypatch):
    seen: list[Any] = []
    monkeypatch.setattr(of_runs, "add_series", lambda figure, engine, method, style, x, y, **more: seen.append((x, y)))
    runs = [replace(RECORD, times={"loop_s": 0.5 * k}, error=Error(10.0**-k, "exact", 0.0, None)) for k in (1, 2)]
    of_runs._add(None, "exudyn", "rk4", None, runs)  # type: ignore[arg-type]
    assert seen == [([500.0, 1000.0], [0.1, 0.01])]
