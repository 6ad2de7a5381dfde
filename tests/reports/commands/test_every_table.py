"""Every table of a command: each cell is the figure of its heading, of the run in its row, and exit codes follow.

Random results stand in for runs, no two figures of which are alike, the worst of them in any row. A few lines here
state what stands under each heading.
"""

from __future__ import annotations

import json
import math
import os
import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import asdict, replace
from datetime import datetime
from types import SimpleNamespace
from typing import Any, NamedTuple

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result

from benchmarks import calibration, history
from benchmarks.calibration import Trial
from benchmarks.history import Entry
from cross_checks import metrics
from cross_checks.conformance import cases, examine, repeatability
from cross_checks.conformance import symmetry as violation
from cross_checks.conformance.finding import Finding, Report, Row
from cross_checks.engine.method import Method
from cross_checks.extremes import named as extreme_named
from cross_checks.extremes import run as extreme_runs
from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.extremes.fate import Fate, Point
from cross_checks.judge import one_run, runs
from cross_checks.judge.answers import Answer
from cross_checks.judge.capabilities import Capability
from cross_checks.judge.vocabulary import ANSWERS, MEANINGS, OURS, Cell, Omitted, TargetResult, Verdict
from cross_checks.metrics.errors import COMPONENTS
from cross_checks.prices import pick as picking
from cross_checks.records import lines
from cross_checks.records.numbers import setting
from cross_checks.records.record import BUSY_NOTE, CANNOT, MISSING, Error, Record
from cross_checks.records.store import code_of
from cross_checks.robots.parity import Difference, Parity
from cross_checks.trajectory_files.judgement import Judgement
from cross_checks.truths.certificate import Certificate
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.scene.traits import PART_TYPES
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import stiffness_at_start
from mbs_ref.trajectory import Status, Trajectory
from reports import console
from reports.cli import main
from reports.commands.choose import sweep
from reports.commands.engines import doctor
from reports.commands.engines import engines as engines_command
from reports.commands.explore import extremes as extremes_command
from reports.commands.explore import parity as parity_command
from reports.commands.judge import certify, check, judge, proofs
from reports.commands.publish import rerun, show
from reports.page import build
from reports.page.sections.prices import cannot, price_table
from reports.poses_file import write_poses
from tests.reports.page.test_shown_figures import irregular

Spec = list[tuple[str, Callable[[Any], object]]]  # of a table: heading, and what stands below it in the row of an item
SEEDS = range(3)


class Table(NamedTuple):
    """A table that was printed."""

    title: str
    head: list[str]
    rows: list[list[str]]


@pytest.fixture
def tables(monkeypatch) -> list[Table]:
    """Return the tables that commands print from now on."""
    seen: list[Table] = []

    class Printer:
        def __init__(self, **given: Any) -> None: ...

        def print(self, what: Any) -> None:
            columns = [list(column.cells) for column in what.columns]
            rows = [list(map(str, row)) for row in zip(*columns, strict=True)]
            seen.append(Table(str(what.title).strip(), [str(column.header) for column in what.columns], rows))

    monkeypatch.setattr(console, "Console", Printer)
    return seen


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


def json_of(code: int, *words: str) -> Any:
    """Return what a command prints as JSON, which is JSON alone whatever its exit code."""
    done = run(*words, "--json")
    assert done.exit_code == code
    return json.loads(done.stdout)


def g(value: float | None) -> str:
    """Return a number as every table shows it."""
    return "-" if value is None else f"{value:.3g}"


def holds(table: Table, items: Iterable[Any], spec: Spec) -> None:
    """Assert that a table has a row for each item, in their order, and in it what the headings say."""
    assert table.head == [heading for heading, _ in spec]
    assert table.rows == [[str(of(item)) for _, of in spec] for item in items]


def keyed(*headings: tuple[str, str], form: Callable[[Any], object] = g) -> Spec:
    """Return columns whose figures are those of a dict, by heading and key."""
    return [(heading, lambda row, key=key: form(row[key])) for heading, key in headings]


def size(chance: random.Random) -> float:
    return 10 ** chance.uniform(-9, 3)


def record(chance: random.Random, **more: Any) -> Record:
    """Return a run whose figures have no pattern; one in five has no error."""
    error = Error(size(chance), "exact: by hand", size(chance), size(chance), f"position of rod {chance.random():.2f}",
                  size(chance), size(chance)) if chance.random() < 0.8 else None  # fmt: skip
    times = {key: size(chance) for key in ("build_s", "first_call_s", "loop_s", "loop_median_s", "loop_most_s")}
    made = Record(
        "pendulum", dict(scenes.make("pendulum").parameters), chance.choice((OURS, "exudyn", "mujoco")),
        chance.choice(("rk4", "euler", "dop853")), {chance.choice(("step", "rtol")): size(chance)},
        chance.choice(("success", "non-finite")), error=error, t_end=size(chance), steps=chance.randrange(10**6),
        rhs_calls=chance.randrange(10**6), measures={name: size(chance) for name in metrics.every()}, times=times,
    )  # fmt: skip
    return replace(made, **more)


def cell(chance: random.Random, verdict: Verdict, method: str, links: int) -> Cell:
    """Return a cell of every kind of figure and answer; of `links` links."""
    targets = []
    for target, answer in zip((1e-3, 1e-6, 1e-9), chance.sample(list(ANSWERS), 3), strict=True):
        low, high = sorted((size(chance), size(chance)))
        omitted = Omitted(size(chance), size(chance), 0.5, size(chance), (low, high), size(chance))
        reached = record(chance, error=Error(size(chance), "exact", 0.0, None)) if answer == "reached" else None
        is_left = answer == "not-tried"
        targets.append(TargetResult(target, answer, reached, f"why {target:g}", omitted if is_left else None))
    return Cell("pendulum_chain", {"links": links}, chance.choice(("exudyn", "mujoco")), method, verdict,
                f"because of {method}", error=size(chance), compliance=size(chance), order=chance.uniform(0.5, 5.0),
                documented_order=chance.randint(1, 5), contact={f"depth {method}": size(chance)},
                targets=tuple(targets), truth="exact",
                runs=tuple({"setting": f"step={size(chance):.3g}", "status": chance.choice(("success", "failed")),
                            "error": size(chance)} for _ in range(3)))  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_sweep(monkeypatch, tables, seed):
    chance = random.Random(seed)
    made = [record(chance) for _ in range(7)]
    monkeypatch.setattr(sweep, "sweep_records", lambda *given, **more: made)
    assert run("sweep", "pendulum").exit_code == 0
    holds(tables[0], made, [
        ("engine", lambda r: r.engine), ("method", lambda r: r.method), ("setting", lambda r: setting(r.settings)),
        ("status", lambda r: r.status), ("error", lambda r: g(r.error.value if r.error else None)),
        ("compliance", lambda r: g(r.measures["compliance_position"])), ("loop, s", lambda r: g(r.times["loop_s"])),
    ])  # fmt: skip
    assert run("sweep", "pendulum").stdout == ""  # but the table
    printed = run("sweep", "pendulum", "--json").stdout.splitlines()
    assert [lines.adapter(Record).validate_python(json.loads(line)) for line in printed] == made


