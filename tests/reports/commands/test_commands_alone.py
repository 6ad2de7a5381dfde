"""What commands make of what they call, where that is replaced by made-up answers: order, words, files, exit codes."""

from __future__ import annotations

import json
import random
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.trees import regression
from cross_checks.conformance import broken_engines
from cross_checks.conformance.broken_engines import Caught
from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.extremes.fate import Fate
from cross_checks.isolation.environments import PROJECT, NotMade
from cross_checks.judge.vocabulary import OURS
from cross_checks.truths.certificate import Certificate
from mbs_ref import scenes
from mbs_ref.scene.toml import SceneFileError
from reports import console
from reports.commands.engines import engines as engines_command
from reports.commands.judge import certify, proofs
from reports.commands.maintenance import compare, merge
from reports.commands.publish import report, rerun, show
from reports.commands.publish import write as write_command
from reports.commands.run import scenes as scenes_command
from reports.commands.run import simulate
from reports.page.advice import advice
from reports.page.sections.overview import counted
from tests.reports.commands.test_every_table import facts, g, run, tables
from tests.reports.page.test_shown_figures import irregular

__all__ = ["tables"]  # a fixture


@pytest.mark.parametrize(("fate", "code"), [(fate, int(fate == "silently-wrong")) for fate in Fate])
def test_a_cell_of_the_extremes_is_run_again(monkeypatch, fate, code):
    asked: list[Any] = []
    made = ExtremeCell("overflow", "family", "exudyn", "m", False, fate, 2.5, (), "why")
    solver = SimpleNamespace(name="exudyn", method=lambda name: SimpleNamespace(name=name))
    monkeypatch.setattr(rerun.inputs, "engine", {"exudyn": solver}.__getitem__)
    monkeypatch.setattr(rerun, "Isolated", lambda: nullcontext("call"))
    monkeypatch.setattr(rerun, "cell_of", lambda *given: asked.append(given) or made)
    done = run("rerun", "overflow/exudyn/trapezoidal")
    assert done.exit_code == code
    printed = json.loads(done.stdout)
    assert (printed["fate"], printed["last"], printed["reason"]) == (fate, 2.5, "why")
    ((extreme, engine, method, full, call),) = asked
    assert (extreme.name, engine, method.name, full, call) == ("overflow", solver, "trapezoidal", False, "call")


def test_a_study_is_measured_again_and_a_cell_without_three_parts_is_none(monkeypatch):
    monkeypatch.setattr(rerun, "measure", lambda name: {"measured": name})
    assert json.loads(run("rerun", "space").stdout) == {"measured": "space"}
    for cell in ("pendulum/mbs_ref", "a/b/c/d", "nothing"):
        assert run("rerun", cell).exit_code == 2


def test_the_report_in_the_terminal(monkeypatch, tables):
    """The first screen's line of each engine, then every scene once."""
    data = irregular(1)
    shown: list[str] = []
    monkeypatch.setattr(show, "_print", lambda data, label, as_csv, as_json: shown.append(label))
    show.print_report(data)
    (table,) = tables
    assert table.title == counted(data)
    assert table.head == ["engine", "use", "reaches", "wrong with success reported", "pace"]
    assert table.rows == [
        [a.engine, a.use, a.reach, "; ".join(a.silent) or "none", a.pace or "-"] for a in advice(data)
    ]
    assert shown == data.scenes


