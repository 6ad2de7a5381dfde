"""mbs-ref report: what is shown, and in which form."""

from __future__ import annotations

import csv
import re
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from reports import gather
from reports.cli import main
from reports.commands.publish.report import FORMS
from reports.gather import chosen_scenes
from reports.page import build
from reports.page.render import tex
from tests.reports.page.synthetic_report import report_data


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    build.write_data(report_data(), tmp_path)
    return tmp_path


def render(folder: Path, *options: str) -> Path:
    done = CliRunner().invoke(main, ["report", "--render", "-o", str(folder), *options])
    assert done.exit_code == 0, done.output
    return Path(done.stdout.strip())


def test_every_form_is_offered():
    assert set(FORMS) == set(build.FORMS)


def test_only_the_chosen_scene_engine_and_error_are_shown(folder):
    before = (folder / build.DATA).read_bytes()
    file = render(folder, "--format", "csv", "--scene", "slider_crank", "--engine", "mujoco")
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert rows
    assert {(row["scene"], row["engine"]) for row in rows} == {("slider_crank", "mujoco")}
    text = render(folder, "--format", "md", "--target", "1e-6", "--scene", "pendulum").read_text()
    assert "| 1e-6 | mbs_ref |" in text
    assert "| 1e-3 | mbs_ref |" not in text
    assert (folder / build.DATA).read_bytes() == before, "the data stay whole"


def test_a_report_that_is_computed_shows_the_chosen_error_and_keeps_all(tmp_path):
    page, _ = build.write_report(tmp_path, (report_data for _ in range(1)), "md", [1e-6])
    text = page.read_text()
    assert "| 1e-6 | mbs_ref |" in text
    assert "| 1e-3 | mbs_ref |" not in text
    assert build.read_data(tmp_path).targets == report_data().targets


def test_latex_is_escaped_and_whole(folder):
    text = render(folder, "--format", "latex").read_text()
    assert text.startswith("\\documentclass")
    assert text.count("\\begin{") == text.count("\\end{")
    assert r"\textbackslash" not in text
    assert tex("a_b & 50% {x} <y>") == r"a\_b \& 50\% \{x\} \symbol{60}y\symbol{62}"


def test_a_single_file_loads_nothing(folder):
    text = render(folder, "--format", "single").read_text()
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert [source for source in re.findall(r'src="([^"]*)"', markup) if not source.startswith("data:")] == []
    assert '<link rel="stylesheet"' not in markup
    assert "default-src 'none'" in text
    assert text.count("<template data-page=") == len(list(build.render(report_data()))) - 4  # scripts and style


@pytest.mark.parametrize(("options", "message"), [
    (["--scene", "no_scene"], "scene 'no_scene' is not in the report"),
    (["--engine", "no_engine"], "engine 'no_engine' is not in the report; it holds mbs_ref"),
    (["--target", "1e-5"], "'1e-5' is not one of '1e-3', '1e-6', '1e-9'"),
    (["--format", "doc"], "'doc' is not one of 'html', 'single'"),
])  # fmt: skip
def test_an_unknown_choice_is_named_with_what_is_allowed(folder, options, message):
    done = CliRunner().invoke(main, ["report", "--render", "-o", str(folder), *options])
    assert done.exit_code == 2
    assert message in " ".join(done.output.split())


def test_without_a_browser_a_pdf_is_refused_before_anything_is_computed(folder, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    done = CliRunner().invoke(main, ["report", "--render", "-o", str(folder), "--format", "pdf"])
    assert done.exit_code == 2
    assert f"install one of {', '.join(build.BROWSERS)}" in " ".join(done.output.split())


@pytest.mark.slow
def test_a_pdf_holds_the_pages(folder):
    if build.browser() is None:
        pytest.skip(f"no browser is installed; needs one of {', '.join(build.BROWSERS)}")
    content = render(folder, "--format", "pdf", "--scene", "pendulum", "--engine", "mujoco").read_bytes()
    assert content.startswith(b"%PDF")
    assert content.count(b"/Type /Page\n") > 5


def test_scenes_are_chosen_by_label_by_name_or_from_the_library():
    assert list(chosen_scenes(wanted=["n_four_bar"])) == ["n_four_bar loops=1", "n_four_bar loops=2"]
    assert list(chosen_scenes(wanted=["n_four_bar loops=2"])) == ["n_four_bar loops=2"]
    assert list(chosen_scenes(wanted=["pendulum_chain links=5"])) == ["pendulum_chain links=5"]


@pytest.mark.parametrize(("quick", "listed"), [(False, gather.SCENES), (True, gather.QUICK)])
def test_without_a_wish_every_scene_of_the_list_is_shown(quick, listed):
    found = chosen_scenes(quick)
    assert [(scene.name, {key: scene.parameters[key] for key in more}) for scene, (_, more) in zip(
        found.values(), listed, strict=True)] == [tuple(one) for one in listed]  # fmt: skip
    assert list(chosen_scenes(quick, [next(iter(found))])) == [next(iter(found))]