def checked(monkeypatch, made: list[Cell], settled: Sequence[bool] = ()) -> Result:
    """Check a pendulum, where the cells are made up; interrupted after those of which it is said whether settled."""

    def answers(given: Any, wanted: Any, progress: Any) -> Iterator[Answer]:
        for question, one, is_settled in zip(wanted, made, settled or [True] * len(made), strict=False):
            yield Answer(question, one, (), NoTruth("none"), is_settled)
        if settled:
            raise KeyboardInterrupt

    monkeypatch.setattr(check, "tasks", lambda names: [("exudyn", None)] * len(made))
    monkeypatch.setattr(check.inputs, "engine_names", lambda chosen: ["exudyn"])
    monkeypatch.setattr(check, "open_runs", lambda *given, **more: nullcontext(runs.Runs()))
    monkeypatch.setattr(check, "answers", answers)
    return run("check", "pendulum")


@pytest.mark.parametrize("seed", SEEDS)
def test_check(monkeypatch, tables, seed):
    chance = random.Random(seed)
    verdicts = [*Verdict, *Verdict]
    chance.shuffle(verdicts)
    made = [replace(cell(chance, v, f"m{k}", k), exemption=chance.choice(("", "soft"))) for k, v in enumerate(verdicts)]
    assert checked(monkeypatch, made).exit_code == 1
    ran = [c for c in made if c.verdict not in (Verdict.CANNOT, Verdict.ENGINE_MISSING)]
    about: Spec = [("scene", lambda c: f"pendulum_chain links={c.parameters['links']}"), ("engine", lambda c: c.engine),
                   ("method", lambda c: c.method)]  # fmt: skip
    table, refused, left, contact = tables
    holds(table, ran, [
        *about, ("verdict", lambda c: f"{c.verdict} {MEANINGS[c.verdict].code}"), ("error", lambda c: g(c.error)),
        ("compliance", lambda c: g(c.compliance)), ("order", lambda c: g(c.order)),
        ("reason", lambda c: f"{c.reason} (documented: soft)" if c.exemption else c.reason),
    ])  # fmt: skip
    others = [c for c in made if c not in ran]
    assert sorted(row[-1] for row in refused.rows) == sorted(c.reason for c in others)
    every = [(c, t) for c in made for t in c.targets if t.answer == "not-tried"]
    holds(left, every, [
        *((heading, lambda one, of=of: of(one[0])) for heading, of in about), ("target", lambda one: g(one[1].target)),
        ("what a run would take and show", lambda one: str(one[1].omitted)),
    ])  # fmt: skip
    holds(contact, made, [*about, ("figures", lambda c: "; ".join(f"{k} {g(x)}" for k, x in c.contact.items()))])


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize(("verdict", "exemption", "code"), [("lost", "", 1), ("lost", "soft", 0), ("agrees", "", 0)])
def test_one_wrong_cell_anywhere_fails_a_check(monkeypatch, place, verdict, exemption, code):
    chance = random.Random(1)
    made = [cell(chance, Verdict.CONVERGING, f"m{k}", k) for k in range(3)]
    made[place] = replace(made[place], verdict=Verdict(verdict), exemption=exemption)
    assert checked(monkeypatch, made).exit_code == code


@pytest.mark.parametrize("settled", [(True, False), (False, False, False), (True, False, True), (True,) * 4])
def test_an_interrupted_check_counts_the_cells_that_are_settled(monkeypatch, settled):
    made = [cell(random.Random(k), Verdict.LOST, f"m{k}", k) for k in range(5)]
    done = checked(monkeypatch, made, settled)
    assert done.exit_code == 4
    assert f"interrupted after {sum(settled)} of {len(made)} cells" in done.stderr


def test_rerun(monkeypatch, tables):
    one = cell(random.Random(4), Verdict.CONVERGING, "rk4", 3)
    monkeypatch.setattr(rerun, "truth_of", lambda *given: NoTruth(""))
    monkeypatch.setattr(rerun, "judged", lambda *given: (one, ()))
    assert run("rerun", "pendulum/mbs_ref/rk4").exit_code == 0
    monkeypatch.setattr(rerun, "judged", lambda *given: (replace(one, verdict=Verdict.LOST), ()))
    assert run("rerun", "pendulum/mbs_ref/rk4").exit_code == 1
    assert f"{one.verdict} {one.code}, {one.reason}" in tables[0].title
    holds(tables[0], one.runs, [*keyed(("setting", "setting"), ("status", "status"), form=str), *keyed(("error",) * 2)])
    holds(tables[1], one.targets, [
        ("target", lambda t: f"{t.target:g}"), ("answer", lambda t: t.answer),
        ("setting or reason", lambda t: setting(t.record.settings) if t.record else t.reason),
        ("loop, s", lambda t: g(t.record.times["loop_s"] if t.record else None)),
    ])  # fmt: skip


def facts(table: Table) -> dict[str, str]:
    """Return a table of two columns as a dict."""
    return {row[0]: row[1] for row in table.rows}


@pytest.mark.parametrize("seed", SEEDS)
def test_simulate(monkeypatch, tables, seed):
    chance, rng = random.Random(seed), np.random.default_rng(seed)
    scene, n = scenes.make("double_pendulum"), 5
    path = Trajectory(np.linspace(0.0, 1.0, n), *(rng.normal(size=(n, 2, *s)) for s in ((2,), (), (2,), ())))
    names = list(metrics.every())
    unknown, hidden = chance.sample(names, 2)
    final = {name: {"position": [size(chance), size(chance)], "angle": size(chance), "velocity": [size(chance)] * 2}
             for name in scene.body_names}  # fmt: skip
    estimate = {"value": size(chance), "unit": "of the scene", "how": "twice", "cost_s": size(chance)}
    made = record(
        chance,
        status="success",
        final=final,
        contact={"floor: depth, m": size(chance)},
        estimate=estimate,
        events={"hit": [size(chance) for _ in range(14)], "miss": []},
        bounds={unknown: size(chance)},
    )
    made = replace(made, measures=made.measures | {unknown: None, hidden: None}, notes=("known before",))
    errors = {one.name: size(chance) for one in COMPONENTS}
    error = Error(size(chance), "exact: by hand", size(chance), None, "velocity of lower", size(chance))
    curve = [0.0, *(size(chance) for _ in range(n - 1))]
    after = replace(made, error=error, notes=(*made.notes, "a note"), measures=made.measures | errors, bounds={},
                    history={"error": curve})  # fmt: skip
    monkeypatch.setattr(one_run, "judged_run", lambda *given, **more: (made, path))
    monkeypatch.setattr(runs, "against", lambda scene, given, truth: after)
    monkeypatch.setattr(runs.Runs, "truth", lambda *given: NoTruth("none"))
    done = run("simulate", "double_pendulum", "--plot")
    assert done.exit_code == 0, done.output
    own, ends, truth = tables
    labels = {one.label: (name, one.unit) for name, one in metrics.every().items()}
    shown = facts(own)
    assert shown["reached"] == f"{made.t_end:g} s in {made.steps} steps, {made.rhs_calls} right-hand sides"
    assert shown["estimated error"] == f"{g(estimate['value'])} of the scene: twice; it took {g(estimate['cost_s'])} s"
    for label, (name, unit) in labels.items():
        value, below = made.measures[name], made.bounds.get(name)
        known = f"{g(value)} {unit}" if value is not None else f"below {g(below)} {unit}"
        assert shown.get(label) == (None if value is below is None else known)
    assert shown["times"] == ", ".join(f"{key} {g(value)}" for key, value in made.times.items())
    assert shown["floor: depth, m"] == g(made.contact["floor: depth, m"])
    assert shown["event hit"].startswith("14: ")
    assert [float(x) for x in shown["event hit"][4:-2].split(", ")] == pytest.approx(made.events["hit"][:12], rel=1e-14)
    assert shown["event miss"] == "never"
    for row, (name, state) in zip(ends.rows, final.items(), strict=True):
        numbers = [[float(x) for x in text.split(", ")] for text in row[1:]]
        assert row[0] == name
        for text, number in zip(numbers, (state["position"], [state["angle"]], state["velocity"]), strict=True):
            assert text == pytest.approx(number, rel=1e-14)
    shown = facts(truth)
    is_known = error.value > error.uncertainty
    off = g(error.value) if is_known else f"below {g(error.value + error.uncertainty)}"
    assert shown["error"] == f"{off} of the scene (velocity of lower)"
    known = f"known to {g(error.uncertainty)} of the scene, whose length is {g(error.length)} m"
    assert shown["truth"] == f"exact: by hand, {known}"
    assert {one.label: shown[one.label] for one in COMPONENTS} == {
        one.label: f"{g(errors[one.name])} {one.unit}" for one in COMPONENTS}  # fmt: skip
    assert [[row[1] for row in table.rows if row[0] == "note"] for table in (own, truth)] == [
        ["known before"], ["a note"]]  # fmt: skip
    plots = done.stdout.split("position, m")[1].split("error over the scene's scales")
    places = path.position[:, -1]
    assert [text.split("|")[0].strip() for text in plots[0].splitlines() if "|" in text][:: 15] == [
        g(places.max()), g(places.min())]  # fmt: skip
    assert plots[0].rstrip().endswith(f"o x of {scene.body_names[-1]}   x y of {scene.body_names[-1]}")
    assert [text.split("|")[0].strip() for text in plots[1].splitlines() if "|" in text][:: 15] == [
        g(max(curve[1:])), g(min(curve[1:]))]  # fmt: skip