@pytest.mark.parametrize(("state", "opens", "code", "said"), [
    ("", True, 0, ""), ("", False, 0, "yourself"), ("interrupted after 3 cells", True, 4, "shows what there"),
])  # fmt: skip
def test_a_report_is_opened_once_it_is_whole(monkeypatch, tmp_path, state, opens, code, said):
    opened: list[Path] = []
    page, text = tmp_path / "index.html", []
    monkeypatch.setattr("reports.gather.Gathering", lambda *given: SimpleNamespace(stages=lambda: "stages"))
    monkeypatch.setattr("reports.page.build.write_report", lambda *given: (page, state))
    monkeypatch.setattr(report, "Store", lambda path: nullcontext())
    monkeypatch.setattr(report, "_open", lambda page: opened.append(page) or opens)
    monkeypatch.setattr(show, "last_report", lambda folder: ("data", folder))
    monkeypatch.setattr(show, "print_report", text.append)
    done = run("report", "-o", str(tmp_path), "--open", "--text")
    assert done.exit_code == code
    assert done.stdout.splitlines() == [str(page)]
    assert said in done.stderr
    assert (opened, text) == ([] if state else [page], [("data", tmp_path)])


@pytest.mark.parametrize(("platform", "screens", "launched", "opened"), [
    ("darwin", {}, 0, True), ("win32", {}, 1, False), ("linux", {}, 0, False), ("linux", {"DISPLAY": ":0"}, 0, True),
    ("linux", {"WAYLAND_DISPLAY": "w"}, 0, True),
])  # fmt: skip
def test_a_page_is_opened_where_there_is_a_screen(monkeypatch, tmp_path, platform, screens, launched, opened):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in screens.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(report.sys, "platform", platform)
    asked: list[str] = []
    monkeypatch.setattr(report.click, "launch", lambda address: asked.append(address) or launched)
    assert report._open(tmp_path) is opened
    assert asked == ([tmp_path.as_uri()] if platform != "linux" or screens else [])


@pytest.mark.parametrize("named", [True, False])
def test_stores_are_merged_and_what_was_added_is_counted(monkeypatch, tmp_path, named):
    files = [tmp_path / f"{k}.sqlite" for k in range(3)]
    for file in files:
        file.touch()
    asked: list[Path] = []

    class Held:
        def __init__(self, path: Path) -> None:
            self.path = path

        def merge(self, other: Path) -> int:
            asked.append(other)
            return len(asked)

        def __len__(self) -> int:
            return 77

    monkeypatch.setattr(merge, "Store", lambda path: nullcontext(Held(path)))
    monkeypatch.setattr("reports.query.default_path", lambda: Path("usual"))
    done = run("merge", *map(str, files), *(["--store", "own"] if named else []))
    assert done.stdout == f"6 runs added; {'own' if named else 'usual'} holds 77\n"
    assert asked == files


@pytest.mark.parametrize(("by", "alarms", "code", "said"), [
    (("order", "truth"), (), 0, "2 of 2 mistakes noticed, 0 false alarms"),
    (("order", ""), (), 1, "1 of 2 mistakes noticed, 0 false alarms"),
    (("order", "truth"), ("start",), 1, "2 of 2 mistakes noticed, 1 false alarms"),
    (("start", "truth"), ("start",), 1, "1 of 2 mistakes noticed, 1 false alarms"),
])  # fmt: skip
def test_a_self_test_fails_where_a_mistake_is_missed_or_there_is_none(monkeypatch, by, alarms, code, said):
    made = [Caught("none", False, alarms), *(Caught(f"m{k}", True, (one,) if one else ()) for k, one in enumerate(by))]
    monkeypatch.setattr(broken_engines, "self_test", lambda good, examine: iter(made if good.name == OURS else []))
    done = run("conformance", "--self-test")
    assert done.exit_code == code
    *listed, last = done.stdout.splitlines()
    assert last == said
    assert [line.split(maxsplit=1) for line in listed] == [
        [one.mistake, ", ".join(one.by) or "nothing noticed"] for one in made]  # fmt: skip


# --- environments of engines -------------------------------------------------------------------------------


