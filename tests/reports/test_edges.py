"""What pages and commands show at their edges: none, one item, an absent word, an interruption, the first and last."""

from __future__ import annotations

import json
import signal
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import calibration
from benchmarks.trees import slowed
from benchmarks.trees.regression import CASES, Finding
from cross_checks.contact import tosses
from cross_checks.judge.answers import Answer
from cross_checks.judge.vocabulary import SILENT, WRONG, Verdict
from cross_checks.records.numbers import count
from cross_checks.records.record import Error, Record
from cross_checks.records.store import Store
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene.contact import SphereOnPlane
from mbs_ref.settings import Settings
from reports import console, query
from reports.cli import main
from reports.commands.choose import contact as contact_command
from reports.commands.choose import pick
from reports.commands.judge import check, proofs, prove
from reports.commands.maintenance import compare
from reports.facts import compiling
from reports.facts.report_data import MIDDLE, entries, least_time
from reports.film import drawing, files
from reports.page import build, findings
from reports.page.sections import matrix, overview, plots
from reports.studies import contact
from reports.studies.models import Ladder, Rung
from tests.reports.page.test_every_companion import report
from tests.reports.page.test_shown_figures import irregular


def run_of(error: float | None) -> Record:
    stated = None if error is None else Error(error, "exact", 0.0, None)
    return Record("pendulum", {}, "exudyn", "m", {"step": 0.1}, "success", error=stated, times={"loop_s": 1.0})


@pytest.mark.parametrize("error", [None, 1e-3])
def test_an_interrupted_pick_prints_the_best_so_far_or_what_is_missing(monkeypatch, capsys, error):
    def stop(*given: Any, **more: Any) -> None:
        raise pick.Interrupted("", [run_of(error)])

    monkeypatch.setattr(pick, "sweep_records", stop)
    monkeypatch.setattr(pick.pick, "basis", lambda records: "the basis")
    monkeypatch.setattr(pick.pick, "pick", lambda records, *bounds: SimpleNamespace(sentence="the best"))
    with pytest.raises(pick.Interrupted):
        pick._swept(scenes.make("pendulum"), (), None, pick.Bounds(1e-2, None, None), False)
    assert capsys.readouterr().out == f"Provisional: {'' if error is None else 'the best. '}the basis\n"


@pytest.mark.parametrize("seed", range(2))
def test_a_finding_states_that_a_fault_is_documented_where_it_is(seed):
    data = report(seed)
    found = list(findings.wrong_answers(data))
    assert found
    for one in found:
        (cell,) = [c for c in data.cells if f"mbs-ref rerun {c.name}" == one.command]
        assert cell.verdict in WRONG
        assert one.why == f"A & b {cell.reason[6:]}" + ("; documented: soft_ware." if cell.exemption else ".")
        assert one.error == ((cell.error or 0.0) if cell.verdict in SILENT else 0.0)


def test_a_ladder_shows_the_figures_of_its_first_model():
    first, last = Rung("a", 1.0, 1, {"x, m": 2.0}), Rung("b", 1.0, 1, {"y, m": 3.0})
    rows = Ladder("", "", "", "", (first, last)).rows()
    assert [row["x, m"] for row in rows] == ["2", matrix.ABSENT]
    assert not [row for row in rows if "y, m" in row]


def test_compiling_reports_every_step_from_none_to_all(monkeypatch):
    made, said = [f"part {k}" for k in range(3)], []
    monkeypatch.setattr(compiling, "preparations", lambda store, lanes: made)
    monkeypatch.setattr(compiling, "each", lambda wanted, work: [(one, None) for one in wanted])
    compiling.compile_kernels(None, lambda *given: said.append(given))  # type: ignore[arg-type]
    assert [(done, total) for done, total, _ in said] == [(k, 3) for k in range(4)]
    assert [words for *_, words in said[1:]] == [f"done: {one}" for one in made]


def test_an_enclosure_stands_beside_its_body(monkeypatch):
    shown: list[Any] = []
    monkeypatch.setattr(console, "show", shown.append)
    scene = scenes.make("double_pendulum")
    number = SimpleNamespace(str=lambda count: f"{count} digits", rad=lambda: 0.5)
    proof: Any = SimpleNamespace(model=SimpleNamespace(scene=scene, is_exhibited=False), reached=9.0,
                                 impacts=SimpleNamespace(times=[]))  # fmt: skip
    prove._show({}, proof, "", [0.0, 1.0], [[[number] * 14] * len(scene.bodies)] * 2, as_json=False)
    (table,) = shown
    names, digits = (list(column.cells) for column in table.columns)
    assert names == list(scene.body_names)
    assert set(digits) == {"  ".join(["25 digits"] * 6)}


def test_a_motion_without_events_is_balanced_over_the_whole_run():
    ball = contact._ball("progressive").model_copy(update={"contacts": ()})
    found = contact.balance(ball, Settings(method="dop853", rtol=1e-9, estimate="off", t_end=0.05), longest=1.0)
    assert found.times[-1] == 0.05
    assert np.abs(found.drift).max() < 1e-9