STATUSES = (*map(str, Status), CANNOT, MISSING, "crashed", "timeout", "out-of-memory")


@pytest.mark.parametrize("status", STATUSES)
def test_every_status_of_a_run_has_its_exit_code_and_what_succeeds_or_is_interrupted_is_written(
    monkeypatch, tmp_path, status
):
    made = record(random.Random(1), status=status, message="as it is")
    path = Trajectory(np.arange(2.0), *(np.zeros((2, 1, *shape)) for shape in ((2,), (), (2,), ())))
    code = {"success": 0, "stop-event": 0, "engine-missing": 3, "interrupted": 4, "out-of-memory": 4}.get(status, 1)
    for form, came in (([], path), (["--json"], None)):
        file = tmp_path / f"run{len(form)}.csv"
        monkeypatch.setattr(one_run, "judged_run", lambda *given, came=came, **more: (made, came))
        assert run("simulate", "pendulum", "--no-truth", "-o", str(file), *form).exit_code == code
        assert file.exists() == (came is path and (code == 0 or status == "interrupted"))


@pytest.mark.parametrize("name", ["spring_pendulum", "sliding_block", "android_simplified"])
def test_inspect(tables, name):
    scene = scenes.make(name)
    printed = json.loads(run("inspect", name, "--json").stdout)
    speed = printed["impact_speed_m_s"]
    found = stiffness_at_start(scene, speed)
    modes = sorted(found.modes, key=abs, reverse=True)[:6]
    shown = [complex(*pair) for pair in printed["eigenvalues_1_s"]]
    assert [abs(one) for one in shown] == pytest.approx([abs(one) for one in modes])
    assert all(min(abs(one - other) for other in found.modes) <= 1e-9 * abs(one) for one in shown)
    assert printed["fastest_1_s"] == pytest.approx(max(map(abs, found.modes), default=0.0))
    assert printed["fastest_decay_1_s"] == pytest.approx(max(0.0, *(-found.modes.real)))
    for key, rule in (("rule_1_over_omega_s", found.oscillation_rule), ("rule_m_over_c_s", found.damping_rule)):
        assert printed[key] == (rule if math.isfinite(rule) else None)
    explicit = {one: method.stability for one, method in integrators().items() if method.stability}
    for steps, of in ((printed["largest_step_s"], found), *(
        (one["largest_step_s"], found.of_contact(k)) for k, one in enumerate(printed["closed_contacts"]))):  # fmt: skip
        limits = {one: of.step_limit(stability) for one, stability in explicit.items()}
        assert steps == {one: limit if limit < scene.duration else None for one, limit in limits.items()}
    assert [one["stiffness_N_m"] for one in printed["closed_contacts"]] == pytest.approx(found.contact_slopes)
    assert run("inspect", name).exit_code == 0
    text = facts(tables[-1])
    assert text["fastest_1_s"] == g(printed["fastest_1_s"])
    limits = printed["largest_step_s"].items()
    assert text["largest_step_s"] == ", ".join(
        f"{one} {'not limited by stability' if limit is None else g(limit)}" for one, limit in limits)  # fmt: skip
    assert (tables[-1].title, tables[-1].head) == (f"{name} at t = 0", ["quantity", "value"])
    counted = [row for row in tables[-1].rows if row[0].endswith(", closed")]
    assert all(("contacts" in row[0]) == (row[0].split()[0] != "1") for row in counted)
    assert sum(int(row[0].split()[0]) for row in counted) == len(printed["closed_contacts"])
    assert all(f"(impact at {g(speed)} m/s)" in said or "impulses" in said for _, said in counted)