@pytest.fixture
def made(monkeypatch) -> list[Any]:
    """Let environments be made by a function that notes what it is given."""
    asked: list[Any] = []
    monkeypatch.setattr(
        engines_command.environments, "make",
        lambda name, wanted, into, over: asked.append((name, wanted, into, over)) or Path("home"),
    )  # fmt: skip
    monkeypatch.setattr(engines_command.environments, "forget", lambda name: asked.append(name))
    monkeypatch.setattr(engines_command, "_requirements", lambda name: [f"{name}==1"])
    monkeypatch.setattr(engines_command.engines, "get", lambda name: SimpleNamespace(version=lambda: "9.9"))
    return asked


@pytest.mark.parametrize(("words", "into", "over", "more"), [
    ([], None, False, []), (["--over"], None, True, []), (["--into", "b"], Path("b"), False, []),
    (["--with", "x", "--with", "y>2"], None, False, ["x", "y>2"]),
])  # fmt: skip
def test_an_environment_is_made_of_what_is_asked(monkeypatch, tmp_path, made, words, into, over, more):
    monkeypatch.chdir(tmp_path)
    done = run("engines", "install", "exudyn", *words)
    assert (done.exit_code, done.stdout) == (0, "exudyn 9.9 lives in home\n")
    wanted = [*([] if over else [str(PROJECT)]), "exudyn==1", *more]
    assert made == [("exudyn", wanted, into, over)]
    assert done.stderr == f"installing {', '.join(wanted)}\n"


def test_an_environment_that_does_not_work_is_forgotten_and_one_that_cannot_be_is_refused(monkeypatch, tmp_path, made):
    def absent(name: str) -> Any:
        raise engines_command.engines.EngineMissing("it needs more")

    def not_made(*given: Any, **more: Any) -> Any:
        raise NotMade("pip fails")

    (tmp_path / "thing").touch()
    for words in (["mbs_ref"], ["no_engine"], ["exudyn", "--into", str(tmp_path)]):
        assert run("engines", "install", *words).exit_code == 2
    assert made == []
    monkeypatch.setattr(engines_command.engines, "get", absent)
    done = run("engines", "install", "exudyn")
    assert (done.exit_code, made[1:]) == (1, ["exudyn"])
    assert "it needs more; what else it needs can be named by --with" in done.stderr
    monkeypatch.setattr(engines_command.environments, "make", not_made)
    done = run("engines", "install", "exudyn")
    assert (done.exit_code, "pip fails" in done.stderr) == (1, True)


def test_an_engine_is_forgotten_or_has_nothing_to_forget(monkeypatch):
    monkeypatch.setattr(engines_command.environments, "forget", lambda name: Path("home") if name == "drake" else None)
    monkeypatch.setattr(engines_command.environments, "homes", lambda: {"drake": 1, "newton": 2})
    assert run("engines", "forget", "drake").stdout.startswith("drake is run from here again; its environment home may")
    done = run("engines", "forget", "exudyn")
    assert (done.exit_code, "those that have: drake, newton" in " ".join(done.stderr.split())) == (2, True)


def test_an_engine_requires_its_extra_or_one_of_ours_the_usual(monkeypatch):
    listed = ["numpy>2", 'drake>=1.5 ; python_version > "3" and extra == "drake"', "mujoco<4; extra == 'engines'",
              'exudyn; extra == "engines"']  # fmt: skip
    held = SimpleNamespace(get_all=lambda name: ["drake", "engines"] if name == "Provides-Extra" else [])
    monkeypatch.setattr(engines_command, "requires", lambda name: listed)
    monkeypatch.setattr(engines_command, "metadata", lambda name: held)
    monkeypatch.setattr(engines_command.engines, "is_ours", lambda name: name != "strange")
    found = {name: engines_command._requirements(name) for name in ("drake", "mujoco", "strange")}
    assert found == {"drake": ["drake>=1.5"], "mujoco": ["mujoco<4", "exudyn"], "strange": []}

    def absent(name: str) -> Any:
        raise engines_command.PackageNotFoundError

    monkeypatch.setattr(engines_command, "metadata", absent)
    assert engines_command._requirements("drake") == []
    monkeypatch.setattr(engines_command.environments, "PROJECT", Path("nowhere"))
    monkeypatch.setattr(engines_command, "version", lambda name: "1.2.3")
    assert engines_command._ourselves() == "mbs-ref==1.2.3"