def test_a_slowed_tree_is_calibrated_on_the_first_case(monkeypatch, capsys):
    asked: list[Any] = []
    monkeypatch.setattr(slowed, "copy_tree", lambda folder: folder)
    monkeypatch.setattr(slowed, "calibrate", lambda tree, case, share: asked.append((case, share)) or (7, 0.123))
    monkeypatch.setattr(compare, "tree", lambda name: nullcontext(name))
    monkeypatch.setattr("benchmarks.trees.regression.regressions", lambda *given: iter(()))
    assert compare.findings_of("", "a", "b", CASES, slowed=12.0) == []
    assert asked == [(CASES[0], 0.12)]
    assert f"B takes 12.3% longer on {CASES[0].name}, by 7 square roots" in capsys.readouterr().err


@pytest.mark.parametrize(("verdicts", "named"), [(("slower", "same", "slower"), "c0, c2"), (("same",) * 3, None),
                                                 (("same", "not measured", "same"), "c1")])  # fmt: skip
def test_a_comparison_ends_with_the_cases_of_its_verdict(verdicts, named):
    found = [Finding(f"c{k}", verdict, "", None) for k, verdict in enumerate(verdicts)]
    if named is None:
        compare.end(found)
        return
    with pytest.raises((console.Failed, console.Incomplete)) as ended:
        compare.end(found)
    assert str(ended.value).endswith(f": {named}")


@pytest.mark.parametrize("settled", [True, False])
def test_the_verdicts_so_far_say_what_provisional_ones_are_judged_by(settled):
    cells = [c for c in irregular(3).cells if c.verdict is Verdict.AGREES][:3]
    truth = Truth(np.zeros((1, 1, 2)), np.zeros((1, 1)), 0.0, "agreed", "by two engines")
    said = check._best([Answer(None, c, (), truth, settled) for c in cells]).split("\n  ")  # type: ignore[arg-type]
    mark, (cell, *_) = "" if settled else " (provisional)", cells
    assert said[0] == f"{cell.scene}: {cell.verdict}{mark}: {', '.join(f'{c.engine} {c.method}' for c in cells)}"
    assert said[1:] == ([] if settled else [f"{cell.scene}: provisional while its truth is refined, by two engines"])
    unknown = Answer(None, cell, (), NoTruth("none"), False)  # type: ignore[arg-type]
    assert "refined" not in check._best([unknown])
    assert check._best([unknown._replace(truth=None)]) == ""


@pytest.mark.parametrize("count", [1, 2])
def test_a_matrix_names_scenes_and_engines_where_there_are_several(count):
    data = irregular(0)
    engines, labels = sorted({c.engine for c in data.cells})[:count], data.scenes[:count]
    cells = tuple(c for c in data.cells if c.engine in engines and c.label in labels)
    shown = matrix.context(replace(data, cells=cells, records=()))
    assert (shown["several_scenes"], shown["several_engines"]) == (count > 1, count > 1)


@pytest.mark.parametrize("over", ["step", "rtol"])
def test_errors_stand_over_the_setting(over):
    figure: Any = plots.convergence([replace(run_of(1e-3), settings={over: 0.1})], over, {})
    titles = [figure["layout"][f"{axis}axis"]["title"]["text"] for axis in "xy"]
    assert titles == [plots.AXES[over], "error over the scene's scales"]


def test_runs_that_are_kept_are_not_made_again(monkeypatch, tmp_path):
    def trial(seed: int, among: Any) -> Any:
        made.append(seed)
        return calibration.Trial(seed, "s", "m", "step 1", "success", 3.0, 1.0, 1e-9, 1.0, "")

    made: list[int] = []
    monkeypatch.setattr(calibration, "trial", trial)
    monkeypatch.setattr(calibration, "stored", lambda file: {1: trial(1, ()), 3: trial(3, ())})
    done = CliRunner().invoke(main, ["calibrate", "-n", "5", "--keep", str(tmp_path / "runs.jsonl"), "--json"])
    assert made == [1, 3, 0, 2, 4]
    assert sorted(run["seed"] for run in json.loads(done.stdout)["runs"]) == list(range(5))


def test_the_bar_of_a_picture_ends_before_its_edge():
    rng = np.random.default_rng(3)
    centres = rng.normal(size=(2, 3, 2))
    camera = files.Camera(seen := drawing.Drawing([], [], [], [], [], [], centres, np.array([0.0, 1.0])))
    is_grey = (np.asarray(camera.picture(seen, 0)) == (68, 68, 68)).all(axis=2)
    bar = np.flatnonzero(is_grey[camera.size[1] - 6])
    assert bar.max() == pytest.approx(camera.size[0] - 8, abs=1)