def test_ensemble(tmp_path, tables):
    """The figures at the end, from the samples that -o writes: two points of a grid, nine runs at each."""
    words = ("double_pendulum", "--vary", "angle_2=+-5%", "--vary", "gravity.y=-2:-1:2", "-n", "9", "--t-end", "0.2",
             "--samples", "3", "--threads", "1")  # fmt: skip
    assert run("ensemble", *words, "-o", str(tmp_path / "a.npz")).exit_code == 0
    assert run("ensemble", *words, "-o", str(tmp_path / "a.csv")).exit_code == 0
    with np.load(tmp_path / "a.npz") as file:
        arrays = dict(file)
    varied = arrays["inputs"].tolist()
    expected = []
    for gravity in np.unique(arrays["values"][:, varied.index("gravity.y")]):
        own = arrays["values"][:, varied.index("gravity.y")] == gravity
        for k, body in enumerate(arrays["bodies"]):
            for name, unit, column in (("x", "m", arrays["position"][..., 0]), ("y", "m", arrays["position"][..., 1]),
                                       ("angle", "rad", arrays["orientation"])):  # fmt: skip
                x = column[own][:, -1, k]
                n, s = len(x), np.std(x, ddof=1)
                spread = math.sqrt((np.mean((x - x.mean()) ** 4) - s**4 * (n - 3) / (n - 1)) / n) / (2.0 * s)
                row = x.mean(), s / math.sqrt(n - 1), s, spread, *np.quantile(x, (0.05, 0.5, 0.95)), x.min(), x.max()
                expected.append(([f"{gravity:.6g}", str(body), f"{name}, {unit}"], row))
    table = tables[0]
    assert table.head == ["gravity.y", "body", "", "mean", "std. error", "std. deviation", "std. error", "5 %",
                          "median", "95 %", "smallest", "largest"]  # fmt: skip
    assert "0.2 s" in table.title
    for row, (about, figures) in zip(table.rows, expected, strict=True):
        assert row[:3] == about
        assert [float(x) for x in row[3:]] == pytest.approx(figures, rel=6e-3, abs=1e-12)
        assert float(row[3]) == pytest.approx(figures[0], abs=0.01 * figures[2])  # the spread is seen in its digits
    rows = [line.split(",") for line in (tmp_path / "a.csv").read_text().splitlines()]
    columns = dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))
    count = len(arrays["times"])
    runs_of = [k for k in range(len(arrays["status"])) for _ in range(count)]
    assert [int(x) for x in columns["run"]] == runs_of
    assert [float(x) for x in columns["t"]] == [*arrays["times"]] * len(arrays["status"])
    for k, name in enumerate(varied):
        assert [float(x) for x in columns[f"vary {name}"]] == arrays["values"][runs_of, k].tolist()
    assert [float(x) for x in columns["lower.vy"]] == arrays["velocity"][:, :, 1, 1].ravel().tolist()


def point(chance: random.Random, value: float) -> Point:
    return Point(value, chance.choice(list(Fate)[:4]), chance.random(), chance.random() < 0.5, size(chance),
                 chance.choice(("success", "reset")), f"reason {chance.random():.6f} of many words" * 3)  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_extremes(monkeypatch, tables, tmp_path, seed):
    """The file holds cells of full and of quick searches, of more engines and extremes than are asked for."""
    chance, made = random.Random(seed), []
    names = ("stiff-spring-quiet", "crash-pulse", "overflow")
    axes = {name: extreme_named(name).axis for name in names}
    families = {name: extreme_named(name).family for name in names}
    for name in names:
        for engine in ("mujoco", OURS, "exudyn"):
            for full in (True, False):
                values = axes[name].values
                right = chance.choice((None, *values))
                fate = chance.choice([fate for fate in Fate if (engine, fate) != (OURS, Fate.SILENTLY_WRONG)])
                points = tuple(point(chance, value) for value in values)
                made.append(ExtremeCell(name, families[name], engine, f"m{len(made)}", full, fate, right, points,
                                        f"why {len(made)} " * 20))  # fmt: skip
    lines.append(tmp_path / "cells.jsonl", made)
    monkeypatch.setattr(extreme_runs, "matrix", lambda *given, **more: ())
    words = ("extremes", "-o", str(tmp_path / "cells.jsonl"), "--engine", "mbs_ref", "--engine", "mujoco")
    for full in (False, True):
        for name in names[:2]:
            tables.clear()
            done = run(*words, "--only", name, *(["--full"] if full else []))
            assert done.exit_code == 0, done.output
            own = [c for c in made if (c.extreme, c.full) == (name, full) and c.engine != "exudyn"]
            ran = sorted((c for c in own if c.fate != "cannot"), key=lambda c: (c.engine != OURS, c.engine, c.method))
            axis = axes[name]

            def last(c: ExtremeCell, axis: Any = axis) -> str:
                unit = "" if axis.labels else axis.unit
                return "-" if c.last is None else f"{axis.name} {axis.label(c.last)} {unit}".strip()

            holds(tables[0], ran, [
                ("extreme", lambda c: c.extreme), ("engine", lambda c: c.engine), ("method", lambda c: c.method),
                ("fate", lambda c: c.fate), ("all right up to", last),
                ("what came first beyond", lambda c: c.reason[:90]),
            ])  # fmt: skip
            for fate in Fate:
                assert f"{fate} {sum(c.fate is fate for c in own)}" in done.stdout
            caught = sum(
                p.is_silent and p.fate == "silently-wrong" and p.status == "reset" for c in own for p in c.points
            )
            assert done.stdout.rstrip().endswith(f"detected: {caught}")
            printed = run(*words, "--only", name, "--json", *(["--full"] if full else [])).stdout.splitlines()
            assert [json.loads(line)["method"] for line in printed] == [c.method for c in own]
    wrong = replace(made[chance.randrange(2, 4)], fate=Fate.SILENTLY_WRONG)  # ours
    lines.append(tmp_path / "cells.jsonl", [wrong])
    assert run(*words, "--only", wrong.extreme, *(["--full"] if wrong.full else [])).exit_code == 1
    assert run(*words, "--only", wrong.extreme, *([] if wrong.full else ["--full"])).exit_code == 0


def test_new_cells_of_the_extremes_state_the_day_and_the_revision(monkeypatch, tmp_path):
    """The file has every cell once; the day is that of the command's start."""
    noon = SimpleNamespace(now=lambda zone: datetime(2026, 3, 7, 12, tzinfo=zone))
    fresh = ExtremeCell("overflow", "family", "exudyn", "rk4", False, Fate.STOPPED, None, (), "why")
    monkeypatch.setattr(extremes_command, "datetime", noon)
    monkeypatch.setattr("reports.facts.environment.commit", lambda: "abc")
    monkeypatch.setattr(extreme_runs, "matrix", lambda *given, **more: [fresh])
    file = tmp_path / "cells.jsonl"
    assert run("extremes", "--only", "overflow", "-o", str(file), "--engine", "exudyn").exit_code == 0
    assert lines.read(file, ExtremeCell) == ([replace(fresh, made="2026-03-07, revision abc")], [])


def faked(monkeypatch, count: int) -> list[Any]:
    """Let there be so many cases of symmetry and repeatability."""
    made = [SimpleNamespace(name=f"case {k}", engine="e") for k in range(count)]
    monkeypatch.setattr(cases, "cases", lambda *given: made)
    return made


@pytest.mark.parametrize(("place", "engine", "code"), [(0, OURS, 1), (2, OURS, 1), (1, "exudyn", 0)])
def test_symmetry(monkeypatch, tables, place, engine, code):
    chance, made = random.Random(place), []
    for k in range(3):
        broken = [{"symmetry": f"s{j}", "size": size(chance), "noise": size(chance), "error": size(chance),
                   "exceeds_error": k == place and j == 1} for j in range(3)]  # fmt: skip
        made.append(
            {
                "engine": engine if k == place else "drake",
                "method": f"m{k % 2}",
                "scene": f"scene {k}",
                "judged": chance.randrange(100),
                "broken": broken,
                "stopped": "ended" if k == 1 else "",
            }
        )
    made.append({"engine": "drake", "method": "whole", "scene": "s", "judged": 9, "broken": [], "stopped": ""})
    given = iter(made * 3)
    faked(monkeypatch, 4)
    monkeypatch.setattr(violation, "isolated", lambda case, call: next(given))
    assert run("symmetry").exit_code == code
    headings = (("engine", "engine"), ("method", "method"), ("scenes", "cases"), ("not finished", "stopped"),
                ("judged", "judged"), ("beyond roundoff", "broken"), ("beyond its error", "beyond_error"))  # fmt: skip
    holds(tables[0], violation.by_method(made), keyed(*headings, form=str))
    expected = []
    for one in made:
        about = [one["engine"], one["method"], one["scene"]]
        for each in one["broken"]:
            figures = {"by, m": "size", "roundoff, m": "noise", "error, m": "error"}
            expected.append([*about, each["symmetry"], *(f"{each[key]:.1e}" for key in figures.values())])
        expected += [[*about, one["stopped"], "", "", ""]] if one["stopped"] else []
    assert tables[1].head == ["engine", "method", "scene", "symmetry", "by, m", "roundoff, m", "error, m"]
    assert tables[1].rows == expected
    assert json_of(code, "symmetry")["cases"] == made
    for each in made[place]["broken"]:
        each["exceeds_error"] = False
    assert run("symmetry").exit_code == 0, "what the method's own error explains is a finding"


