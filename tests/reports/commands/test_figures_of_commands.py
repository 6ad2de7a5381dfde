"""What commands print and pass on, from made-up records, cells and files in place of runs."""

from __future__ import annotations

import random
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import history
from benchmarks.trees import regression
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import OURS, Cell, TargetResult, Verdict
from cross_checks.records import lines
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from reports import gather
from reports.commands.choose import pick
from reports.commands.engines import doctor
from reports.commands.judge import judge, proofs
from reports.commands.maintenance import compare, nightly
from reports.commands.publish import show
from reports.commands.run import ensemble
from reports.console import Failed, NothingSelected
from reports.facts import compiling
from reports.facts.report_data import Standing
from reports.page import slug
from reports.studies import papers
from tests.reports.page.test_shown_figures import irregular

CHANCE = random.Random(8)


def run_of(error: float | None, **more: Any) -> Record:
    stated = None if error is None else Error(error, "exact", 0.0, None)
    return replace(Record("pendulum", {}, "exudyn", "m", {}, "success", error=stated), **more)


def invoked(command: Any, *words: str) -> Any:
    return CliRunner().invoke(command, list(words))


def test_the_best_so_far_is_named_as_soon_as_one_run_has_an_error(monkeypatch):
    monkeypatch.setattr(pick, "sweep_records", lambda *given, best, **more: best([run_of(1e-3), run_of(None)]))
    monkeypatch.setattr(pick.pick, "basis", lambda records: "basis")
    bounds = pick.Bounds(1e-2, None, None)
    said = str(pick._swept(scenes.make("pendulum"), (), None, bounds, False))
    assert said != "basis"
    assert said.endswith("basis")


@pytest.mark.parametrize(("words", "limit"), [([], None), (["--real-time"], 10.0), (["--budget", "2s"], 2.0),
                                              (["--budget", "2s", "--real-time"], 2.0),
                                              (["--budget", "99s", "--real-time"], 10.0)])  # fmt: skip
def test_a_pick_is_bounded_by_the_budget_and_by_real_time_and_run_afresh_where_requested(monkeypatch, words, limit):
    afresh, seen = run_of(1e-9), []
    choice = SimpleNamespace(best=run_of(1e-9), sentence="chosen", runner_up=None, margin=None)
    monkeypatch.setattr(pick, "_swept", lambda built, chosen, store, bounds, as_json: seen.append(bounds) or [])
    monkeypatch.setattr(pick, "_as_shipped", lambda *given: [])
    monkeypatch.setattr(pick.pick, "pick", lambda *given: choice)
    monkeypatch.setattr(pick, "_afresh", lambda *given: afresh)
    monkeypatch.setattr(pick, "reproduce", lambda *given: "again")
    monkeypatch.setattr(pick, "_check", lambda again, bounds: seen.append(again))
    found = invoked(pick.command, "pendulum", "--error", "1e-6", *words)
    assert found.exit_code == 0, found.output
    assert [bounds.budget for bounds in seen] == [limit]
    assert invoked(pick.command, "pendulum", "--error", "1e-6", "--fresh").exit_code == 0
    assert seen[-1] is afresh


@pytest.mark.parametrize(("status", "error", "ok"), [("success", 1e-9, True), ("success", 1.0, False),
                                                     ("non-finite", 1e-9, False)])  # fmt: skip
def test_a_machine_is_sane_where_a_run_ends_and_is_right(monkeypatch, status, error, ok):
    from cross_checks.judge import one_run

    monkeypatch.setattr(one_run, "evaluate", lambda *given: run_of(error, status=status))
    assert doctor._sanity()["ok"] is ok


def test_a_change_of_level_is_one_of_ratios_and_listed_in_order(monkeypatch):
    """A series at a thousandth of the size has the same changes."""
    monkeypatch.setattr(history, "SHUFFLES", 100)
    rng = np.random.default_rng(2)
    levels = np.repeat([4.0, 1.0, 0.1], 7)
    values = levels * np.exp(0.02 * rng.standard_normal(len(levels)))
    found = history.change_points(values.tolist())
    assert found == sorted(found) == history.change_points((1e-3 * values).tolist())
    assert set(found) == {7, 14}


