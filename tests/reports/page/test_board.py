"""The board: ours takes part in no rank, each number has its command, each claim an anchor, and nothing runs in it."""

from __future__ import annotations

import shlex
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from click.testing import CliRunner

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import OURS, WRONG
from reports.cli import main
from reports.commands.publish.board import board
from reports.facts.report_data import entries, standings
from reports.page.build import write_report
from tests.reports.page.synthetic_report import report_data

HOSTILE = "'\"></td><script>alert(1)</script>"


@pytest.fixture(scope="module")
def data():
    return report_data()


class Read(HTMLParser):
    """Collects anchors, links, commands, and what must not be there."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: list[str] = []
        self.links: list[str] = []
        self.tags: set[str] = set()
        self.codes: list[str] = []
        self._inside = False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.tags.add(tag)
        self.anchors += [given["id"]] if "id" in given else []
        self.links += [given["href"]] if tag == "a" else []
        self._inside = tag == "code"

    def handle_data(self, data):
        if self._inside:
            self.codes.append(data)
            self._inside = False


@pytest.mark.parametrize("target", TARGETS)
def test_ours_is_last_and_moves_nobody(data, target):
    told = standings(data, target)
    assert told[-1].engine == OURS
    without = replace(
        data,
        cells=tuple(c for c in data.cells if c.engine != OURS),
        records=tuple(r for r in data.records if r.engine != OURS),
    )
    assert standings(without, target) == told[:-1]


def test_ranks_count_what_the_scenes_below_say(data):
    target = TARGETS[0]
    told = {one.engine: one for one in standings(data, target)}
    reached = [(scene, e) for scene in data.scenes for e in entries(data, scene, target) if e.best]
    assert sum(one.reached for one in told.values()) == len(reached)
    scenes = {scene for scene, e in reached if e.engine != OURS}
    assert sum(one.cheapest for name, one in told.items() if name != OURS) == len(scenes)
    assert all(min(one.factors.values()) >= 1.0 for name, one in told.items() if name != OURS)


def test_every_line_can_be_linked_to_and_made_again(data):
    text = board(data).decode()
    read = Read(text)
    assert len(read.anchors) == len(set(read.anchors))
    assert {link.removeprefix("#") for link in read.links} <= set(read.anchors)
    assert not read.tags & {"script", "iframe", "img"}
    rows = [e for scene in data.scenes for target in TARGETS for e in entries(data, scene, target) if e.best]
    wrong = [cell for cell in data.cells if cell.verdict in WRONG]
    assert len(rows) > 5
    assert wrong
    assert len(read.codes) == len(rows) + len(wrong)
    commands = {shlex.split(code)[1] for code in read.codes}
    assert commands <= {"simulate", "rerun"} <= set(main.list_commands(None))  # type: ignore[arg-type]


def test_text_of_the_data_is_no_markup(data):
    hostile = replace(data.cells[0], reason=HOSTILE, verdict=next(iter(WRONG)))
    assert "script" not in Read(board(replace(data, cells=(hostile, *data.cells[1:]))).decode()).tags


def test_the_command_writes_the_page_from_the_last_report_alone(data, tmp_path):
    write_report(tmp_path / "out", ((lambda: data) for _ in range(1)))
    words = ["board", "--from", str(tmp_path / "out"), "-o", str(tmp_path / "board.html")]
    assert CliRunner().invoke(main, words).exit_code == 0
    assert (tmp_path / "board.html").read_bytes() == board(data)
    assert CliRunner().invoke(main, ["board", "--from", str(tmp_path / "nothing")]).exit_code == 5