@pytest.mark.parametrize("place", range(3))
def test_repeatability(monkeypatch, tables, tmp_path, place):
    chance, made = random.Random(place), []
    for k in range(3):
        sizes = [chance.choice((0.0, size(chance), None)) for _ in repeatability.WAYS]
        made.append({"engine": "e", "method": f"m{k % 2}", "scene": f"s{k}", "setting": "", "stopped": "",
                     "differs": dict(zip(repeatability.WAYS, sizes, strict=True))})  # fmt: skip
    faked(monkeypatch, 3)
    monkeypatch.setattr(repeatability, "measured", lambda *given: made)
    assert run("repeatability").exit_code == 0
    rows = []
    for method in ("m0", "m1"):
        own = [one["differs"] for one in made if one["method"] == method]
        texts = []
        for way in repeatability.WAYS:
            differ = [one[way] for one in own if one[way] != 0.0]
            ended = f", {differ.count(None)} end otherwise" if None in differ else ""
            largest = max((x for x in differ if x is not None), default=0.0)
            texts.append(f"{len(differ)}: {largest:.1e}{ended}" if differ else "-")
        rows.append(["e", method, str(len(own)), *texts])
    assert tables[0].head == ["engine", "method", "runs", *repeatability.WAYS]
    assert tables[0].rows == rows
    # None stands for another end, which is no less than other bits
    for engine, way, size_of, code in ((OURS, "another order", 1e-16, 1), (OURS, "two threads", 1e-16, 0),
                                       ("exudyn", "at once", 1e-16, 0), (OURS, "another process", None, 1),
                                       (OURS, "two threads", None, 0)):  # fmt: skip
        made[place] |= {"engine": engine, "differs": dict.fromkeys(repeatability.WAYS, 0.0) | {way: size_of}}
        assert run("repeatability").exit_code == code
        printed = json_of(code, "repeatability", "--table", str(tmp_path / "table.json"))
        assert printed == json.loads((tmp_path / "table.json").read_text()) | {"runs": made}


def test_parity(monkeypatch, tables, tmp_path):
    chance, file = random.Random(6), tmp_path / "arm.urdf"
    file.write_text("")
    apart = {name: {key: size(chance) for key in ("mass", "gravity", "bias")} for name in ("b", "c")}
    del apart["c"]["bias"]
    result = Parity(("j1", "j2"), ("a", "b", "c"), {"d": "not installed"}, apart, ())
    found: list[Parity] = [result]
    monkeypatch.setattr(parity_command, "parity", lambda *given: found[0])
    assert run("parity", str(file)).exit_code == 0
    assert tables[0].head == ["reader", "mass matrix", "gravity", "bias"]
    figures = [[name, *(g(apart[name].get(key)) for key in ("mass", "gravity", "bias"))] for name in ("b", "c")]
    assert tables[0].rows == [["a", "compared with", "", ""], *figures, ["d", "refuses: not installed", "", ""]]
    found[0] = result._replace(differences=(Difference("b", "a", "mass", 0.1, ("j1", "j2"), 1.25, 3.75),))
    done = run("parity", str(file))
    assert done.exit_code == 1
    assert "mass at 'j1' and 'j2' is 1.25 in b and 3.75 in a" in done.stderr
    assert json_of(1, "parity", str(file))["differences"] == [
        found[0].differences[0]._asdict() | {"joints": ["j1", "j2"]}
    ]
    found[0] = result._replace(read=("a",), apart={})
    assert run("parity", str(file)).exit_code == 5
    assert json_of(5, "parity", str(file))["read"] == ["a"]


def trial(chance: random.Random, method: str, over: float) -> Trial:
    error = size(chance)
    return Trial(chance.randrange(999), f"scene {chance.random():.3f}", method, f"step {size(chance):.3g}", "success",
                 over * error, error, 1e-9 * error, size(chance), code_of(calibration.__name__))  # fmt: skip


@pytest.mark.parametrize(("below", "over", "code"), [(0, 3.0, 0), (9, 3.0, 1), (0, 20.0, 1), (1, 3.0, 0)])
def test_calibrate(monkeypatch, tables, below, over, code):
    """All runs decide, and not those of the last method; an estimate too small is listed with its run."""
    chance = random.Random(below)
    made = [trial(chance, chance.choice("xy"), over * chance.uniform(0.9, 1.1)) for _ in range(200 - below)]
    made += [trial(chance, "x", 0.5) for _ in range(below)]
    chance.shuffle(made)
    made += [trial(chance, "z", 3.0) for _ in range(2)]  # the last method has no fault
    given = iter(made)
    monkeypatch.setattr(calibration, "trial", lambda seed, among: next(given))
    assert run("calibrate", "-n", str(len(made))).exit_code == code
    rows = []
    for method in ("all", "x", "y", "z"):
        own = [one for one in made if method in ("all", one.method)]
        ratios = [one.estimate / one.error for one in own if one.estimate and one.error]
        quantiles = np.percentile(ratios, (1.0, 50.0, 90.0)).tolist()
        cost = float(np.median([one.cost for one in own if one.cost]))
        rows.append(
            [method, str(len(own)), str(len(own)), str(sum(x < 1.0 for x in ratios)), *map(g, (*quantiles, cost))]
        )
    assert tables[0].head == ["method", "runs", "judged", "above their estimate", "1 % have less", "median",
                              "90 % have less", "cost, loops"]  # fmt: skip
    assert tables[0].rows == rows
    if below:
        holds(tables[1], [one for one in made if one.method == "x" and (one.estimate or 0.0) < (one.error or 0.0)], [
            ("seed", lambda t: t.seed), ("scene", lambda t: t.scene), ("method", lambda t: t.method),
            ("setting", lambda t: t.setting), ("error", lambda t: g(t.error)), ("estimate", lambda t: g(t.estimate)),
        ])  # fmt: skip


