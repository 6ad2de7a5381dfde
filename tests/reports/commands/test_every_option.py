"""Every option of every command: its value, and nothing else, arrives where it is meant to, and so does its default.

The functions that commands call are replaced by ones that note what they are given; the last of them ends the command.
An option that has no row here, and is none of an answer's form, fails a test.
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator, Mapping, ValuesView
from contextlib import ExitStack, nullcontext
from dataclasses import fields, is_dataclass
from inspect import signature
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import click
import numpy as np
import pytest
from click.testing import CliRunner
from pydantic import BaseModel

from benchmarks.trees import regression
from cross_checks.contact import ENGINES
from cross_checks.extremes import every as every_extreme
from cross_checks.judge.runs import Runs
from cross_checks.prices.pick import Choice
from cross_checks.records import lines
from cross_checks.records.store import default_path
from cross_checks.truths.truth import NoTruth
from mbs_ref import Scene, scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.simulate.many.ensemble.design import Uniform
from mbs_ref.trajectory import Trajectory
from reports.cli import main
from tests.reports.commands.test_trade_cli import PENDULUM, RECORD

END = object()  # what ends the command when it is returned
ANSWER = {
    "as_json",
    "as_csv",
    "plot",
    "output",
    "target",
    "text",
    "open_it",
    "file",
    "badge",
}  # of the form of an answer: see its tables


class Reached(BaseException):
    """The last function was called."""


class Row(NamedTuple):
    """Words of one option, where its value arrives, the value without it, and with it."""

    words: str
    at: str
    default: Any
    value: Any


class Case(NamedTuple):
    """A command, the functions that it calls with what they return, and its options."""

    words: str
    calls: dict[str, Any]
    rows: tuple[Row, ...]


def flat(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the leaves of nested data by dotted names."""
    if isinstance(value, Scene):
        value = {"name": value.name, "duration": value.duration, "parameters": value.parameters}
    elif isinstance(value, BaseModel):
        value = dict(value)
    elif is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        for key, own in value.items():
            yield from flat(f"{name}.{key}", own)
    elif isinstance(value, list | tuple) and any(isinstance(own, Scene | Mapping) for own in value):
        for k, own in enumerate(value):
            yield from flat(f"{name}.{k}", own)
    elif not callable(value) and not isinstance(value, ExitStack | Iterator | ValuesView):
        yield name, value.tolist() if hasattr(value, "tolist") else value


def arrived(monkeypatch: pytest.MonkeyPatch, case: Case, words: str = "") -> dict[str, Any]:
    """Run a command; return the arguments of the functions that it calls, by function and name."""
    seen: dict[str, Any] = {}

    def spy(function: str, own: Any, answer: Any) -> Any:
        def noted(*given: Any, **more: Any) -> Any:
            bound = signature(own).bind(*given, **more)
            bound.apply_defaults()
            seen.setdefault(f"{function}()", True)
            for name, value in bound.arguments.items():
                seen.update(flat(f"{function}.{name}", value))
            if answer is END:
                raise Reached
            return answer(*given, **more) if callable(answer) else answer

        return noted

    with monkeypatch.context() as patched:
        for target, answer in case.calls.items():
            module, function = target.split(":")
            owner = importlib.import_module(module)
            patched.setattr(owner, function, spy(function, getattr(owner, function), answer))
        with contextlib.suppress(Reached):
            done = CliRunner().invoke(main, [*case.words.split(), *words.split()], prog_name="mbs-ref")
            assert done.exit_code == 0, (done.output, done.exception)
    return seen


def rows(*given: tuple[str, str, Any, Any]) -> tuple[Row, ...]:
    return tuple(Row(*one) for one in given)


def scene_rows(at: str, *more: str, keeps: bool = True) -> tuple[Row, ...]:
    """Return the rows of a scene's own options, and what else depends on its parameters."""
    kept = rows(("--keep rod.velocity", "fitted_rates.fixed", None, ("rod.velocity",))) if keeps else ()
    return (*rows(("-p length=1.7", " ".join((f"{at}.parameters.length", *more)), 1.0, 1.7)), *kept)