def test_damaged_data_of_a_report_are_named(tmp_path):
    (tmp_path / "report.json").write_text("{")
    with pytest.raises(NothingSelected, match="holds no report"):
        show.last_report(tmp_path)


def test_an_emptied_cache_is_compiled_again(monkeypatch, tmp_path):
    compiled: list[str] = []
    monkeypatch.setattr(compiling, "recall", lambda *given: True)
    for folder in (tmp_path / "none", tmp_path):
        monkeypatch.setattr(compiling, "cache_folder", lambda folder=folder: folder)
        compiled += map(str, compiling.preparations(None))  # type: ignore[arg-type]
    programs = [engine.name for engine in compiling.engines.installed() if engine.compiles]
    assert compiled == [f"compiling {name}" for name in (*compiling.CORES, *programs)]


def test_a_judged_file_is_held_against_the_other_by_its_own_map_and_until_its_end(monkeypatch, tmp_path):
    from cross_checks.trajectory_files import judgement, library, motion

    assert library.judgement is judgement.judgement  # has its name before that is replaced, whichever test is first
    seen: list[Any] = []
    names = [tmp_path / name for name in ("a.csv", "a.toml", "b.csv", "b.toml")]
    for name in names:
        name.write_text("")
    a, a_map, b, b_map = map(str, names)
    monkeypatch.setattr(motion, "in_common", lambda scene, *given: seen.append((scene.duration, given[0])) or (1, 2))
    monkeypatch.setattr(judgement, "as_truth", lambda *given: (1, 2))
    monkeypatch.setattr(judgement, "judgement", lambda *given: None)
    monkeypatch.setattr(judge, "_answer", lambda *given: None)
    words = [a, "pendulum", "--map", a_map, "--against", b]
    for more in ([], ["--against-map", b_map], ["--t-end", "0.5"]):
        assert invoked(judge.command, *words, *more).exit_code == 0
    assert [files[1] for _, files in seen] == [(names[2], names[1]), (names[2], names[3]), (names[2], names[1])]
    assert [duration for duration, _ in seen] == [10.0, 10.0, 0.5]


def test_proofs_aim_at_a_radius_of_the_scenes_size_and_fail_outside(monkeypatch):
    large = scenes.make("pendulum", length=7.0)
    small = scenes.make("pendulum", length=0.2)
    aims: dict[float, float] = {}

    def examined(made, times, aim, limit, folder):
        aims[scales_of(made).length] = aim
        return {"scene": made.name, "truth": "outside" if made is large else "inside", "reason": ""}, None

    from cross_checks.truths.proofs import certified

    monkeypatch.setattr(certified, "examine", examined)
    monkeypatch.setattr(proofs, "need_flint", lambda: None)
    for covered, code in (([small], False), ([small, large], True)):
        monkeypatch.setattr(proofs, "_covered", lambda covered=covered: covered)
        assert bool(invoked(proofs.command, "--radius", "1e-20", "--json").exit_code) == code
    found = {length: aim / 1e-20 for length, aim in aims.items()}
    assert found == pytest.approx({length: max(1.0, length) for length in found})


def test_a_comparison_takes_every_case_whose_name_holds_the_text(monkeypatch):
    seen: list[str] = []
    monkeypatch.setattr(compare, "findings_of", lambda *given: seen.extend(case.name for case in given[3]) or [])
    monkeypatch.setattr(compare, "end", lambda findings: None)
    name = regression.CASES[-1].name
    invoked(compare.command, "a", "b", "--only", name[2:], "--json")
    assert seen == [case.name for case in regression.CASES if name[2:] in case.name]
    assert name in seen