def test_compare_files(tables, tmp_path):
    """Runs of both files, of one alone, and of every move; the last of a run counts."""
    chance = random.Random(3)
    old = [record(chance, settings={"step": size(chance)}, status="success", error=Error(1e-6, "exact", 0.0, None))
           for _ in range(9)]  # fmt: skip
    factor = (5.0, 1.0, 0.1, 1.5, 3.0)
    new = [replace(r, error=replace(r.error, value=f * 1e-6), times={"loop_s": size(chance)})
           for r, f in zip(old[:5], factor, strict=True) if r.error]  # fmt: skip
    extra = [replace(r, method="other") for r in old[:2]]
    for name, own in (("a", old), ("b", [*new, *extra])):
        lines.append(tmp_path / f"{name}.jsonl", own)
    files = [str(tmp_path / f"{name}.jsonl") for name in "ab"]
    done = run("compare", *files)
    assert done.exit_code == 1
    moves = ["worse", "same", "better", "same", "worse"]
    ratios = [b.times["loop_s"] / a.times["loop_s"] for a, b in zip(old, new, strict=False)]
    changed = [
        (a, b, move, ratio) for a, b, move, ratio in zip(old, new, moves, ratios, strict=False) if move != "same"
    ]
    assert [row[1:] for row in tables[0].rows] == [
        [move, f"error {1e-6:.2e}, then {b.error.value:.2e} of the scene", g(ratio)] for _, b, move, ratio in changed
    ]
    assert [row[0].split()[-3:-1] for row in tables[0].rows] == [[a.engine, a.method] for a, *_ in changed]
    assert "5 runs in both: 2 worse, 0 not measured, 1 better, 2 same. 4 only in A, 2 only in B." in done.stdout
    assert f"B/A, is {g(float(np.median(ratios)))};" in done.stdout
    printed = json.loads(run("compare", *files, "--json").stdout)
    assert (printed["verdict"], printed["only_in_a"], printed["only_in_b"]) == ("worse", 4, 2)
    assert printed["median_time_ratio"] == float(np.median(ratios))
    assert [(one["move"], one["ratio"]) for one in printed["runs"]] == list(zip(moves, ratios, strict=True))
    for text in {one.method for one in new}:
        named = json.loads(run("compare", *files, "--only", text, "--json").stdout)["runs"]
        assert named == [one for one in printed["runs"] if text in one["run"].split()]
    assert run("compare", *files, "--only", "no such run").exit_code == 5
    assert run("compare", files[0], files[0]).exit_code == 0
    assert "0 worse, 0 not measured, 0 better, 9 same" in run("compare", files[0], files[0]).stdout


def test_history(tables, tmp_path, monkeypatch):
    """Jobs lie in the file in any order; each series has its own last figure and its own changes."""
    chance, series = random.Random(2), {"chain": [3.0] * 6 + [9.0] * 6, "track": [0.2] * 5 + [0.1] * 7}
    monkeypatch.setattr(history, "SHUFFLES", 300)
    made = [
        Entry(f"job{k}", f"2026-01-{k + 1:02d}", f"c{k}", "box", name, value * chance.uniform(0.999, 1.001),
              {"chain": "1", "track": "s"}[name], f"verdict {name} {k}")
        for name, values in series.items() for k, value in enumerate(values)
    ]  # fmt: skip
    chance.shuffle(made)
    made = [replace(e, error=chance.choice((None, size(chance)))) for e in made]
    lines.append(tmp_path / "h.jsonl", made)
    assert lines.read(tmp_path / "h.jsonl", Entry) == (made, [])
    assert run("history", "--file", str(tmp_path / "h.jsonl")).exit_code == 0
    at = {(e.series, e.made): e for e in made}
    own = {name: [at[name, f"2026-01-{k + 1:02d}"] for k in range(12)] for name in sorted(series)}
    when = {"chain": "2026-01-07", "track": "2026-01-06"}
    holds(tables[0], own.items(), [
        ("series", lambda o: o[0]), ("jobs", lambda o: len(o[1])), ("last", lambda o: g(o[1][-1].value)),
        ("unit", lambda o: o[1][-1].unit), ("verdict", lambda o: o[1][-1].verdict),
        ("changed at", lambda o: when[o[0]]),
    ])  # fmt: skip
    printed = json.loads(run("history", "--file", str(tmp_path / "h.jsonl"), "--json").stdout)
    assert printed == {name: {"values": [e.value for e in entries], "changes": [when[name]]}
                       for name, entries in own.items()}  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_conformance(monkeypatch, tables, tmp_path, seed):
    chance = random.Random(seed)
    rows = [
        Row(
            f"method{k}",
            f"scene{k}",
            chance.choice((None, chance.uniform(0.5, 9.0))),
            chance.choice((None, 4)),
            chance.choice((None, size(chance))),
            chance.choice((None, size(chance))),
        )
        for k in range(8)
    ]
    outcomes = ["passed"] * 5 + ["exempt"] * (2 * (seed > 0)) + ["failed"] * (3 * (seed > 1))
    chance.shuffle(outcomes)
    found = [Finding(f"question{k}", f"method{k}", f"scene{k}", outcome, f"detail{k}", "weak" * (outcome == "exempt"))
             for k, outcome in enumerate(outcomes)]  # type: ignore[arg-type]  # fmt: skip
    strange = ("belt", "chain")[:seed]  # parts that it declares and no scene has
    report = Report("mbs_ref", "9.9", tuple(found), tuple(rows), strange)
    monkeypatch.setattr(examine, "examine", lambda *given: report)
    files = [str(tmp_path / name) for name in ("all.json", "badge.json")]
    done = run("conformance", "--json", files[0], "--badge", files[1])
    assert done.exit_code == (1 if "failed" in outcomes else 0), done.output
    (table,) = tables
    assert table.title == "mbs_ref 9.9"
    holds(table, rows, [
        ("scene", lambda r: r.scene), ("method", lambda r: r.method), ("order", lambda r: g(r.order)),
        ("documented", lambda r: g(r.documented)), ("error", lambda r: g(r.error)), ("loop, s", lambda r: g(r.loop_s)),
    ])  # fmt: skip
    said = done.stdout.splitlines()
    for one in found:
        start = {"exempt": "exempt: ", "failed": "FAILED: ", "passed": "none"}[one.outcome]
        assert any(line.startswith(f"{start}{one.question}: {one.scene}") and line.endswith(one.detail)
                   for line in said) == (one.outcome != "passed")  # fmt: skip
    lacking = f"declared, and in none of the scenes: {', '.join(strange)}"
    assert [line for line in said if line.startswith("declared")] == ([lacking] if strange else [])
    counts = Counter(outcomes)
    assert said[-1] == ", ".join(f"{counts[word]} {word}" for word in ("passed", "exempt", "failed"))
    badge = json.loads((tmp_path / "badge.json").read_text())
    assert badge.keys() == {"schemaVersion", "label", "message", "color"}
    assert (badge["schemaVersion"], badge["label"]) == (1, "mbs-ref conformance")
    assert badge["color"] == ("brightgreen", "yellow", "red")[seed]
    assert badge["message"] == ", ".join(f"{counts[w]} {w}" for w in ("passed", "exempt", "failed") if counts[w])
    kept = json.loads((tmp_path / "all.json").read_text())
    assert kept["rows"] == [asdict(row) for row in rows]
    assert kept["conforms"] is (counts["failed"] == 0)


