"""What the store of runs holds for a report, and which data a page, a plot and the environment show of it."""

from __future__ import annotations

import json
import random
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import history
from benchmarks.history import Entry
from cross_checks import engines
from cross_checks.judge.answers import Answer, Question
from cross_checks.judge.runs import PASSING
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.records import lines
from cross_checks.records import record as machine
from cross_checks.records.plots import FLOOR, Figure
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from cross_checks.truths.truth import NoTruth
from mbs_ref import Settings, scenes
from mbs_ref.simulate import simulate
from reports.cli import main
from reports.facts import environment, stored
from reports.page.render import pages
from reports.page.sections.matrix import view
from reports.page.slug import slug
from reports.poses_file import write_poses
from tests.reports.page.test_shown_figures import irregular

SCENE = scenes.make("pendulum")


@dataclass(frozen=True)
class Fact:
    name: str
    value: float | None


def test_facts_come_back_and_are_made_once():
    made: list[int] = []

    def make() -> tuple[Fact, ...]:
        made.append(1)
        return Fact("a", 0.1), Fact("b", None)

    with Store() as store:
        kind: Any = tuple[Fact, ...]
        assert stored.recall(store, "key", kind) is None
        for _ in range(2):
            assert stored.remembered(store, "key", kind, make) == (Fact("a", 0.1), Fact("b", None))
        assert stored.remembered(store, "other", Fact, lambda: Fact("c", 2.0)) == Fact("c", 2.0)
        with pytest.raises(ValueError, match="not JSON compliant"):
            stored.keep(store, "bad", Fact, Fact("d", float("inf")))
        assert stored.recall(store, "bad", Fact) is None
    assert made == [1]


@pytest.mark.parametrize("full", [False, True])
def test_settled_answers_are_stored_unless_the_machine_had_a_part(monkeypatch, full):
    chance, names = random.Random(3), [method.name for method in engines.get("mbs_ref").methods()][:8]
    wanted = [Question(SCENE, "mbs_ref", engines.get("mbs_ref").method(name)) for name in names]
    statuses = [chance.choice(("success", "crashed", *PASSING)) for _ in names]
    settled = [chance.random() < 0.6 for _ in names]
    longest: list[float] = []

    def answers(runs: Any, asked: Any, progress: Any, preparations: Any) -> Any:
        longest.append(runs.longest)
        for question, status, is_settled in zip(asked, statuses, settled, strict=True):
            record = Record(SCENE.name, {}, "mbs_ref", question.method.name, {}, status)
            cell = Cell(SCENE.name, {}, "mbs_ref", question.method.name, Verdict.AGREES, "")
            yield Answer(question, cell, (record,), NoTruth(""), is_settled)

    monkeypatch.setattr(stored, "answers", answers)
    with Store() as store:
        found = list(stored.settled_answers(store, wanted, lambda *given: None, None, full))
        held = stored.stored_answers(store, wanted, full)
        other = stored.stored_answers(store, wanted, not full)
    assert [answer.cell.method for answer in found] == [
        name for name, ended in zip(names, settled, strict=True) if ended
    ]
    expected = {name for name, status, ended in zip(names, statuses, settled, strict=True)
                if ended and status not in PASSING}  # fmt: skip
    assert {question.method.name for question in held if question.method} == expected
    for question, one in held.items():
        assert question.method
        assert (one.cell.method, one.records[0].method) == (question.method.name, question.method.name)
    assert other == {}
    assert np.isinf(longest[0]) == full


def test_a_page_shows_what_concerns_it():
    data = irregular(2)
    for page in pages(data):
        labels, names = {r.label for r in page.data.records}, {r.engine for r in page.data.records}
        assert labels == ({page.title} if page.kind == "scene" else set(data.scenes))
        assert names == ({page.title} if page.kind == "engine" else set(data.engines))
        assert {c.label for c in page.data.cells} == labels
        assert {c.engine for c in page.data.cells} == names
    kinds = [page.kind for page in pages(data)]
    assert kinds.count("scene") == len(data.scenes)
    assert kinds.count("engine") == len(data.engines)


@pytest.mark.parametrize("seed", range(3))
def test_a_part_of_a_report_holds_what_was_chosen_alone(seed):
    data, chance = irregular(seed), random.Random(seed)
    facts: Any = [SimpleNamespace(scene=label, engine=name) for label in data.scenes for name in data.engines]
    data = replace(data, truths=facts, mechanisms=facts, capabilities=facts, extremes=facts)
    for _ in range(5):
        labels, names, targets = (
            chance.sample(list(of), chance.choice((0, 1, 2))) for of in (data.scenes, data.engines, data.targets)
        )
        part = data.only(labels, names, targets)
        of_scene, of_engine = set(labels or data.scenes), set(names or data.engines)
        for one, whole in ((part.cells, data.cells), (part.records, data.records)):
            assert set(map(id, one)) == {id(x) for x in whole if x.label in of_scene and x.engine in of_engine}
        assert list(part.truths) == list(part.mechanisms) == [x for x in facts if x.scene in of_scene]
        assert list(part.capabilities) == list(part.extremes) == [x for x in facts if x.engine in of_engine]
        assert list(part.targets) == [x for x in data.targets if x in targets or not targets]
        for cell in part.cells:
            shown = view(cell, part.targets)["targets"]
            assert len(shown) == sum(result.target in part.targets for result in cell.targets)