def test_ends_of_single_runs(monkeypatch):
    """Each row holds the last sample with nine figures, a grid point that failed its status; 60 rows fit."""
    rng, count = np.random.default_rng(4), 61
    scene = scenes.make("pendulum")
    means = rng.normal(size=(count, 5, 3))
    places = [SimpleNamespace(body="rod", name=name, unit="m") for name in ("x", "y", "angle")]
    design = SimpleNamespace(points=rng.normal(size=(count, 1)), grids={"g": 1}, is_random=False)
    made: Any = SimpleNamespace(scene=scene, times=np.array([0.0, 0.7]), statuses=["stopped"] * count, design=design)
    monkeypatch.setattr(ensemble, "coordinates", lambda built: places)
    result: list[Any] = [SimpleNamespace(mean=mean) for mean in means]
    result[3] = None
    rows = list(ensemble._ends(made, result))
    for k, row in enumerate(rows):
        point = f"{made.design.points[k, 0]:.6g}"
        assert row == ((point, "stopped") if k == 3 else (point, "rod", *(f"{x:.9g}" for x in means[k, -1])))
    assert ensemble.end_table(made, result)[1] == len(rows) - 60 == 1


def test_first_places_rank_before_targets_reached(monkeypatch):
    from reports.facts import report_data

    data = irregular(1)
    engines = [engine for engine in data.engines if engine != OURS]
    found = {e: Standing(e, 10 - k, k, {}, 9) for k, e in enumerate((*engines, OURS))}
    monkeypatch.setattr(report_data, "Standing", lambda engine, *rest: found[engine])
    assert [one.engine for one in report_data._standings(data, 1e-3)] == [*reversed(engines), OURS]


@pytest.mark.parametrize("part", [True, False])
def test_a_part_of_a_report_leaves_out_what_comes_last(monkeypatch, part):
    asked: list[str] = []
    stages = [(name, lambda self, data, name=name: asked.append(name) or data) for name in ("a", "b", "last")]
    monkeypatch.setattr(gather, "STAGES", stages)
    monkeypatch.setattr(gather, "stored", dict)
    monkeypatch.setattr(gather, "environment", dict)

    def judged(self, data):
        yield from ()
        return data

    monkeypatch.setattr(gather.Gathering, "judged", judged)
    waits = [there().incomplete for there in gather.Gathering(None, quick=part).stages()]  # type: ignore[arg-type]
    names = ["a", "b", "last"][: 3 - part]
    assert asked == names
    assert waits == [*(f"still being computed: {name}" for name in names), ""]


def test_prices_in_files_leave_out_who_runs_at_no_target():
    from reports.page.files import price_rows

    data = irregular(3)
    never = [Cell("pendulum_chain", {"links": 3}, "strange", "m", Verdict.CANNOT, "no",
                  targets=tuple(TargetResult(t, "cannot", reason="no") for t in TARGETS))]  # fmt: skip
    rows = price_rows(replace(data, cells=(*data.cells, *never)), "pendulum_chain links=3")
    assert {row[1] for row in rows} == {c.engine for c in data.cells}


@pytest.mark.parametrize("settings", [{"rtol": 1e-7, "atol": 3e-9}, {"step": 0.01}, {"rtol": 1e-5}])
def test_the_command_of_a_record_repeats_every_setting_and_parameter(settings):
    record = Record("pendulum_chain", {"links": 7}, "exudyn", "rk4", settings, "success")
    for named in ("", "pendulum_chain"):
        words = slug.command(record, named).split()
        assert words[words.index("-p") + 1] == "links=7"
        given = {word[2:]: float(words[k + 1]) for k, word in enumerate(words) if word[2:] in ("step", "rtol", "atol")}
        assert given == settings
    assert "-p" not in slug.command(record, "own.toml").split()


def test_the_command_of_a_record_repeats_the_parameters_that_its_file_declares(tmp_path):
    file, body = tmp_path / "rods.toml", 'type = "point_mass"\nname = "bob"\nmass = 1.0'
    body = f"[[bodies]]\n{body}\nposition = [0.0, 0.0]\nvelocity = [0.0, 0.0]\n"
    file.write_text(f'name = "rods"\n[parameters.links]\ndefault = 5\n[parameters.size]\ndefault = 1.0\n{body}')
    given = {"links": 7, "size": 1.0, "other": 2.0, "start": "equilibrium", "duration": 0.5}
    record = Record("rods", given, "exudyn", "rk4", {"step": 0.01}, "success")
    words = slug.command(record, str(file)).split()
    repeated = [words[k + 1] for k, word in enumerate(words) if word == "-p"]
    assert repeated == ["links=7", "start=equilibrium", "duration=0.5"]