def test_engines(monkeypatch, tables):
    chance = random.Random(7)
    able = []
    for k, name in enumerate(("a", "b")):
        methods = tuple(Method(f"m{j}", "fixed", chance.choice((None, j + 1)), f"about {name}{j}") for j in range(2))
        parts = {kind: chance.random() < 0.5 for kind in PART_TYPES}
        able.append(Capability(name, True, "", f"{k}.7", methods, parts, {"s": (), "t": ("one reason",) * k}))
    able.insert(1, Capability("gone", False, "needs a package"))
    monkeypatch.setattr(engines_command, "capabilities", lambda: tuple(able))
    assert run("engines").exit_code == 0
    listed, parts, ran = tables
    here = [one for one in able if one.installed]
    expected = []
    for one in able:
        expected += [] if one.installed else [[one.engine, "missing", "", "", "", one.reason]]
        for j, m in enumerate(one.methods):
            head = [one.engine, one.version] if j == 0 else ["", ""]
            expected.append([*head, m.name, m.kind, str(m.order or "varies"), m.description])
    assert listed.head == ["engine", "version", "method", "kind", "order", "about"]
    assert listed.rows == expected
    assert (parts.head, ran.head) == (["part", "a", "b"], ["scene", "a", "b"])
    assert parts.rows == [[kind, *("yes" if one.parts[kind] else "not yet" for one in here)] for kind in PART_TYPES]
    assert ran.rows == [["s", "runs", "runs"], ["t", "runs", "one reason"]]


def test_judge(tables, tmp_path):
    """The second body is off most, at a sample in the middle; the table and JSON state the same figures."""
    scene, rng = scenes.make("double_pendulum", length_1=1.3), np.random.default_rng(3)
    path = simulate(scene, Settings(method="dop853", rtol=1e-12, samples=9, estimate="off", t_end=1.0))
    off = {name: 1e-3 * rng.uniform(-1.0, 1.0, getattr(path, name).shape) for name in ("position", "velocity")}
    off["position"][4, 1] = (0.03, 0.04)
    moved = replace(path, **{name: getattr(path, name) + own for name, own in off.items()})
    for name, own in (("run", moved), ("true", path)):
        write_poses(own, list(scene.body_names), tmp_path / f"{name}.npz")
    files = str(tmp_path / "run.npz"), "double_pendulum", "--against", str(tmp_path / "true.npz")
    words = ("judge", *files, "-p", "length_1=1.3", "--t-end", "1")
    printed = json.loads(run(*words, "--json").stdout)
    assert run(*words).exit_code == 1
    own, errors = tables
    for k, body in enumerate(scene.body_names):
        gap = np.linalg.norm(off["position"][:, k], axis=1)
        part = next(p for p in printed["parts"] if (p["body"], p["component"]) == (body, "position"))
        assert part["largest"] == pytest.approx(gap.max(), rel=1e-5)
        assert part["at"] == path.times[gap.argmax()]
        assert part["final"] == pytest.approx(gap[-1], rel=1e-5)
        assert part["relative"] == pytest.approx(gap.max() / printed["error"]["length"], rel=1e-5)
    below = lambda p: f"below {g(p['below'])} {p['unit']}" if p["below"] is not None else "unknown"  # noqa: E731
    holds(errors, printed["parts"], [
        ("body", lambda p: p["body"]), ("component", lambda p: p["component"]),
        ("largest", lambda p: below(p) if p["largest"] is None else f"{g(p['largest'])} {p['unit']}"),
        ("of the scene", lambda p: g(p["relative"])), ("at t, s", lambda p: g(p["at"])),
        ("at the end", lambda p: g(p["final"])),
    ])  # fmt: skip
    shown, error = facts(own), printed["error"]
    assert shown["verdict"] == f"{printed['verdict']}: {printed['reason']}"
    assert shown["compared with"] == error["truth"]
    length = f"the scene's length is {g(error['length'])} m"
    assert shown["known to"] == f"{g(error['uncertainty'])} of the scene; {length}"
    for name, metric in metrics.every().items():
        value = printed["measures"].get(name)
        assert shown.get(metric.label) == (None if value is None else f"{g(value)} {metric.unit}")


@pytest.mark.parametrize("seed", SEEDS)
def test_a_judgement_states_each_of_its_sentences_once_under_its_own_heading(tables, seed):
    chance = random.Random(seed)

    def sentences(kind: str) -> tuple[str, ...]:
        return tuple(f"{kind} {chance.random():.9f}" for _ in range(chance.randint(1, 4)))

    said = {kind: sentences(kind) for kind in ("suspicions", "missing", "notes")}
    judge._show(Judgement("scene", "not-judged", "a reason", 1e-6, None, (), {}, curves={}, **said))
    (verdict, *others), _ = tables[0].rows, tables[1]
    assert verdict == ["verdict", "not-judged: a reason"]
    assert others == [["suspicion", one] for one in said["suspicions"]] + [
        ["note", one] for kind in ("missing", "notes") for one in said[kind]]  # fmt: skip


def test_certify(monkeypatch, tables):
    chance = random.Random(5)
    library = [scenes.make("pendulum"), scenes.make("kepler"), scenes.make("double_pendulum")]

    def certificate(scene: Any, end: float, uncertainty: float) -> Certificate:
        return Certificate(scene.name, {}, 1.0, 41, "exact", "how", uncertainty, size(chance), {"a": [end, 0.0]}, "x",
                           size(chance), "2026", {})  # fmt: skip

    fresh = {library[0].name: certificate(library[0], 0.0, 0.02), library[1].name: NoTruth("none known"),
             library[2].name: certificate(library[2], 0.0, 0.3)}  # fmt: skip
    before = {library[0].name: certificate(library[0], 0.05, 0.04), library[2].name: None}
    monkeypatch.setattr(certify, "every_truth", lambda: library)
    monkeypatch.setattr(certify, "certify", lambda scene, confirm: fresh[scene.name])
    monkeypatch.setattr(certify.certificate, "stored", lambda scene: before.get(scene.name))
    assert run("certify").exit_code == 0
    one, other = fresh[library[0].name], fresh[library[2].name]
    assert tables[0].head == ["truth", "verdict", "kind", "known to, m", "two ways, m", "departs by, m"]
    names = [certify.certificate.file_name(scene).removesuffix(".json") for scene in library]
    assert [row[0] for row in tables[0].rows] == names
    assert [row[1:] for row in tables[0].rows] == [
        ["holds", "exact", "0.02", g(one.difference), "0.05"], ["no truth: none known", "", "", "", ""],
        ["new", "exact", "0.3", g(other.difference), "-"]]  # fmt: skip
    before[library[0].name] = certificate(library[0], 0.07, 0.04)
    assert run("certify").exit_code == 1
    assert [row["verdict"] for row in json_of(1, "certify")] == ["departs", "no truth", "new"]
    fresh |= dict.fromkeys(fresh, NoTruth("none known"))
    assert run("certify").exit_code == 5
    assert len(json_of(5, "certify")) == 3


def test_proofs(monkeypatch, tables):
    pytest.importorskip("flint")
    from cross_checks.truths.proofs import certified

    chance = random.Random(5)
    keys = ("t_end", "reached", "radius", "steps", "prover_s", "checker_s", "log_bytes", "distance", "turned",
            "uncertainty")  # fmt: skip
    made = [
        {"scene": f"s{k}", "truth": "inside", "reason": f"r{k}", **{key: size(chance) for key in keys}} for k in "ab"
    ]
    given = iter(made)
    monkeypatch.setattr(proofs, "_covered", lambda: [scenes.make("pendulum")] * 2)
    monkeypatch.setattr(certified, "examine", lambda *asked: (next(given), None))
    assert run("proofs").exit_code == 0
    words = [("scene", "scene"), ("truth", "truth")]
    holds(tables[0], made, [*keyed(*words, form=str), *keyed(*((key.replace("_", " "), key) for key in keys)),
                            *keyed(("not proven because", "reason"), form=str)])  # fmt: skip