def settings_rows(at: str, *without: str, **defaults: Any) -> tuple[Row, ...]:
    """Return the rows of the settings of a run; without some, and with other defaults of a command."""
    known = {
        "method": "rk4", "step": 0.25, "rtol": 1e-5, "atol": 1e-7, "stabilization": "baumgarte",
        "coordinates": "relative", "t_end": 0.75, "samples": 7, "outputs": "dense", "events": "none",
        "estimate": "off",
    }  # fmt: skip
    plain = dict(Settings())
    made = [(f"--{name.replace('_', '-')} {value}", f"{at}.{name}", defaults.get(name, plain[name]), value)
            for name, value in known.items() if name not in without]  # fmt: skip
    flag = [] if "project_initial" in without else [("--project-initial", f"{at}.project_initial", False, True)]
    return rows(*made, *flag)


class Solver:
    """Stands in for an engine; callable, so that it is left out of what arrives."""

    default_method = "auto"

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self) -> None: ...

    def method(self, name: str) -> Any:
        return SimpleNamespace(name=name)


NAMES = ["mbs_ref", "exudyn", "mujoco"]
STILL = Trajectory(np.arange(2.0), *(np.zeros((2, 1, *shape)) for shape in ((2,), (), (2,), ())))
FITTED = {"reports.inputs:fitted_rates": lambda scene, *more: scene}
CHOSEN = {"reports.inputs:engine_names": lambda chosen: list(chosen) or NAMES}
THREE = [PENDULUM, scenes.make("kepler"), scenes.make("double_pendulum")]
CHOICE = Choice(RECORD, RECORD, 1.01, "the sentence")
BLANK = lambda *given, **more: nullcontext(None)  # noqa: E731
STORED = Runs()
RUNS = lambda *given, **more: nullcontext(STORED)  # noqa: E731
TWO = [SimpleNamespace(name=f"{engine} rk4 s", engine=engine) for engine in NAMES]
ROW = Uniform(0.0, 1.0)  # any dataclass, as a row of a table
COMMIT = {"reports.commands.maintenance.nightly:environment": {"commit": "c"}}
CASES = {one.words: one for one in (
    Case("simulate pendulum", {
        **FITTED, "reports.inputs:engine": Solver, "cross_checks.judge.one_run:judged_run": END,
    }, (
        *scene_rows("judged_run.scene"), *settings_rows("judged_run.settings", method="auto"),
        *rows(("--engine exudyn", "judged_run.engine_name engine.", "mbs_ref", "exudyn"),
              ("--stop-on-compliance", "judged_run.settings.stop_on_compliance", False, True)),
    )),
    Case("simulate pendulum --samples 2", {
        "cross_checks.judge.one_run:judged_run": (RECORD, STILL), "reports.commands.run.simulate:Store": BLANK,
        "cross_checks.judge.runs:Runs": SimpleNamespace(truth=lambda *given: NoTruth("")),
        "cross_checks.judge.runs:against": lambda scene, run, truth: run.record,
    }, rows(("--store a.sqlite", "Store.path", default_path, Path("a.sqlite")),
            ("--no-truth", "against() Store Runs against", True, None))),
    Case("ensemble pendulum --vary mass=1..2", {
        "reports.commands.run.ensemble:cluster": BLANK, "mbs_ref.simulate.many.ensemble:run_ensemble": END,
    }, (
        *settings_rows("run_ensemble.settings"),
        *rows(("-p length=1.7", "run_ensemble.variants.source.scene.parameters.length", 1.0, 1.7),
              ("--vary gravity=9..10", "run_ensemble.design.laws.gravity.low run_ensemble.design run_ensemble.var",
               None, 9.0),
              ("-n 7", "run_ensemble.design.count", 200, 7), ("--seed 7", "run_ensemble.design.seed", 0, 7),
              ("--keep bob.velocity", "run_ensemble.variants.fixed", (), ("bob.velocity",)),
              ("--threads 3", "run_ensemble.threads", None, 3),
              ("--scheduler tcp://h:1", "cluster.scheduler", None, "tcp://h:1")),
    )),
    Case("write pendulum --as mjcf", {**FITTED, "cross_checks.writers:write": END}, (
        *scene_rows("write.scene"), *rows(("--as urdf", "write.form", "mjcf", "urdf")),
        *settings_rows("write.settings", "stabilization", "coordinates", "outputs", "events", "estimate",
                       "project_initial"),
    )),
    Case("animate pendulum", {
        **FITTED, "reports.inputs:engine": Solver, "reports.commands.run.animate:_run": STILL,
        "reports.film.files:video_library": "av", "reports.film.files:beside": [], "reports.film.files:as_gif": b"",
        "reports.film.files:as_mp4": b"", "reports.film.files:as_page": b"", "reports.film.files:filmstrip": b"",
    }, (
        *scene_rows("_run.scene", "beside.", "filmstrip."),
        *rows(("--t-end 0.75", "_run.settings.t_end", None, 0.75), ("--frames 7", "_run.settings.samples", 81, 7),
              ("--strip 3", "filmstrip.count", 8, 3), ("--seconds 2.5", "as_gif.seconds", 4.0, 2.5),
              ("--mp4", "as_mp4() as_mp4. video_library", None, True),
              ("--mp4", "as_mp4.seconds as_mp4 video_", None, 4.0),
              ("--html", "as_page() as_page.", None, True), ("--html", "as_page.seconds as_page", None, 4.0),
              ("--project-initial", "_run.settings.project_initial", False, True),
              ("--engine exudyn", "engine.name_or_file beside.runs", "mbs_ref", "exudyn")),
    )),
    Case("board", {"reports.commands.publish.board:last_report": END},
         rows(("--from .", "last_report.folder", Path("reports/out"), Path()))),
    Case("show", {"reports.commands.publish.show:last_report": END},
         rows(("-o .", "last_report.folder", Path("reports/out"), Path()))),
    Case("compile", {"reports.commands.engines.compile:Store": END},
         rows(("--store b.sqlite", "Store.path", default_path, Path("b.sqlite")))),
    Case("merge a.sqlite", {"reports.commands.maintenance.merge:Store": END},
         rows(("--store b.sqlite", "Store.path", default_path, Path("b.sqlite")))),
    Case("certify pendulum", {
        "reports.commands.judge.certify:store_poses": None, "reports.commands.judge.certify:certify": END,
    }, (*scene_rows("certify.scene", keeps=False),
        *rows(("--write", "certify.confirm store_poses", False, True)))),
    Case("check pendulum", {
        **FITTED, **CHOSEN, "reports.commands.judge.check:tasks": lambda names: [(name, None) for name in names],
        "reports.commands.judge.check:questions": lambda selected, offered: [name for name, _ in offered],
        "reports.commands.judge.check:open_runs": RUNS, "reports.commands.judge.check:answers": END,
    }, (
        *scene_rows("open_runs.scenes.0", "questions.scenes.0.parameters"),
        *rows(("--engine mujoco", "engine_names.chosen tasks questions.offered answers.requested", (), ("mujoco",)),
              ("--shard 2/3", "answers.requested", lambda base: base["answers.requested"],
               lambda base: base["answers.requested"][1::3]),
              ("--scheduler tcp://h:1", "open_runs.scheduler", None, "tcp://h:1"),
              ("--store b.sqlite", "open_runs.store", None, "b.sqlite")),
    )),
    Case("sweep pendulum", {**FITTED, "reports.commands.choose.sweep:sweep_records": END}, (
        *scene_rows("sweep_records.scene"),
        *rows(("--engine mujoco", "sweep_records.chosen", (), ("mujoco",)),
              ("--method rk4", "sweep_records.methods", (), ("rk4",)),
              ("--timeout 7", "sweep_records.timeout", None, 7.0),
              ("--memory 7", "sweep_records.memory_mib", None, 7.0),
              ("-o b.jsonl", "sweep_records.target", None, Path("b.jsonl")),
              ("--scheduler tcp://h:1", "sweep_records.scheduler", None, "tcp://h:1"),
              ("--store b.sqlite", "sweep_records.store", None, "b.sqlite")),
    )),
    Case("sweep kepler", {  # farther down: what the search itself is given
        **CHOSEN, "reports.query:Store": BLANK, "reports.query:Isolated": BLANK, "cross_checks.prices.sweep:sweep": END,
    }, rows(
        ("--engine mujoco", "sweep.engines engine_names.chosen", NAMES, ["mujoco"]),
        ("--method rk4", "sweep.methods", None, ["rk4"]), ("--timeout 7", "Isolated.timeout", 120.0, 7.0),
        ("--memory 7", "Isolated.memory", 4096 * 2**20, 7 * 2**20),
        ("--store b.sqlite", "Store.path", default_path, Path("b.sqlite")),
    )),
    Case("pick kepler --error 1e-3", {
        "reports.query:Store": BLANK, "reports.query:Isolated": BLANK, "cross_checks.prices.sweep:sweep": END,
    }, rows(("--error 1e-4", "sweep.targets", (1e-3,), (1e-4,)))),
    Case("pick pendulum --error 1e-3", {
        **FITTED, "reports.commands.choose.pick:sweep_records": [RECORD], "cross_checks.prices.pick:pick": CHOICE,
        "reports.commands.choose.pick:isolated": BLANK, "cross_checks.prices.pick:duel": END,
    }, (
        *scene_rows("sweep_records.scene", "duel.scene", "isolated."),
        *rows(("--error 1e-4", "pick.error sweep_records.errors", 1e-3, 1e-4),
              ("--error 1e-4", "sweep_records.errors pick.error", (1e-3,), (1e-4,)),
              ("--error 2mm", "pick.error sweep_records.errors", 1e-3, 2e-3 / scales_of(PENDULUM).length),
              ("--compliance 1e-5", "pick.compliance", None, 1e-5), ("--budget 50ms", "pick.budget", None, 0.05),
              ("--real-time", "pick.budget", None, PENDULUM.duration),
              ("--real-time --budget 1us", "pick.budget", None, 1e-6),
              ("--engine mujoco", "sweep_records.chosen", (), ("mujoco",)),
              ("--store b.sqlite", "sweep_records.store", None, "b.sqlite"),
              ("--records r.jsonl", "sweep_records() sweep_records pick.records", True, None),
              )
    )),
    Case("pick pendulum --error 1e-3 --no-confirm", {
        "reports.commands.choose.pick:sweep_records": [RECORD], "cross_checks.prices.pick:pick": CHOICE,
        "reports.commands.choose.pick:open_runs": RUNS, "reports.commands.choose.pick:truth_of": None,
        "cross_checks.prices.pick:afresh": RECORD, "cross_checks.prices.pick:as_shipped": None,
        "cross_checks.prices.pick:duel": CHOICE, "reports.commands.choose.pick:isolated": BLANK,
        "cross_checks.prices.pick:settled": CHOICE,
    }, rows(
        ("--fresh", "afresh.record.scene afresh open_runs truth_of", None, "pendulum"),
        ("--fresh --store b.sqlite", "open_runs.store afresh open_runs truth_of sweep_records.store", None, "b.sqlite"),
        ("--engine mujoco", "as_shipped.engine as_shipped open_runs sweep_records.chosen", None, "mujoco"),
        ("--confirm", "duel() duel isolated settled", None, True),
    )),
    Case("pick pendulum --error 1e-2", {
        "reports.studies.models:of_family": "a family",
        "reports.commands.choose.pick:sweep_records": END, "reports.studies.models:choose": END,
    }, rows(("--models", "choose.error choose of_family sweep_records", None, 1e-2),
            ("--models --error 1e-4", "choose.error choose of_family sweep_records", None, 1e-4))),
    Case("contact --rebound 0.5 --friction 0.7 --stiffness 1e5 --mass 2", {
        "cross_checks.contact:models": ({"a": None}, []), "cross_checks.contact.request:Request": END,
    }, rows(
        *((f"--{name} {new}", f"Request.{name}", old, float(new)) for name, old, new in (
            ("rebound", 0.5, 0.25), ("friction", 0.7, 0.125), ("stiffness", 1e5, 2e4), ("mass", 2.0, 3),
            ("speed", 1.0, 7), ("step", 1e-3, 1e-4))),
        ("--engine mujoco", "models.names", tuple(ENGINES), ("mujoco",)),
    )),
    Case("contact --figures", {
        "cross_checks.contact:models": ({}, []), "cross_checks.contact.by_figure:with_contact": {"a": 1, "b": 2},
        "cross_checks.contact.by_figure:compare": [ROW],
    }, rows(("--step 1e-4", "compare.step", 1e-3, 1e-4), ("--scene b", "compare.cases.a", 1, None))),
    Case("contact --holding", {
        "cross_checks.contact:models": ({}, []), "cross_checks.contact.by_figure:holding": {"a": 1, "b": 2},
        "cross_checks.contact.by_figure:compare": [ROW],
    }, rows(("--step 1e-4", "compare.step", 1e-3, 1e-4), ("--scene b", "compare.cases.a", 1, None))),
    Case("contact --instant b.npz --scene bouncing_ball", {
        "cross_checks.contact:models": ({}, []), "cross_checks.contact.instant:state_at": lambda scene, time: scene,
        "cross_checks.contact.instant:instant": None, "cross_checks.contact.instant:write": None,
        "cross_checks.contact.instant:assess": [ROW],
    }, rows(("--at 0.1", "state_at.time", 0.0, 0.1), ("--step 1e-4", "instant.step", 1e-3, 1e-4),
            ("-p mass=1.5", "state_at.scene.parameters.mass instant.", 1.0, 1.5),
            ("--instant c.npz", "write.path", Path("b.npz"), Path("c.npz")))),
    Case("contact --tosses", {
        "cross_checks.contact:models": ({}, []), "cross_checks.contact.tosses:stored": [],
        "cross_checks.contact.tosses:predict": [ROW], "cross_checks.contact.tosses:summaries": [ROW],
    }, rows(("--tosses 3", "predict.sample summaries.random", 0, 3),
            ("--tosses 3", "summaries.random predict.sample", False, True),
            ("--folder .", "stored.folder", None, Path()), ("--step 1e-4", "predict.step", 1e-3, 1e-4))),
    Case("extremes", {
        **CHOSEN, "reports.commands.explore.extremes:cluster": BLANK, "reports.commands.explore.extremes:begun": [],
        "cross_checks.extremes.run:matrix": END,
    }, rows(
        ("--full", "matrix.full", False, True),
        ("--only overflow", "matrix.extremes", list(every_extreme()),
         [e for e in every_extreme() if "overflow" in e.name]),
        ("--engine mujoco", "matrix.engines engine_names", NAMES, ["mujoco"]),
        ("--shard 2/3", "matrix.extremes", list(every_extreme()), list(every_extreme())[1::3]),
        ("--scheduler tcp://h:1", "cluster.scheduler", None, "tcp://h:1"),
        ("-o b.jsonl", "begun.target", None, Path("b.jsonl")),
    )),
    Case("repeatability", {
        **CHOSEN, "cross_checks.conformance.cases:cases": lambda names, *more: [t for t in TWO if t.engine in names],
        "cross_checks.conformance.repeatability:measured": END,
    }, rows(("--engine mujoco", "measured.cases engine_names cases", TWO, TWO[2:]),
            ("--only exudyn", "measured.cases", TWO, TWO[1:2]))),
    Case("symmetry", {
        **CHOSEN, "cross_checks.conformance.cases:cases": lambda names, *more: [t for t in TWO if t.engine in names],
        "cross_checks.isolation.parent:Isolated": BLANK, "cross_checks.conformance.symmetry:isolated": END,
    }, rows(("--engine mujoco", "isolated.case engine_names cases", TWO[0], TWO[2]),
            ("--only exudyn", "isolated.case", TWO[0], TWO[1]))),
    Case("parity r.urdf", {"reports.commands.explore.parity:parity": END},
         rows(("--poses 7", "parity.poses", 5, 7), ("--seed 7", "parity.seed", 1, 7))),
    Case("inspect pendulum", {**FITTED, "reports.commands.run.inspect:stiffness_at_start": END},
         scene_rows("stiffness_at_start.scene", "stiffness_at_start.speed")),
    Case("scenes pendulum --files .", {
        "reports.commands.run.scenes:write_scene": END, "reports.scene_file:schema": END,
        "reports.scene_file:page": END,
    }, rows(("-p length=1.7", "write_scene.scene.parameters.length", 1.0, 1.7),
            ("--files b", "write_scene.path", Path("pendulum.toml"), Path("b/pendulum.toml")),
            ("--schema", "schema() write_scene", None, True), ("--reference", "page() write_scene", None, True))),
    Case("judge f.csv pendulum", {
        **FITTED, "reports.commands.judge.judge:open_runs": RUNS,
        "cross_checks.trajectory_files.motion:read_motion": "read",
        "cross_checks.trajectory_files.motion:in_common": END, "cross_checks.trajectory_files.library:truth_at": "at",
        "cross_checks.trajectory_files.library:judged": END, "reports.commands.judge.judge:_begin_map": END,
    }, (
        *scene_rows("judged.scene", "open_runs.", "read_motion.", "truth_at."),
        *rows(("--map m.toml", "read_motion.map_path", None, Path("m.toml")),
              ("--error 2mm", "judged.error", 1e-6, 2e-3 / scales_of(PENDULUM).length),
              ("--t-end 0.75", "judged.scene.duration open_runs read_motion truth_at", PENDULUM.duration, 0.75),
              ("--store b.sqlite", "open_runs.store", None, "b.sqlite"),
              ("--against a.csv", "in_common.files in_common judged read_motion truth_at", None,
               ((Path("f.csv"), None), (Path("a.csv"), None))),
              ("--against a.csv --map m.toml", "in_common.files in_common judged read_motion truth_at", None,
               ((Path("f.csv"), Path("m.toml")), (Path("a.csv"), Path("m.toml")))),
              ("--against a.csv --against-map m.toml", "in_common.files in_common judged read_motion truth_at", None,
               ((Path("f.csv"), None), (Path("a.csv"), Path("m.toml")))),
              ("--write-map b.toml", "_begin_map.target _begin_map open_runs read_motion truth_at judged", None,
               "b.toml")),
    )),
    Case("calibrate", {
        "benchmarks.calibration:stored": {}, "benchmarks.calibration:proven": ["p"],
        "reports.inputs:shard": lambda items, text: items, "benchmarks.calibration:trial": END,
    }, rows(
        ("-n 7", "shard.items", list(range(500)), list(range(7))),
        ("--first 7", "shard.items trial.seed", list(range(500)), list(range(7, 507))),
        ("--first 7", "trial.seed shard.items", 0, 7), ("--shard 2/3", "shard.text", "1/1", "2/3"),
        ("--keep r.jsonl", "stored.file stored", None, Path("r.jsonl")), ("--proven", "trial.among proven", [], ["p"]),
    )),
    Case("engines forget drake", {"cross_checks.isolation.environments:forget": Path("home")}, ()),
    Case("compare . .", {
        "benchmarks.trees.regression:regressions": END, "benchmarks.trees.slowed:copy_tree": Path("copied"),
        "benchmarks.trees.slowed:calibrate": (1, 0.05), "benchmarks.trees.regression:Tree": nullcontext,
        "benchmarks.trees.regression:rate_of": END,
    }, rows(
        ("--only rk4", "regressions.cases", list(regression.CASES), [c for c in regression.CASES if c.method == "rk4"]),
        ("--slowed 5", "calibrate.share calibrate copy_tree regressions.current", None, 0.05),
        ("--slowed 5", "regressions.current calibrate copy_tree", Path(), Path("copied")),
        ("--rates", "rate_of() rate_of Tree regressions", None, True),
        ("--rates", "rate_of.old rate_of Tree regressions", None, Path()),
    )),
    Case("compare . b", {
        "benchmarks.trees.regression:Tree": nullcontext, "benchmarks.trees.regression:rate_of": END,
        "benchmarks.trees.regression:regressions": END,
    }, rows(
        ("--rates", "rate_of.new rate_of Tree regressions", None, Path("b")),
        ("--only rk4", "regressions.current regressions.cases", Path("b"), Path("b")),
    )),
    Case("nightly", {"reports.commands.maintenance.nightly:findings_of": END, **COMMIT}, rows(
        ("--baseline a", "findings_of.baseline", "HEAD~1", "a"),
        ("--only rk4", "findings_of.cases", list(regression.CASES), [c for c in regression.CASES if c.method == "rk4"]),
    )),
    Case("nightly --only chain", {
        **COMMIT, "reports.commands.maintenance.nightly:findings_of": [], "benchmarks.history:from_benchmarks": [],
        "reports.commands.maintenance.nightly:_sweep": ([], []), "cross_checks.records.lines:append": None,
        "reports.commands.maintenance.nightly:_report_history": END,
    }, rows(
        ("--bench b.json", "from_benchmarks.data.benchmarks from_benchmarks", None, []),
        ("--file b.jsonl", "append.path _report_history.file", Path("reports/out/history.jsonl"), Path("b.jsonl")),
        ("--sweeps b", "_sweep.folder _sweep", None, Path("b")),
        ("--trends b.html", "_report_history.trends", None, Path("b.html")),
    )),
    Case("history --file r.jsonl", {"benchmarks.history:series": END, "cross_checks.records.lines:read": ([], [])},
         rows(("--file a.jsonl", "read.path", Path("r.jsonl"), Path("a.jsonl")),
              ("--series rk4", "series.name_contains", "", "rk4"))),
    Case("report", {
        **CHOSEN, "reports.gather:Gathering": SimpleNamespace(stages=lambda: None),
        "reports.commands.publish.report:cluster": BLANK, "reports.commands.publish.report:Store": BLANK,
        "reports.page.build:write_report": END, "reports.commands.publish.show:last_report": END,
    }, rows(
        ("--quick", "Gathering.quick", False, True), ("--full", "Gathering.full", False, True),
        ("--retime", "Gathering.again", False, True), ("--scene kepler", "Gathering.scenes", (), ("kepler",)),
        ("--engine mujoco", "Gathering.engines engine_names", (), ["mujoco"]),
        ("--target 1e-6", "write_report.targets", [], [1e-6]), ("--format pdf", "write_report.form", "html", "pdf"),
        ("--scheduler tcp://h:1", "cluster.scheduler", None, "tcp://h:1"),
        ("-o .", "write_report.out_dir", Path("reports/out"), Path()),
        ("--render", "last_report.folder last_report cluster Gathering write_report Store", None, Path("reports/out")),
    )),
    Case("conformance mbs_ref", {
        "reports.inputs:engine": Solver, "cross_checks.isolation.parent:Isolated": BLANK,
        "cross_checks.conformance.apart:Apart": None, "cross_checks.conformance.examine:examine": END,
        "reports.commands.engines.conformance:_self_test": END,
    }, rows(
        ("--timeout 7", "Isolated.timeout", 60.0, 7.0),
        ("--self-test", "_self_test() engine Isolated Apart examine", None, True),
    )),
)}  # fmt: skip
PROOFS = {one.words: one for one in (
    Case("prove pendulum", {
        "cross_checks.truths.proofs.integrate:prove": END, "cross_checks.truths.proofs.integrate:prove_family": END,
        "reports.commands.judge.prove:_check": END,
    }, (
        *scene_rows("prove.scene", keeps=False),
        *rows(("--t-end 2", "prove.times", np.linspace(0.0, PENDULUM.duration, 11).tolist(),
               np.linspace(0.0, 2.0, 11).tolist()),
              ("--samples 3", "prove.times", np.linspace(0.0, PENDULUM.duration, 11).tolist(),
               [0.0, PENDULUM.duration / 2, PENDULUM.duration]),
              ("--radius 1e-9", "prove.aim", 1e-15, 1e-9), ("--inputs decimal", "prove.inputs", "binary64", "decimal"),
              ("--limit 7", "prove.limit", 600.0, 7.0),
              ("--vary length=2+-0.5", "prove_family.low prove", None, 1.5),
              ("--vary length=2+-0.5 --limit 7 --inputs decimal", "prove_family.high prove", None, 2.5),
              ("--vary length=2+-0.5 --limit 7 --inputs decimal", "prove_family.limit prove", None, 7.0),
              ("--vary length=2+-0.5 --limit 7 --inputs decimal", "prove_family.inputs prove", None, "decimal")),
    )),
    Case("prove --check a.sqlite", {"reports.commands.judge.prove:_check": END},
         rows(("--check a.csv", "_check.file", Path("a.sqlite"), Path("a.csv")))),
    Case("proofs pendulum", {
        "cross_checks.truths.proofs.certified:examine": END,
        "cross_checks.truths.proofs.certified:varied": lambda scene, seed: scene,
    }, (
        *scene_rows("examine.scene", "examine.aim", keeps=False),
        *rows(("--radius 1e-9", "examine.aim", 1e-18, 1e-9), ("--limit 7", "examine.limit", 60.0, 7.0),
              ("--seed 7", "varied.seed varied", None, 7)),
    )),
    Case("proofs", {
        "reports.commands.judge.proofs:_covered": THREE, "cross_checks.truths.proofs.certified:examine": END,
        "cross_checks.truths.proofs.certified:kept": [(THREE[1], np.zeros(1), 1.0)],
    }, rows(
        ("--shard 2/3", "examine.scene.name examine", "pendulum", "kepler"),
        ("--again", "examine.scene.name _covered kept examine", "pendulum", "kepler"),
        ("--write", "examine.scene.name", "pendulum", "pendulum"),
    )),
)}  # fmt: skip