@pytest.mark.parametrize(("error", "gap", "ends"), [(Error(2e-7, "exact", 3e-7, None), 1e-9, True),
                                                    (Error(2e-6, "exact", 3e-7, None), 1e-9, False),
                                                    (Error(2e-7, "exact", 3e-7, None), 1e-2, False)])  # fmt: skip
def test_a_run_afresh_meets_the_bounds_or_fails(capsys, error, gap, ends):
    again = replace(run_of(1.0), error=error, measures={"compliance_position": gap}, message="it stops")
    bounds = pick.Bounds(1e-6, 1e-3, None)
    stated = f"{error.value + error.uncertainty:.2e}, joints open by {gap:.2e}"
    if ends:
        pick._check(again, bounds)
        assert capsys.readouterr().err == f"run afresh: success, {stated}: the bounds are met\n"
        return
    with pytest.raises(Failed, match="the bounds are not met") as failed:
        pick._check(again, bounds)
    assert failed.value.message == f"run afresh: success, {stated}: the bounds are not met it stops"


def test_changes_of_trends_are_those_of_the_series_in_time(monkeypatch, tmp_path, capsys):
    drawn: list[Any] = []
    entries = [SimpleNamespace(value=v) for v in (1.0, 2.0, 7.0)]
    monkeypatch.setattr(lines, "read", lambda file, kind: (entries, []))
    monkeypatch.setattr(nightly.history, "series", lambda entries: {"one": entries})
    made = {name: history.Entry("j", "2026-03-07", "abc", "box", name, 0.123456, unit) for name, unit in (
        ("chain", "1"), ("track", "s"))}  # fmt: skip
    monkeypatch.setattr(nightly.history, "new_levels", lambda result: made)
    monkeypatch.setattr(nightly.history, "change_points", list)
    monkeypatch.setattr(nightly, "write_trends", lambda result, changes, file: drawn.append(changes))
    nightly._report_history(tmp_path, tmp_path)
    assert capsys.readouterr().out.splitlines() == [
        f"{name}: a new level since 2026-03-07 (abc): 0.1235 {one.unit}" for name, one in made.items()
    ]
    assert drawn == [{"one": [1.0, 2.0, 7.0]}]


def test_each_law_is_about_the_own_value_of_what_it_varies(monkeypatch):
    own = {"a": 2.0, "b": 5.0}
    source: Any = SimpleNamespace(target=lambda name: SimpleNamespace(own=own[name]))
    monkeypatch.setattr(ensemble, "Variants", lambda *given: given)
    monkeypatch.setattr(ensemble.ensembles, "read_law", lambda law, value: (law, value))
    monkeypatch.setattr(ensemble.ensembles, "design", lambda laws, count, seed: laws)
    (_, laws) = ensemble._planned(source, ("a=+-1%", "b=+-2%"), (), None, 0)
    assert laws == {"a": ("+-1%", 2.0), "b": ("+-2%", 5.0)}


def test_coordinates_are_compared_by_places_and_by_time(monkeypatch):
    monkeypatch.setattr(papers, "_loop", lambda scene, coordinates: coordinates)
    monkeypatch.setattr(papers, "simulate", lambda *given: SimpleNamespace(ok=True))
    monkeypatch.setattr(papers, "farthest", lambda scene, *runs: [0.1, 0.2, 0.3, 0.4])
    monkeypatch.setattr(papers, "compare", lambda one, other: SimpleNamespace(ratio=f"{other} over {one}"))
    monkeypatch.setattr(papers, "compile_scene", lambda scene, kind: SimpleNamespace(n_positions=len(kind)))
    found = papers.coordinates()
    for name in papers.RAN["trees"]:
        assert found[f"coordinates.{name}.apart"] == 0.1
        assert found[f"coordinates.{name}.time"] == "relative over cartesian"
        assert (found[f"coordinates.{name}.cartesian"], found[f"coordinates.{name}.relative"]) == (9, 8)