def test_a_plane_without_sides_is_drawn_twice_a_radius_around_the_paths_of_its_spheres():
    scene = scenes.make("rolling_sphere")
    floor: Any = next(c for c in scene.contacts if isinstance(c, SphereOnPlane))
    rng = np.random.default_rng(5)
    position, still = rng.normal(size=(6, 1, 3)), np.zeros((6, 1, 3))
    path: Any = SimpleNamespace(times=np.arange(6.0), position=position, velocity=still + 7.0, angular_velocity=still,
                                orientation=np.tile([1.0, 0.0, 0.0, 0.0], (6, 1, 1)), ok=True)  # fmt: skip
    ends = np.concatenate(drawing._sides(Motion(scene, path), [floor]), axis=1)[0]
    wide = np.ptp(position[:, 0, :2], axis=0) + 4.0 * floor.radius
    assert np.ptp(ends, axis=0) == pytest.approx([*wide, 0.0])


def test_a_browser_that_fails_is_an_error(monkeypatch):
    monkeypatch.setattr(build, "browser", lambda: "false")
    with pytest.raises(Exception, match="non-zero exit status 1"):
        build.drawn("page.html", "--screenshot")


def test_an_error_of_a_store_in_memory_says_so():
    kept = Store()
    kept.close()
    with pytest.raises(OSError, match=r"^the store in memory: .*name another store by --store"):
        len(kept)


def test_a_signal_interrupts_what_is_stoppable_and_its_handler_returns():
    before = [signal.getsignal(one) for one in query.STOPS]
    with pytest.raises(KeyboardInterrupt), query.stoppable():
        signal.raise_signal(signal.SIGTERM)
    assert [signal.getsignal(one) for one in query.STOPS] == before


def test_a_timed_duel_settles_a_close_choice(monkeypatch):
    choice: Any = SimpleNamespace(runner_up="b", margin=1.01, sentence="a.")
    seen: list[Any] = []
    monkeypatch.setattr(pick, "isolated", lambda *given: nullcontext("call"))
    monkeypatch.setattr(pick.pick, "duel", lambda scene, made, call: ("duel", scene, made, call))
    monkeypatch.setattr(pick.pick, "settled", lambda *given: seen.extend(given) or "settled")
    duel = ("duel", "scene", choice, "call")
    assert pick._confirmed("scene", choice, None) == ("settled", duel)  # type: ignore[arg-type]
    assert seen == [choice, duel]
    assert pick._confirmed("scene", choice, False) == (choice, None)  # type: ignore[arg-type]


@pytest.mark.parametrize("each", [True, False])
def test_tosses_are_those_of_the_folder_by_the_models_given(monkeypatch, each):
    seen: list[Any] = []
    monkeypatch.setattr(tosses, "stored", lambda folder: f"tosses of {folder}")
    monkeypatch.setattr(tosses, "predict", lambda *given: seen.extend(given[:4]) or ["one", "two"])
    monkeypatch.setattr(tosses, "summaries", lambda predicted, random: (predicted, random))
    found = tuple(contact_command._predictions({"m": None}, "f", 0.1, 3, each=each))  # type: ignore[arg-type, dict-item]
    assert seen == ["tosses of f", {"m": None}, 0.1, 3]
    assert found == (("one", "two") if each else (["one", "two"], True))


def test_the_first_scene_that_is_unknown_is_named(monkeypatch):
    monkeypatch.setattr("cross_checks.contact.models", lambda names: ({"m": None}, []))
    monkeypatch.setattr("cross_checks.contact.by_figure.with_contact", lambda: {"known": None})
    words = [word for name in ("known", "first", "second") for word in ("--scene", name)]
    done = CliRunner().invoke(main, ["contact", "--figures", *words, "--stiffness", "1e5", "--mass", "1"])
    assert "no scene here is named 'first'; allowed: known" in done.stderr


@pytest.mark.parametrize("seed", range(2))
def test_the_frontier_of_an_engine_counts_the_scenes_it_is_the_median_of(seed):
    data = irregular(seed)
    figure: Any = overview.frontier_plot(data)
    assert figure["layout"]["yaxis"]["title"]["text"] == "error over the scene's scales"
    for line in figure["data"]:
        engine = line["meta"]["engine"]
        costs = [label for label in data.modelled(engine) if least_time(entries(data, label, MIDDLE)) is not None]
        assert line["name"] == f"median of {count(len(costs), 'scene')}"


@pytest.mark.parametrize("whole", [True, False])
def test_a_proven_truth_is_kept_with_a_certificate_over_the_whole_grid(monkeypatch, whole):
    scene, kept, truth = scenes.make("pendulum"), [], object()
    times = proofs.ladder.grid(scene)[: None if whole else -1]
    row = {"scene": scene.name, "truth": "inside", "reason": ""}
    monkeypatch.setattr(proofs, "need_flint", lambda: None)
    monkeypatch.setattr("cross_checks.truths.proofs.certified.kept", lambda folder: [(scene, times, 1e-9)])
    monkeypatch.setattr("cross_checks.truths.proofs.certified.examine", lambda *given: (row, truth))
    monkeypatch.setattr(proofs.certificate, "stored", lambda made: True)
    monkeypatch.setattr(proofs.stored_poses, "save", lambda *given: kept.append(given))
    assert CliRunner().invoke(main, ["proofs", "--again", "--write", "--json"]).exit_code == 0
    assert kept == ([(scene, times, truth)] if whole else [])