@pytest.fixture
def files(monkeypatch, tmp_path) -> None:
    """Work in a folder of the files that options name."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.sqlite", "f.csv", "a.csv", "m.toml", "r.urdf", "a.jsonl"):
        Path(name).touch()
    Path("b").mkdir()
    Path("b.json").write_text('{"benchmarks": []}')
    lines.append(Path("r.jsonl"), [RECORD])


def holds(monkeypatch: pytest.MonkeyPatch, case: Case) -> None:
    """Assert that every option of a case changes what it is meant to, and nothing else."""
    base = arrived(monkeypatch, case)
    for row in case.rows:
        at, *more = row.at.split()
        found = arrived(monkeypatch, case, row.words)
        default = row.default() if row.default is default_path else row.default
        default, value = (own(base) if callable(own) else own for own in (default, row.value))
        assert base.get(at) == default, row
        assert found.get(at) == value, row
        changed = {key for key in base.keys() | found.keys() if base.get(key) != found.get(key)}
        kept = ("fitted_rates", "as_shipped.scene")
        assert {key for key in changed if not key.startswith((at, *more, *kept))} == set(), row


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", CASES)
def test_an_option_arrives_and_changes_nothing_else(monkeypatch, words):
    monkeypatch.setattr("reports.page.build.browser", lambda: "a browser")
    holds(monkeypatch, CASES[words])


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", PROOFS)
def test_an_option_of_proofs_arrives_and_changes_nothing_else(monkeypatch, words):
    pytest.importorskip("flint")
    holds(monkeypatch, PROOFS[words])


def test_every_option_has_a_row_or_is_of_an_answers_form():
    known: dict[str, set[str]] = {}
    for case in (CASES | PROOFS).values():
        known.setdefault(case.words.split()[0], set()).update(case.words.split(), *(r.words.split() for r in case.rows))
    context, lacking = click.Context(main), []
    for name in main.list_commands(context):
        command = main.get_command(context, name)
        assert command is not None
        lacking += [
            f"{name} {option.opts}"
            for option in command.params
            if isinstance(option, click.Option)
            and option.name not in ANSWER
            and not known.get(name, set()) & {*option.opts, *option.secondary_opts}
        ]
    assert not lacking


@pytest.mark.parametrize("form", [(), ("--json",)])
def test_a_comparison_of_nothing_selects_nothing(monkeypatch, form):
    monkeypatch.setattr("cross_checks.contact.by_figure.with_contact", dict)
    monkeypatch.setattr("cross_checks.contact.by_figure.compare", lambda *given, **more: [])
    assert CliRunner().invoke(main, ["contact", "--figures", *form], prog_name="mbs-ref").exit_code == 5


PROGRESS: dict[str, tuple[str, list[tuple[int, int, str]]]] = {  # of a case: the title, and what is reported
    "ensemble pendulum --vary mass=1..2": ("ensemble pendulum", []), "prove pendulum": ("prove pendulum", []),
    "animate pendulum": ("animate pendulum", [
        (0, 3, "runs"), (1, 3, "is drawn, frame by frame"), (2, 3, "is drawn side by side")]),
    "certify pendulum": ("certify", [(0, 1, "pendulum")]), "check pendulum": ("check", []), "report": ("report", []),
    "sweep kepler": ("sweep kepler", []), "calibrate": ("calibrate", [(0, 500, "seed 0")]),
    "symmetry": ("symmetry", [(0, 3, TWO[0].name)]), "proofs": ("prove", [(0, 3, "pendulum")]),
    "judge f.csv pendulum": ("reading rows of f.csv", []), "repeatability": ("repeatability", []),
    "extremes": ("extremes", []), "compare . .": ("compare", []), "contact --tosses": ("tosses", []),
}  # fmt: skip


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", PROGRESS)
def test_progress_names_what_is_done_and_counts_up_to_its_total(monkeypatch, words):
    if words in PROOFS:
        pytest.importorskip("flint")
    titles: list[str] = []
    said: list[Any] = []

    class Noted:
        def __init__(self, title: str) -> None:
            titles.append(title)

        def __call__(self, *given: Any) -> None:
            said.append(given)

    monkeypatch.setattr("reports.console.Lines", Noted)
    arrived(monkeypatch, (CASES | PROOFS)[words])
    title, expected = PROGRESS[words]
    assert (titles, said) == ([title], expected)