# --- truths, proofs and trees ------------------------------------------------------------------------------


def test_every_truth_is_that_of_a_certificate_or_of_a_scene_with_one(monkeypatch):
    about = ("exact", "how", 1.0, 1.0, {}, "x", 1.0, "2026", {})
    made = [Certificate("pendulum", {"length": x}, 1.0, 41, *about) for x in (1.0, 2.0)]
    monkeypatch.setattr(certify.certificate, "every", lambda: made)
    monkeypatch.setattr(certify, "known", lambda: ["kepler", "pendulum", "no_scene"])
    found = certify.every_truth()
    assert [(one.name, one.parameters.get("length")) for one in found] == [
        ("pendulum", 1.0), ("pendulum", 2.0), ("kepler", None)]  # fmt: skip
    monkeypatch.setattr(proofs, "every_truth", lambda: found)
    pytest.importorskip("flint")
    from cross_checks.truths.proofs import coverage

    monkeypatch.setattr(coverage, "complaints", lambda made: iter(["no"] if made.name == "kepler" else []))
    assert proofs._covered() == found[:2]


def test_a_certificate_is_written_once_it_is_judged_by_the_one_before(monkeypatch, tables):
    order: list[Any] = []
    about = ("exact", "how", 0.1, 1.0, {"a": [0.0, 0.0]}, "x", 1.0, "2026", {})
    fresh = Certificate("pendulum", {}, 1.0, 41, *about)
    monkeypatch.setattr(certify, "store_poses", lambda scene: order.append("poses"))
    monkeypatch.setattr(certify, "certify", lambda scene, confirm: order.append(confirm) or fresh)
    monkeypatch.setattr(certify.certificate, "stored", lambda scene: order.append("before"))
    monkeypatch.setattr(certify.certificate, "write", order.append)
    for words, steps in (([], [False, "before"]), (["--write"], ["poses", True, "before", fresh])):
        assert run("certify", "pendulum", *words).exit_code == 0
        assert order == steps
        order.clear()


@pytest.mark.parametrize("only", ["", "chain"])
def test_right_hand_sides_of_two_trees_in_a_table(monkeypatch, tables, only):
    """Each stated scene by the baseline first, then the current tree."""
    chance, asked = random.Random(2), []

    def rate_of(old: str, new: str, scene: str, parameters: dict[str, Any]) -> regression.Rate:
        asked.append((old, new))
        return regression.Rate(scene, parameters, *(10 ** chance.uniform(0, 4) for _ in range(3)))

    stated = {"rates": [("pendulum_chain", {"links": 3}), ("kepler", {}), ("spatial_chain", {})]}
    monkeypatch.setattr(regression, "STATED", stated)
    monkeypatch.setattr(regression, "Tree", lambda folder: nullcontext(f"tree {folder}"))
    monkeypatch.setattr(regression, "rate_of", rate_of)
    monkeypatch.setattr(compare, "tree", lambda name: nullcontext(f"folder {name}"))
    words = ("compare", "a", "b", "--rates", *(["--only", only] if only else []))
    assert run(*words).exit_code == 0
    assert set(asked) == {("tree folder a", "tree folder b")}
    chance.seed(2)
    printed = json.loads(run(*words, "--json").stdout)
    (table,) = tables
    names = ["scene", "parameters", "old_ns_per_body", "new_ns_per_body", "ratio"]
    assert table.head == names
    assert table.rows == [
        [row["scene"], str(row["parameters"]), *(g(row[key]) for key in names[2:])] for row in printed
    ]
    assert [row["scene"] for row in printed] == [name for name, _ in stated["rates"] if only in name]


