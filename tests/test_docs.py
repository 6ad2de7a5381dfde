"""The documentation does what it says: its commands exist with their options, its scenes read, its code compiles."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import click
import pytest
import yaml

from cross_checks.judge.capabilities import capabilities
from mbs_ref import scenes
from mbs_ref.scene.toml import loads
from reports.cli import main
from reports.site import gallery as trade
from reports.site.__main__ import write_sources
from reports.site.notebooks import executed, page
from reports.site.pictures import IMAGES, PICTURES

ROOT = Path(__file__).parents[1]
PAGES = sorted([*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^    (?:\$ )?(mbs-ref [a-z][^#`]*?)(?:\s+#.*)?$", re.MULTILINE)
OPEN = ("COMMAND", "NAME", "...")  # of a line that shows a shape and is no command


def blocks(page: Path, language: str) -> list[str]:
    return [text for kind, text in FENCED.findall(page.read_text(encoding="utf-8")) if kind == language]


def commands() -> list[str]:
    shown = [line for page in PAGES for line in COMMAND.findall(page.read_text(encoding="utf-8"))]
    fenced = [line for page in PAGES for text in blocks(page, "sh") for line in text.splitlines()]
    found = dict.fromkeys([*shown, *(line for line in fenced if line.startswith("mbs-ref "))])
    return [line for line in found if not any(word in line for word in OPEN)]


def test_commands_are_found():
    assert len(commands()) > 30


@pytest.mark.parametrize("line", commands())
def test_a_command_of_the_docs_exists_with_its_options(line):
    name, *words = shlex.split(line)[1:]
    command = main.get_command(click.Context(main), name)
    assert command is not None
    if isinstance(command, click.Group):
        command = command.commands[words.pop(0)] if words and words[0][0] != "-" else command
    given = set()
    for word in words:
        if word.startswith("-") and not word.lstrip("-")[:1].isdigit():
            given.add(word.partition("=")[0])
    known = {opt for param in command.params for opt in (*param.opts, *param.secondary_opts)} | {"--help"}
    assert given <= known


def test_every_page_is_in_the_navigation_and_the_other_way_round():
    listed = set(re.findall(r"[\w-]+\.md", (ROOT / "mkdocs.yml").read_text(encoding="utf-8")))
    made = {"gallery.md", "capabilities.md", "truths.md", "CHANGELOG.md", "CONTRIBUTING.md"}
    made |= {notebook.with_suffix(".md").name for notebook in NOTEBOOKS}
    assert listed == made | {page.name for page in PAGES if page.parent.name == "docs"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_of_code_are_what_they_say(page):
    for text in blocks(page, "toml"):
        loads(text)
    for text in blocks(page, "python"):
        compile(text, page.name, "exec")
    for text in blocks(page, "yaml"):
        yaml.safe_load(text)


def test_every_published_problem_names_a_test_that_exists():
    rows = re.findall(r"`(tests/[\w/]+\.py)::(\w+)` \|", (ROOT / "docs" / "published-problems.md").read_text())
    assert len(rows) > 20
    for file, name in rows:
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), name


def test_made_pages_show_a_scene_and_who_can_run_it(tmp_path, monkeypatch):
    monkeypatch.setattr(trade, "entrants", lambda: ["mbs_ref"])
    few = {name: scenes.make(name) for name in ("pendulum", "n_four_bar")}
    monkeypatch.setattr("reports.site.__main__.capabilities", partial(capabilities, few))
    write_sources(tmp_path / "site", lambda text: None, ["pendulum"])
    assert "](CONTRIBUTING.md)" in (tmp_path / "site" / "architecture.md").read_text(encoding="utf-8")
    gallery = (tmp_path / "site" / "gallery.md").read_text(encoding="utf-8")
    assert (tmp_path / "site" / "gallery" / "pendulum.gif").read_bytes().startswith(b"GIF")
    assert (tmp_path / "site" / "gallery" / "pendulum.html").is_file()
    assert "exact, known to" in gallery
    assert "[work-precision plot](gallery/pendulum-work-precision.html)" in gallery
    assert "mbs_ref" in (tmp_path / "site" / "gallery" / "pendulum-work-precision.html").read_text()
    assert "| who can | mbs_ref" in gallery
    assert "| pendulum | runs |" in (tmp_path / "site" / "capabilities.md").read_text(encoding="utf-8")
    assert "| `pendulum`" in (tmp_path / "site" / "truths.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_is_kept_without_outputs_and_its_code_compiles(notebook):
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None
            compile("".join(cell["source"]), notebook.name, "exec")


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_runs_and_becomes_a_page(notebook, tmp_path):
    pytest.importorskip("nbclient")
    pytest.importorskip("pandas")
    shutil.copy(notebook, tmp_path)
    made = page(executed(tmp_path / notebook.name), notebook.stem)
    assert made.startswith("# ")
    assert "<table>" in made
    assert "Traceback" not in made


@pytest.mark.slow
def test_the_tutorial_by_copy_and_paste(tmp_path):
    tutorial, engine = ROOT / "docs" / "tutorial.md", blocks(ROOT / "docs" / "your-engine.md", "python")[0]
    (tmp_path / "swing.toml").write_text(blocks(tutorial, "toml")[0])
    (tmp_path / "small_.py").write_text(engine)
    program = Path(sys.executable).with_name("mbs-ref")
    for line in "".join(blocks(tutorial, "sh")[1:]).splitlines():
        done = subprocess.run(
            [program, *shlex.split(line)[1:]], cwd=tmp_path, capture_output=True, text=True, timeout=900
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
    wrong = blocks(tutorial, "toml")[0].replace("mass = 1.0", "mas = 1.0")
    (tmp_path / "wrong.toml").write_text(wrong)
    done = subprocess.run(
        [program, "simulate", "wrong.toml"], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 2
    assert "mas" in done.stderr
    assert "mass" in done.stderr


SHOWN = re.compile(r"!\[[^\]]+\]\(docs/images/([^)]+)\)")
MOST_BYTES = 300_000  # of a picture


def test_the_readme_shows_the_pictures_that_the_command_makes():
    assert SHOWN.findall((ROOT / "README.md").read_text(encoding="utf-8")) == list(PICTURES)
    assert {path.name for path in IMAGES.iterdir() if path.is_file()} == set(PICTURES)


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_small_and_of_its_kind(name):
    content = (IMAGES / name).read_bytes()
    assert content.startswith({"png": b"\x89PNG", "svg": b"<svg"}[name.rpartition(".")[2]])
    assert len(content) < MOST_BYTES


FOLDERS = ("architecture.md", "CONTRIBUTING.md")  # pages that name folders and files of the tree
PLACE = re.compile(r"`((?:[\w]+/)*\w+\.py|(?:\w+/)+)`")


@pytest.mark.parametrize("page", [p for p in PAGES if p.name in FOLDERS], ids=lambda page: page.name)
def test_named_folders_and_files_are_in_the_tree(page):
    layers = ("mbs_ref", "cross_checks", "benchmarks", "reports", "tests")
    files = [path.relative_to(ROOT) for layer in layers for path in (ROOT / layer).rglob("*.py")]
    known = {str(place) for file in files for place in (file, *file.parents)}
    ends = {"/".join(place.split("/")[k:]) for place in known for k in range(place.count("/") + 1)}
    named = [place.rstrip("/") for place in PLACE.findall(page.read_text(encoding="utf-8"))]
    assert named
    assert not [place for place in named if place not in ends]


LINK = re.compile(r"\]\(([^)\s]+)\)")
MADE = ("gallery.md", "capabilities.md", "truths.md", "CHANGELOG.md", "CONTRIBUTING.md")  # beside docs/ in the site


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_the_sources_lead_to_files(page):
    """The built site has every link looked at; these are the links of a reader of the repository."""
    for link in LINK.findall(FENCED.sub("", page.read_text(encoding="utf-8"))):
        target = link.partition("#")[0]
        if not target or "://" in target or target in MADE:
            continue
        notebook = target.endswith(".md") and (page.parent / target).with_suffix(".ipynb").is_file()
        assert (page.parent / target).exists() or notebook, f"{page.name}: {link}"
