"""Verdicts are defined once: codes, the documented table, JSON, and what the store returns."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest

from cross_checks.judge.vocabulary import MEANINGS, REFUSED, WRONG, Cell, Omitted, TargetResult, Verdict, refusals
from cross_checks.records.record import Error, Record
from cross_checks.records.store import Store
from reports.facts.stored import keep, recall

REPORT = Path(__file__).parents[3] / "docs" / "report.md"
RUN = Record("pendulum", {}, "quick", "rk4", {"step": 3.7e-3}, "success", error=Error(2.3e-7, "exact", 1e-13, 1e-7))
OMITTED = Omitted(1e-5, 3e6, 40.0, 0.8, 4e-10, (2e-10, 9e-10), Verdict.AGREES, 0.9)
CELL = Cell(
    "pendulum_chain", {"links": 3, "gravity": 9.81}, "quick", "rk4", Verdict.CONVERGING, "why", error=2.3e-7,
    contact={"ball: restitution, 1": 0.83},
    targets=(TargetResult(1e-6, "reached", RUN), TargetResult(1e-9, "not-tried", omitted=OMITTED)),
    runs=({"setting": "step=0.0037", "status": "success", "error": 2.3e-7},),
)  # fmt: skip


def test_each_verdict_has_a_code_of_its_own():
    assert list(MEANINGS) == list(Verdict)
    assert len({meaning.code for meaning in MEANINGS.values()}) == len(Verdict)
    assert not WRONG & REFUSED


def test_the_document_shows_every_verdict_as_it_is_defined():
    table = [f"| {verdict} | {meaning.code} | {meaning.sentence} |" for verdict, meaning in MEANINGS.items()]
    assert "\n".join(table) in REPORT.read_text()


def test_the_store_returns_the_cell_that_it_was_given():
    store = Store()
    keep(store, "key", Cell, CELL)
    assert recall(store, "key", Cell) == CELL


def test_json_shows_the_code_beside_the_word_and_no_history():
    plain = CELL.to_dict()
    assert (plain["verdict"], plain["code"]) == ("converging", MEANINGS[Verdict.CONVERGING].code)
    assert plain["targets"][0] == {
        "target": 1e-6, "answer": "reached", "reason": "", "settings": {"step": 3.7e-3}, "error": 2.3e-7,
        "loop_s": None, "omitted": None,
    }  # fmt: skip
    assert plain["targets"][1]["omitted"]["range"] == (2e-10, 9e-10)
    assert str(OMITTED) == (
        "about 3e+06 steps in 40 s and show an error of about 4e-10 (68 %: 2e-10 to 9e-10), agrees with odds of 0.9"
    )


@pytest.mark.parametrize("verdict", Verdict)
@pytest.mark.parametrize("exemption", ["", "loops are springs"])
def test_a_documented_weakness_exempts_what_is_wrong(verdict, exemption):
    cell = replace(CELL, verdict=verdict, exemption=exemption)
    assert cell.is_wrong == (MEANINGS[verdict].tone == "bad" and not exemption)
    assert (cell.tone == "bad") == cell.is_wrong


def test_the_name_of_a_cell_is_what_rerun_takes():
    assert CELL.label == "pendulum_chain links=3"
    assert CELL.name == "pendulum_chain,links=3/quick/rk4"


def test_refusals_are_grouped_by_engine_and_reason():
    chance = random.Random(3)
    cells = [
        replace(CELL, engine=chance.choice("abc"), method=chance.choice("xyz"), reason=chance.choice(["p", "q"]),
                verdict=chance.choice([Verdict.CANNOT, Verdict.ENGINE_MISSING, Verdict.AGREES]))
        for _ in range(40)
    ]  # fmt: skip
    shown = {(row.engine, row.reason, method) for row in refusals(cells) for method in row.methods.split(", ")}
    refused = {(c.engine, c.reason, c.method) for c in cells if c.verdict is not Verdict.AGREES}
    assert shown == refused
    assert len(refusals(cells)) == len({(engine, reason) for engine, reason, _ in refused})