def test_a_tree_is_a_folder_or_a_checkout_that_passes(monkeypatch, tmp_path):
    called: list[Any] = []

    def ran(words: list[str], **more: Any) -> Any:
        called.append((words, more.get("cwd")))
        return SimpleNamespace(returncode=words[-1] == "no", stderr="unknown revision\n")

    with compare.tree(str(tmp_path)) as found:
        assert found == tmp_path
    monkeypatch.setattr(compare.subprocess, "run", ran)
    with compare.tree("HEAD~3") as found:
        assert found.is_dir()
    assert not found.exists()
    archive = f"{found}/tree.tar"
    assert called == [(["git", "archive", "--output", archive, "HEAD~3"], None),
                      (["tar", "-xf", "tree.tar"], str(found))]  # fmt: skip
    refused = r"'no' is neither a folder nor a git revision: unknown revision$"
    with pytest.raises(compare.click.UsageError, match=refused), compare.tree("no"):
        pass


# --- scenes, their files and their runs --------------------------------------------------------------------


def test_scenes_that_cannot_be_written_are_named_and_the_others_written(monkeypatch, tmp_path):
    def write(scene: Any, file: Path) -> None:
        if scene.name == "kepler":
            raise SceneFileError("kepler", ["holds a function"])  # type: ignore[list-item]
        file.write_text(str(scene.parameters.get("length")))

    monkeypatch.setattr(scenes_command, "write_scene", write)
    folder = tmp_path / "new" / "folder"
    done = run("scenes", "pendulum", "kepler", "double_pendulum", "--files", str(folder))
    assert done.exit_code == 1
    assert "not written: kepler" in done.stderr
    assert "holds a function" in done.stderr
    written = [folder / f"{name}.toml" for name in ("pendulum", "double_pendulum")]
    assert done.stdout.splitlines() == list(map(str, written))
    assert sorted(folder.iterdir()) == sorted(written)
    assert run("scenes", "pendulum", "--files", str(folder), "-p", "length=7.5").exit_code == 0
    assert written[0].read_text() == "7.5"
    for words in (["pendulum", "-p", "length=2"], ["pendulum", "kepler", "-p", "length=2", "--files", str(folder)]):
        assert run("scenes", *words).exit_code == 2


@pytest.mark.parametrize(("error", "code"), [(None, 0), (write_command.EngineMissing("absent"), 3),
                                            (write_command.writers.NotWritable("no belts"), 1),
                                            (ValueError("no such method"), 2)])  # fmt: skip
def test_a_scene_is_written_or_the_reason_is_an_exit_code(monkeypatch, tmp_path, error, code):
    def written(scene: Any, form: str, settings: Any) -> str:
        if error is not None:
            raise error
        return f"{scene.name} as {form}"

    monkeypatch.setattr(write_command.writers, "write", written)
    file = tmp_path / "a.py"
    done = run("write", "pendulum", "--as", "exudyn")
    assert done.exit_code == code
    assert done.stdout == ("pendulum as exudyn" if error is None else "")
    assert error is None or str(error) in done.stderr
    assert run("write", "pendulum", "--as", "exudyn", "-o", str(file)).exit_code == code
    assert (file.read_text() if file.exists() else None) == ("pendulum as exudyn" if error is None else None)
    assert run("write", "pendulum", "--as", "mjcf", "-o", str(tmp_path / "a.py")).exit_code == 2
    assert run("write", "pendulum", "--as", "nothing").exit_code == 2


@pytest.mark.parametrize("count", [0, 1, 6, 7])
def test_contacts_that_never_close_are_named_up_to_six(count, capsys):
    """A contact is met where it has a force at any sample, or an event."""
    names = [f"c{k}" for k in range(9)]
    force = np.zeros((4, 9, 3))
    force[2, range(count, 8), 0] = 0.1
    path: Any = SimpleNamespace(
        times=np.linspace(0.0, 0.5, 4), event_times=np.array([[0.1, 1.0]]), event_names=("x", "c8"),
        contacts={name: force[:, k] for k, name in enumerate(names)},
    )  # fmt: skip
    assert simulate.never_closed(path) == names[:count]
    simulate._show_path(scenes.make("pendulum"), path, None, False)  # type: ignore[arg-type]
    said = capsys.readouterr().out
    listed = ", ".join(names[: min(count, 6)]) + (" ..." if count > 6 else "")
    assert said == (f"Never closed in 0.5 s, of 9 contacts: {listed}\n" if count else "")