def test_a_scene_of_a_report_is_chosen_by_its_whole_name_or_label():
    """A name that is a part of another chooses its own scene alone; without one, all are chosen."""
    labels = ["pendulum", "double_pendulum", "pendulum_chain links=1", "pendulum_chain links=11"]
    data: Any = SimpleNamespace(scenes=labels)
    assert [show.chosen(data, label) for label in labels] == [[label] for label in labels]
    assert show.chosen(data, "pendulum_chain") == labels[2:]
    assert show.chosen(data, "") == labels
    for part in ("pend", "links=1", "double"):
        with pytest.raises(click.UsageError, match=f"scene '{part}' is not in the report"):
            show.chosen(data, part)


@pytest.mark.parametrize("seed", SEEDS)
def test_show(tables, tmp_path, seed):
    """Prices and verdicts of one scene of a report, and what accuracy costs in characters."""
    data = irregular(seed)
    build.write_data(data, tmp_path)
    label = "pendulum_chain links=3"
    done = run("show", *label.split(), "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    prices, verdicts, _ = tables
    expected = []
    never = cannot(price_table(data, label))
    for block in price_table(data, label):
        for row in (row for row in block["rows"] if row["engine"] not in never):
            texts = [row[key] for key in ("method", "setting", "error", "time", "factor")] if not row["missed"] else []
            expected.append([block["target"], row["engine"], *(texts or [row["missed"], *"––––"])])
    assert prices.rows == expected
    own = [c for c in data.cells if c.label == label]
    assert [row[:3] for row in verdicts.rows] == [[c.engine, c.method, str(c.verdict)] for c in own]
    text = run("show", *label.split(), "-o", str(tmp_path), "--csv").stdout.splitlines()
    assert [line.split(",")[1:4:2] for line in text[1:]] == [[row[0], row[2]] for row in expected]
    before, name = len(tables), label.split()[0]
    assert run("show", name, "-o", str(tmp_path)).exit_code == 0
    named = [one.title.split(": cost")[0] for one in tables[before:] if ": cost" in one.title]
    assert named == [one for one in data.scenes if one.split()[0] == name]
    printed = json.loads(run("show", *label.split(), "-o", str(tmp_path), "--json").stdout)
    assert [(c["engine"], c["method"], c["error"]) for c in printed["cells"]] == [
        (c.engine, c.method, c.error) for c in own
    ]
    assert [list(row.values()) for row in printed["prices"]] == expected
    runs_of = [r for r in data.records if r.label == label and r.error and r.status == "success"]
    kept = []
    for r in runs_of:
        mine = [(o.times["loop_s"], o.error.bound) for o in runs_of if o.engine == r.engine and o.error]
        if r.error and not any(t < r.times["loop_s"] and e <= r.error.bound for t, e in mine):
            kept.append((1000.0 * r.times["loop_s"], r.error.bound))
    ms, errors = zip(*kept, strict=True)
    plot = done.stdout.split("error over the scene's scales")[1].splitlines()
    sides = [line.split("|")[0].strip() for line in plot if "|" in line]
    assert [sides[0], sides[-1]] == [g(max(errors)), g(min(errors))]
    (ends,) = (plot[k - 1].split() for k, line in enumerate(plot) if "loop time, ms" in line)
    assert ends == [g(min(ms)), g(max(ms))]


@pytest.mark.parametrize("seed", SEEDS)
def test_pick_among_records(monkeypatch, tmp_path, seed):
    """The sentence, JSON and the run's command state one choice; runs of other scenes and engines do not count."""
    chance = random.Random(seed)
    made = [record(chance, status="success", error=Error(10 ** chance.uniform(-8, -5), "exact", 1e-10, None),
                   notes=(BUSY_NOTE,) if k < 4 else ()) for k in range(12)]  # fmt: skip
    others = [replace(r, times={"loop_s": 1e-12}, **more) for r in made[:2] for more in (
        {"scene": "kepler"}, {"parameters": {"length": 77.0}})]  # type: ignore[arg-type]  # fmt: skip
    lines.append(tmp_path / "r.jsonl", [*others, *made])
    monkeypatch.setattr(picking, "as_shipped", lambda *given: None)
    words = ("pick", "pendulum", "--error", "1e-6", "--records", str(tmp_path / "r.jsonl"), "--no-confirm")
    for chosen in ([], ["exudyn", "mujoco"]):
        asked = [word for name in chosen for word in ("--engine", name)]
        fits = [r for r in made if r.error and r.error.bound <= 1e-6 and (not chosen or r.engine in chosen)]
        done = run(*words, *asked)
        if not fits:
            assert done.exit_code == 5
            continue
        best = min(fits, key=lambda r: r.times["loop_s"])
        printed = json.loads(run(*words, *asked, "--json").stdout)
        assert lines.adapter(Record).validate_python(printed["best"] | {"history": {}}) == best
        assert done.stdout.startswith(f"{best.engine} {best.method} ")
        assert printed["command"] in done.stdout.splitlines()
        assert f"--engine {best.engine} --method {best.method}" in printed["command"]
        own = [r for r in made if not chosen or r.engine in chosen]
        busy = sum(bool(r.notes) for r in own)
        assert (f"{busy} of {len(own)} runs were timed on a busy machine" in done.stderr) == bool(busy)


def test_doctor(monkeypatch, tables):
    made = record(random.Random(1), status="success", error=Error(3.21e-8, "exact", 0.0, None, length=7.0))
    monkeypatch.setattr(one_run, "evaluate", lambda *given: made)
    printed = json.loads(run("doctor", "--json").stdout)
    assert run("doctor").exit_code == 0
    shown = facts(tables[0])
    assert shown["pendulum"] == "right, error 2.25e-07 m"
    for right in (os.R_OK, os.W_OK):  # the cache can be read, or written
        monkeypatch.setattr(doctor.os, "access", lambda path, mode, right=right: mode == right)
        assert json.loads(run("doctor", "--json").stdout)["numba_cache"]["writable"] == (right == os.W_OK)
        assert run("doctor").exit_code == 0
        assert facts(tables[-1])["compiled kernels"].endswith("anew)") == (right == os.R_OK)
    assert printed["sanity"]["error"] == pytest.approx(7.0 * 3.21e-8)
    for kind in ("packages", "engines"):
        assert {name: shown[name] for name in printed[kind]} == printed[kind]


def test_scenes(tables):
    printed = json.loads(run("scenes", "--json").stdout)
    assert run("scenes").exit_code == 0
    holds(tables[0], printed, [
        ("scene", lambda s: s["name"]),
        ("parameters (default)", lambda s: " ".join(f"{k}={v}" for k, v in s["parameters"].items())),
        ("about", lambda s: s["summary"]),
    ])  # fmt: skip