def test_no_two_labels_share_a_file():
    labels = ["a", "a b", "a-b", "a/b", "a<b", "a>b", " a", "a ", "é", "x" * 99, "x" * 98]
    assert len(set(map(slug, labels))) == len(labels)


def test_the_environment_states_every_engine_and_package():
    found = environment.environment()
    for name in engines.names():
        try:
            expected = engines.get(name).version()
        except engines.EngineMissing as error:
            expected = f"missing: {error}"
        assert found[f"engine {name}"] == expected
    assert found["numpy"] == np.__version__
    assert environment.package_version("no-such-package") == "not installed as a package"
    assert found["processor"] == machine.processor()


def test_a_processor_is_the_first_model_that_the_system_names(monkeypatch, tmp_path):
    file = tmp_path / "cpuinfo"
    file.write_text("processor\t: 0\nmodel\t\t: 85\nmodel name\t: Fast 3000: X\nmodel name\t: Slow\n")
    monkeypatch.setattr(machine, "CPU_FACTS", file)
    assert machine.processor() == "Fast 3000: X"
    file.write_text("processor\t: 0\n")
    monkeypatch.setattr(machine.platform, "processor", lambda: "")
    monkeypatch.setattr(machine.platform, "machine", lambda: "x86_64")
    assert machine.processor() == "x86_64"
    monkeypatch.setattr(machine, "CPU_FACTS", tmp_path / "none")
    monkeypatch.setattr(machine.platform, "processor", lambda: "named")
    assert machine.processor() == "named"


@pytest.fixture
def drawn(monkeypatch) -> list[Figure]:
    """Return the figures that commands write from now on."""
    figures: list[Figure] = []
    monkeypatch.setattr(Figure, "to_html", lambda self, **given: figures.append(self) or "")
    return figures


def run(*words: str) -> Any:
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


def test_trends_of_each_unit_with_rings_where_levels_change(monkeypatch, tmp_path, drawn):
    chance = random.Random(4)
    made = [Entry(f"j{k}", f"2026-01-{k + 1:02d}", f"c{k}", "box", name, chance.uniform(0.5, 2.0), unit, f"v{k}")
            for name, unit in (("chain", "1"), ("track", "s"), ("top", "s")) for k in range(5)]  # fmt: skip
    lines.append(tmp_path / "h.jsonl", made)
    monkeypatch.setattr(history, "change_points", lambda values: [k for k, x in enumerate(values) if x > 1.2])
    assert run("history", "--file", str(tmp_path / "h.jsonl"), "-o", str(tmp_path / "t.html")).exit_code == 0
    assert [figure.layout["yaxis"]["title"]["text"] for figure in drawn] == [
        "ratio to the job's own baseline",
        "time, s",
    ]
    assert [figure.layout["yaxis"]["type"] for figure in drawn] == ["-", "log"]
    for figure, names in zip(drawn, (["chain"], ["top", "track"]), strict=True):
        assert [line["name"] for line in figure.data[::2]] == names
        for line, rings, name in zip(figure.data[::2], figure.data[1::2], names, strict=True):
            own = [e for e in made if e.series == name]
            assert list(zip(line["x"], line["y"], line["text"], strict=True)) == [
                (e.made, e.value, f"{e.commit_id} {e.verdict}") for e in own]  # fmt: skip
            assert list(zip(rings["x"], rings["y"], strict=True)) == [(e.made, e.value) for e in own if e.value > 1.2]


def test_the_plot_of_a_judgement_has_its_curves(tmp_path, drawn):
    path = simulate(SCENE, Settings(method="rk4", step=0.01, samples=6, t_end=0.5, estimate="off"))
    write_poses(replace(path, position=1.001 * path.position), list(SCENE.body_names), tmp_path / "true.npz")
    path.velocity[:] = np.nan
    write_poses(path, list(SCENE.body_names), tmp_path / "run.csv")
    text = (tmp_path / "run.csv").read_text().splitlines()
    kept = [k for k, name in enumerate(text[0].split(",")) if name.split(".")[-1] not in ("vx", "vy", "rate")]
    (tmp_path / "few.csv").write_text("\n".join(",".join(line.split(",")[k] for k in kept) for line in text))
    words = ("judge", str(tmp_path / "few.csv"), "pendulum", "--t-end", "0.5", "--error", "1", "--against",
             str(tmp_path / "true.npz"))  # fmt: skip
    assert run(*words, "--plot", str(tmp_path / "plot.html")).exit_code == 0
    curves = json.loads(run(*words, "--json").stdout)["curves"]
    (figure,) = drawn
    shown = {name: curve for name, curve in curves.items() if name != "t" and any(curve)}
    assert {line["name"]: line["y"] for line in figure.data} == {
        name: [None if x is None else max(x, FLOOR) for x in curve] for name, curve in shown.items()}  # fmt: skip
    assert all(line["x"] == curves["t"] for line in figure.data)
    assert SimpleNamespace(**figure.layout["xaxis"]).type == "-"
