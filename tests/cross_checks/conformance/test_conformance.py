"""The examination of engines, on the one of the docs, on spoiled copies of it, and on ones with a mistake."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from cross_checks import engines
from cross_checks.conformance import loading
from cross_checks.conformance.broken_engines import Broken, Mistake, mistakes
from cross_checks.conformance.examine import examine
from cross_checks.conformance.finding import Report
from cross_checks.conformance.probes import probes
from cross_checks.conformance.questions import SPANS, questions, uncovered
from cross_checks.engine import SINGLE, Method
from reports.commands.engines.conformance import command
from tests.cross_checks.engines.engine_runs import engine

GUIDE = Path(__file__).parents[3] / "docs" / "your-engine.md"
EXPECTED = {  # the question that must notice each mistake; others may too
    "dropped joint": "joints",
    "inertia about another point": "truth",
    "inertia in wrong axes": "truth",
    "gravity off by a thousandth": "truth",
    "hidden damping": "energy",
    "one step late": "order",
    "lost order": "order",
    "state restarted half-way": "truth",
    "sliders that do not slide": "truth",
    "torques in wrong axes": "truth",
    "stopped by every weld": "something runs",
    "single precision": "truth",
    "velocities of the other sign": "velocities",
    "velocities times 1.01": "velocities",
    "velocities zero but the first": "velocities",
    "velocities one sample late": "velocities",
    "angular velocities zero but the first": "velocities",
    "angular velocities in body axes": "velocities",
    "bodies swapped": "truth",
    "orientations of the other sign": "truth",
    "angles wrong, positions right": "truth",
    "a clock that lies": "clock",
    "a clock beyond the call": "clock",
    "a clock that counts two fifths": "clock",
    "bodies that pass through each other": "contact",
    "contacts without loss": "contact",
    "samples at other times": "asked times",
}

FEW = ("pendulum", "double_pendulum", "torque_free_top", "spatial_n_four_bar", "bouncing_ball")
# A joint, a load, a drive and a bushing, a weld in plane and space; `test_a_good_engine_raises_no_alarm` has all parts.
PROBED = (("weld", 2), ("weld", 3), ("bushing", 3), ("prismatic", 3), ("spring_damper", 3), ("rotation_drive", 3))
CLOCKS = {"a clock beyond the call", "a clock that counts two fifths"}  # further ones: slow, see test_clocks.py, too
SHOWN_BY = {  # the scene of each mistake that the double pendulum does not show
    "inertia in wrong axes": "torque_free_top",
    "angular velocities in body axes": "torque_free_top",
    "bodies that pass through each other": "bouncing_ball",
    "contacts without loss": "bouncing_ball",
}
BY_PROBES = {  # the parts in space that notice a mistake; the library has none such
    "sliders that do not slide": ("prismatic", "cylindrical"),
    "torques in wrong axes": ("torque_vector",),
    "stopped by every weld": ("weld",),
}


def small_engine() -> str:
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    return code


def written(tmp_path: Path, code: str, name: str) -> Path:
    """Write an adapter under a name of its own: a module is imported once in a process."""
    file = tmp_path / f"{name}_.py"
    file.write_text(code.replace('"small"', f'"{name}"'))
    return file


@pytest.fixture
def conformance(monkeypatch):
    """Return the command, leaving the environment as it was."""
    monkeypatch.setenv(engines.ADAPTERS, "")
    return lambda *arguments: CliRunner().invoke(command, [str(argument) for argument in arguments])


def test_the_engine_of_the_docs_conforms_and_its_figures_are_printed(tmp_path, conformance):
    done = conformance(written(tmp_path, small_engine(), "small"), "--json", tmp_path / "found.json")
    assert done.exit_code == 0, done.output
    assert re.search(r"pendulum +rk4 +4(\.\d+)? +4 +\d(\.\d+)?e-\d\d", done.output)
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["conforms"]
    assert {finding["question"] for finding in found["findings"]} >= {"truth", "velocities", "clock", "energy", "order"}


@pytest.mark.parametrize(
    ("name", "right", "wrong", "noticed"),
    [
        ("lame", "2 * k2 + 2 * k3 + k4)", "2 * k2 + 3 * k3)", "order"),
        pytest.param(
            "light",
            "np.dot(tangent, self.gravity) /",
            "1.01 * np.dot(tangent, self.gravity) /",
            "truth",
            marks=pytest.mark.slow,
        ),
        pytest.param("fast", "speed = (", "speed = -3 * (", "velocities", marks=pytest.mark.slow),
    ],
)
def test_a_mistake_in_it_is_found(tmp_path, conformance, name, right, wrong, noticed):
    assert right in small_engine()
    done = conformance(written(tmp_path, small_engine().replace(right, wrong), name))
    assert done.exit_code != 0
    assert f"FAILED: {noticed}" in done.output


@pytest.mark.parametrize(
    ("name", "instead", "said"),
    [
        ("hangs", "__import__('time').sleep(1e3)", "gave no answer within 2 s and was stopped"),
        ("dies", "__import__('os')._exit(3)", "its process ended with exit code 3"),
    ],
)
def test_runs_that_do_not_come_back_are_named_and_the_examination_ends(tmp_path, conformance, name, instead, said):
    """Runs with the finest step alone: the others still answer."""
    right = "        states = [y]\n"
    assert right in small_engine()
    lame = small_engine().replace(right, f"{right}        if h < 4e-3:\n            {instead}\n")
    done = conformance(written(tmp_path, lame, name), "--timeout", 2)
    assert done.exit_code == 1
    assert re.search(rf"FAILED: comes back: pendulum rk4: step=0.0025: {said}", done.output), done.output
    assert re.search(r"pendulum +rk4 +4(\.\d+)? +4", done.output)


@pytest.mark.parametrize(
    ("name", "right", "wrong", "said"),
    [
        ("lineless", "ENGINE = Small", "", "has no line ENGINE = <class>; add ENGINE = Small"),
        ("renamed", 'name, package = "renamed"', 'name, package = "other"', "its class is named 'other'"),
        ("nameless", 'name, package = "nameless", "numpy"', "", "has no name"),
        ("unmade", "ENGINE = Small", "ENGINE = lambda size: Small()", "cannot be made"),
    ],
)
def test_an_adapter_that_cannot_be_used_is_told_what_to_change(tmp_path, conformance, name, right, wrong, said):
    file = written(tmp_path, small_engine(), name)
    assert right in file.read_text()
    file.write_text(file.read_text().replace(right, wrong))
    done = conformance(file)
    assert done.exit_code == 2
    assert said in done.output


def examined(mistake: Mistake, name: str = "mbs_ref") -> Report:
    return examine(Broken(engines.get(name), mistake), name)


def test_every_mistake_has_its_question():
    assert {mistake.name for mistake in mistakes()} == set(EXPECTED)


@pytest.fixture
def few(monkeypatch):
    """Ask about a few scenes and parts; the returned function chooses others."""
    every = probes()

    def asked(parts: Iterable[tuple[str, int]], names: Iterable[str] = FEW) -> None:
        chosen = {part: every[part] for part in parts}
        monkeypatch.setattr("cross_checks.conformance.questions.probes", lambda: chosen)
        monkeypatch.setattr("cross_checks.conformance.questions.SPANS", {name: SPANS[name] for name in names})

    asked(PROBED)
    return asked


def test_the_engine_without_a_mistake_raises_no_alarm(few):
    few((("weld", 2), ("spring_damper", 3)), ("double_pendulum", "torque_free_top", "bouncing_ball"))
    assert [finding for finding in examined(Mistake("none")).of("failed")] == []


def test_every_part_that_an_engine_declares_is_asked_or_told(few):
    """A joint that it is asked for in the plane is asked for in space, too."""
    solver = engines.get("mbs_ref")
    asked = questions(solver)
    names = {question.scene.name for question in asked}
    assert names >= {"weld_in_plane", "weld_in_space", "prismatic_in_space", "spring_damper_in_space"}
    unprobed = uncovered(solver, asked)
    assert "pin_on_sprocket" in unprobed
    assert not {"weld", "bushing", "prismatic", "spring_damper", "rotation_drive"} & {*unprobed}


@pytest.mark.parametrize("mistake", [
    pytest.param(each, marks=[pytest.mark.slow] * (each.name in CLOCKS)) for each in mistakes()
], ids=lambda mistake: mistake.name)  # fmt: skip
def test_every_mistake_is_noticed_by_its_question(mistake, few, monkeypatch):
    """One scene, and the small ones for some parts, are enough."""
    few([(kind, 3) for kind in BY_PROBES.get(mistake.name, ())], [SHOWN_BY.get(mistake.name, "double_pendulum")])
    if EXPECTED[mistake.name] != "clock":
        monkeypatch.setattr("cross_checks.conformance.examine.uncounted_work", lambda *arguments: "")
    assert EXPECTED[mistake.name] in {finding.question for finding in examined(mistake).of("failed")}


class Declared(Broken):
    """One that says what its arithmetic is."""

    def methods(self) -> tuple[Method, ...]:
        return tuple(replace(method, roundoff=SINGLE) for method in super().methods())


def test_single_precision_that_is_declared_is_forgiven_its_errors(few):
    """Its order is asked all the same, of the few coarse runs that rounding leaves of a method of order four."""
    few([], ("pendulum", "double_pendulum"))
    (rounded,) = (mistake for mistake in mistakes() if mistake.name == "single precision")
    report = examine(Declared(engines.get("mbs_ref"), rounded), "mbs_ref")
    assert {finding.question for finding in report.of("failed")} <= {"order"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["exudyn", "mbs_ref", "mujoco", "pinocchio", "pinocchio_cpp", "rebound"])
def test_a_good_engine_raises_no_alarm(name):
    report = examine(engine(name), name)
    assert [f"{f.question}: {f.scene} {f.method}: {f.detail}" for f in report.of("failed")] == []


@pytest.mark.parametrize(("source", "named"), [
    ("", "<your class>"), ("class Toy(Engine): ...\n", "Toy"),
    ("class Base(Engine): ...\nclass Toy(base.Engine): ...\nclass Other: ...\n", "Toy"),
])  # fmt: skip
def test_the_message_on_a_missing_line_names_the_last_class_of_the_file(tmp_path, source, named):
    file = tmp_path / "toy_.py"
    file.write_text(source)
    said = loading._explained(str(file), AttributeError("module 'toy_' has no attribute 'ENGINE'"))
    assert said == f"{file} has no line ENGINE = <class>; add ENGINE = {named}"