def test_a_run_without_a_truth_says_what_to_do_next(tables):
    record: Any = SimpleNamespace(error=None, measure=lambda name: None, bounds={})
    simulate._show_error(record, ("a note", "another"))
    shown = tables[0].rows
    assert shown[0] == ["error", "no truth known"]
    assert shown[1:3] == [["note", "a note"], ["note", "another"]]
    assert facts(tables[0])["next"].startswith("mbs-ref check computes")


def test_progress_on_a_terminal_shows_how_much_is_done(monkeypatch):
    seen: list[Any] = []

    class Bar:
        def __init__(self, *columns: Any, **more: Any) -> None: ...

        def __enter__(self) -> Bar:
            return self

        def __exit__(self, *given: object) -> None: ...

        def add_task(self, title: str, total: Any) -> str:
            seen.append((title, total))
            return "task"

        def update(self, task: str, **about: Any) -> None:
            seen.append((task, about))

    monkeypatch.setattr(console, "Progress", Bar)
    monkeypatch.setattr(console.sys.stderr, "isatty", lambda: True, raising=False)
    with console.progress("sweep") as said:
        said(3, 7, "rk4")
        said(4, 7, "")
    assert seen == [("sweep", None), ("task", {"completed": 3, "total": 7, "description": "sweep rk4"}),
                    ("task", {"completed": 4, "total": 7, "description": "sweep"})]  # fmt: skip


def test_kernels_are_compiled_by_the_first_hundredth_of_runs(monkeypatch):
    """A method of fixed steps has two in it, an adaptive one a tolerance; one that refuses the scene is left out.

    The solver chooses a method itself once, too.
    """
    from reports.facts import compiling

    kinds = {"rk4": "fixed", "dop853": "adaptive", "radau": "adaptive", "euler": "fixed"}
    ran, methods = [], [SimpleNamespace(name=name, kind=kind) for name, kind in kinds.items()]
    solver = SimpleNamespace(
        methods=lambda: methods, method=lambda name: methods[1],
        refusal=lambda scene, method: "no" if method is methods[2] else "",
        run=lambda scene, settings: ran.append((scene, settings)),
    )  # fmt: skip
    monkeypatch.setattr(compiling.engines, "get", lambda name: solver)
    for every in (True, False):
        compiling.run_methods("mbs_ref", "pendulum", "relative", every)
        wanted = [one for one in methods if one is not methods[2]] if every else [methods[1]]
        wanted.append(SimpleNamespace(name="auto", kind="adaptive"))
        assert [settings.method for _, settings in ran] == [one.name for one in wanted]
        for (scene, settings), one in zip(ran, wanted, strict=True):
            assert settings.t_end == pytest.approx(0.01 * scene.duration)
            assert (settings.coordinates, settings.estimate, settings.samples) == ("relative", "off", 2)
            step = pytest.approx(0.005 * scene.duration) if one.kind == "fixed" else None
            assert (settings.step, settings.rtol) == (step, 1e-6 if one.kind == "adaptive" else None)
        ran.clear()
    asked: list[Any] = []
    monkeypatch.setattr(compiling, "simulate_scenes", lambda *given, lanes: asked.append((*given, lanes)))
    compiling.run_in_lanes()
    assert [(built[0].name, settings.method, lanes) for built, settings, lanes in asked] == [
        (name, "dop853", True) for name in (
            "double_pendulum", "spatial_chain", "n_four_bar", "spatial_slider_crank", "bouncing_ball")]  # fmt: skip
