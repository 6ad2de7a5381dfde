"""What reaches a terminal: numbers, JSON without NaN, cases by name, tables that are written whole."""

from __future__ import annotations

import json
import math
import random
import time
from types import SimpleNamespace

import numpy as np
import pytest

from cross_checks.records.record import Error, Record
from reports import console
from reports.console import NothingSelected


@pytest.mark.parametrize(("value", "below", "text"), [
    (0.012345, None, "0.0123 m"), (0.0, 1.0, "0 m"), (None, 0.25, "below 0.25 m"), (None, None, ""),
    (-12.346, None, "-12.3 m"), (math.nan, None, "- m")])  # fmt: skip
def test_an_amount_has_its_unit_or_its_bound(value, below, text):
    assert console.amount(value, "m", below) == text


@pytest.mark.parametrize(("value", "text"), [(None, "-"), (np.nan, "-"), (np.inf, "-"), (0.0, "0"), (-12.346, "-12.3")])
def test_a_number_of_a_table(value, text):
    assert console.number(value) == text


@pytest.mark.parametrize("seed", range(5))
def test_json_holds_everything_that_is_finite(seed):
    chance = random.Random(seed)

    def made(depth: int) -> tuple[object, object]:
        """Return data, and what they are in JSON."""
        kind = chance.choice(("list", "dict", "array", "tuple", "number", "nan", "word", "none") if depth else ("nan",))
        if kind in ("list", "tuple", "dict"):
            pairs = [made(depth - 1) for _ in range(3)]
            whole, plain = [one for one, _ in pairs], [one for _, one in pairs]
            if kind == "dict":
                return dict(zip("abc", whole, strict=True)), dict(zip("abc", plain, strict=True))
            return (tuple(whole) if kind == "tuple" else whole), plain
        x = chance.uniform(-1.0, 1.0)
        bad = chance.choice((math.nan, math.inf, -math.inf))
        return {"array": (np.array([x, bad]), [x, None]), "number": (np.float64(x), x), "nan": (bad, None),
                "word": ("w", "w"), "none": (None, None)}[kind]  # fmt: skip

    data, plain = made(4)
    assert json.loads(console.json_text(data)) == plain
    assert json.loads(console.json_text({"a": data})) == {"a": plain}


def test_a_record_without_what_is_not_finite():
    record = Record("s", {}, "e", "m", {}, "success", t_end=2.0, measures={"a": math.nan, "b": 1.0}, notes=("x",),
                    error=Error(1.0, "exact", 2.0, math.inf))  # fmt: skip
    found = console.finite_record(record)
    assert (found.measures, found.t_end, found.notes) == ({"a": None, "b": 1.0}, 2.0, ("x",))
    assert found.error
    assert (found.error.value, found.error.final) == (1.0, None)


def test_cases_are_chosen_by_what_their_name_holds():
    cases = [SimpleNamespace(name=name) for name in ("exudyn-rk4-pendulum", "mujoco-rk4-pendulum", "exudyn-euler-top")]
    assert console.named(cases, "exudyn") == [cases[0], cases[2]]
    assert console.named(iter(cases), None) == cases
    with pytest.raises(NothingSelected, match="no case of these engines is named like 'drake'"):
        console.named(cases, "drake")


@pytest.mark.parametrize("as_json", [True, False])
def test_facts_are_written_and_printed(tmp_path, capsys, as_json):
    shown: list[object] = []
    facts = {"methods": [1.0], "runs": {"a": None}}
    console.answer(facts, tmp_path / "table.json", as_json, shown.append)
    assert json.loads((tmp_path / "table.json").read_text()) == facts
    printed = capsys.readouterr().out
    assert json.loads(printed or "null") == (facts if as_json else None)
    assert shown == ([] if as_json else [facts])
    with pytest.raises(ValueError, match="not JSON compliant"):
        console.write_table({"a": math.nan}, tmp_path / "other.json")


@pytest.mark.parametrize("longer", [False, True])
def test_what_is_awaited_is_announced_only_while_it_lasts(monkeypatch, capsys, longer):
    monkeypatch.setattr(console, "PAUSE", 0.02)
    with console.awaited("the truth"):
        time.sleep(0.2 * longer)
    time.sleep(0.1)
    assert capsys.readouterr().err == "the truth ...\n" * longer


def test_complaints_are_on_stderr_line_by_line(capsys):
    console.complain(["first", "second"])
    assert tuple(capsys.readouterr()) == ("", "first\nsecond\n")


def test_words_of_a_table_are_no_markup_and_a_long_one_is_folded(capsys):
    console.show_table("of [bold]all[/]", ("a [red]", "b"), [("[x] 1", 2.5), ("w" * 300, None)])
    title, head, first, *folded = capsys.readouterr().out.splitlines()
    assert (title.strip(), head.split(), first.split()) == ("of [bold]all[/]", ["a", "[red]", "b"], ["[x]", "1", "2.5"])
    assert sum(line.count("w") for line in folded) == 300
    assert max(map(len, (head, first, *folded))) <= 160
