"""What the page says of extremes."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest

from cross_checks.extremes import MAP, Axis, every, fate, named
from cross_checks.extremes.fate import Fate, Point
from cross_checks.judge.vocabulary import OURS
from cross_checks.records import lines
from cross_checks.records.numbers import short
from cross_checks.records.store import Store
from reports.facts.report_data import ReportData
from reports.gather import Gathering
from reports.page.sections.extremes import LEFT, WIDTH, _reach, context, place, tick
from tests.reports.page.synthetic_report import report_data


@pytest.fixture(scope="module")
def shown():
    return context(report_data())


def test_families_hold_the_extremes_that_ran_with_a_chart_each(shown):
    assert [family["name"] for family in shown["families"]] == ["pulses", "stiffness"]
    chart = shown["families"][1]["extremes"][0]["chart"]
    assert [(row["engine"], row["method"]) for row in chart["rows"]] == [("mbs_ref", "rk4"), ("mujoco", "rk4")]
    assert [mark["fate"] for mark in chart["rows"][0]["marks"]] == ["survived", "degraded", "stopped"]
    assert chart["rows"][0]["end"] == LEFT


def test_the_advice_says_how_far_to_trust_and_who_lies(shown):
    advice = {line["engine"]: line for line in shown["families"][1]["extremes"][0]["advice"]}
    assert "trust rk4 up to 100 N/m" in advice["mbs_ref"]["text"]
    assert not advice["mbs_ref"]["warning"]
    assert "rk4" in advice["mujoco"]["warning"]
    assert "whole axis" in shown["families"][0]["extremes"][0]["advice"][0]["text"]


def test_what_an_engine_did_not_say_is_listed_with_what_is_true(shown):
    assert [(row["engine"], row["status"]) for row in shown["silent"]] == [("mujoco", "reset")]
    assert [row["caught"] for row in shown["tally"] if row["engine"] == "mujoco"] == [1]


def test_families_are_counted_by_engine_and_their_runs_dated(shown):
    once = {"of": 1, "survived": 0, "wrong": 0}
    assert shown["counts"] == {
        "pulses": {"mbs_ref": once | {"survived": 1}}, "stiffness": {"mbs_ref": once, "mujoco": once | {"wrong": 1}},
    }  # fmt: skip
    assert shown["made"] == ""
    days = ("2026-11-26, revision b", "2026-11-20, revision a", "2026-11-25, revision c")
    cells = tuple(replace(cell, made=day) for cell, day in zip(report_data().extremes, days, strict=False))
    dated = context(replace(report_data(), extremes=cells))
    assert dated["made"] == "2026-11-20, revision a to 2026-11-26, revision b"


def test_the_source_tree_holds_dated_runs():
    cells, problems = fate.read(MAP)
    assert not problems
    assert {cell.extreme for cell in cells} <= {extreme.name for extreme in every()}
    assert all(cell.made.startswith("20") for cell in cells)


@pytest.mark.parametrize("seed", range(4))
def test_tables_hold_every_method_that_ran_anywhere(seed):
    """By fate and engine, ours first; how far it is right, unless it survives or cannot; who never ran is left out."""
    chance, cells = random.Random(seed), []
    names = ("stiff-spring-quiet", "crash-pulse")
    for name in names:
        for engine in ("mujoco", OURS, "exudyn"):
            for method in "cab":
                values, ran = named(name).axis.values, method != "b" and (engine != "mujoco" or name == names[0])
                points = tuple(
                    Point(value, chance.choice(list(Fate)[:4]), chance.random(), chance.random() < 0.5, None,
                          chance.choice(("success", "reset")), f"because {chance.random()}") for value in values
                ) if ran else ()  # fmt: skip
                fate_ = chance.choice(list(Fate)[:4]) if ran else Fate.CANNOT
                last = chance.choice((None, *values)) if ran else None
                cells.append(fate.Cell(name, named(name).family, engine, method, False, fate_, last, points,
                                       f"reason {len(cells)}"))  # fmt: skip
    chance.shuffle(cells)
    ordered = sorted(cells, key=lambda c: (c.engine != OURS, c.engine, c.method))
    found, ran = context(ReportData((), (), extremes=tuple(cells))), [c for c in ordered if c.method != "b"]
    assert {row["name"] for row in found["table"]} == set(names)
    for row in found["table"]:
        axis, own = named(row["name"]).axis, [c for c in ran if c.extreme == row["name"]]
        for kind, engines in row["fates"].items():
            shown = [(engine, m["name"], m["figure"], m["reason"]) for engine, of in engines.items() for m in of]
            end = lambda c, axis=axis: f"to {short(c.last)} {axis.unit}".rstrip()  # noqa: E731
            assert shown == [
                (c.engine, c.method, "" if kind in ("survived", "cannot") else "nowhere right" if c.last is None
                 else f"to {axis.label(c.last)}" if axis.labels else end(c), c.reason)
                for c in own if c.fate == kind]  # fmt: skip
    both = dict.fromkeys((c.engine, c.method) for c in ran)
    assert [(t["engine"], t["method"]) for t in found["tally"]] == list(both)
    for t in found["tally"]:
        own = [c for c in cells if (c.engine, c.method) == (t["engine"], t["method"])]
        assert t["counts"] == Counter(str(c.fate) for c in own)
        assert t["caught"] == sum(p.caught for c in own for p in c.points)
    firsts = [(c, next((p for p in c.points if p.caught), None)) for c in ordered]
    assert found["silent"] == [{"engine": c.engine, "method": c.method, "extreme": c.extreme, "status": p.status,
                                "reason": p.reason} for c, p in firsts if p]  # fmt: skip


def test_values_between_listed_ones_stand_between_them_by_their_logarithm():
    rising, falling = (1.0, 100.0, 1e4), (1.0, 1e-2, 0.0)
    assert [place(v, rising) for v in (1.0, 10.0, 1e4)] == [LEFT, LEFT + WIDTH / 4, LEFT + WIDTH]
    assert place(0.1, falling) == LEFT + WIDTH / 4
    assert place(5e-3, falling) == LEFT + WIDTH * 0.75
    assert Axis("mass", "kg", (0.0, 1.0), ("1 kg", "nan kg")).label(1.0) == "nan kg"


def test_parts_kept_by_several_nights_are_shown_together_and_full_cells_before_quick_ones(tmp_path):
    def one(name: str, full: bool) -> fate.Cell:
        return fate.Cell(name, "made up", "mbs_ref", "rk4", full, Fate.SURVIVED, None, (), "full" if full else "quick")

    first, second = tmp_path / "extremes-1.jsonl", tmp_path / "extremes-2.jsonl"
    lines.append(first, [one("a", True)])
    lines.append(second, [one("a", False), one("b", False)])
    with Store(tmp_path / "runs.sqlite") as store:
        found = Gathering(store, files=(first, second)).extreme_cells()
    assert {c.extreme: c.reason for c in found} == {"a": "full", "b": "quick"}


def test_a_method_that_is_right_between_two_listed_values_reaches_farther():
    extreme = next(one for one in every() if len(one.values(True)) > len(one.values(False)))
    listed, fine = (extreme.values(full) for full in (False, True))
    between = next(value for value in fine if value not in listed)
    first, second = (fate.Cell(extreme.name, extreme.family, "mbs_ref", "m", True, Fate.DEGRADED, last, (), "")
                     for last in (fine[fine.index(between) - 1], between))  # fmt: skip
    assert _reach(extreme, second) == _reach(extreme, first) + 1.0 == fine.index(between) + 1.0


def test_a_tick_is_the_label_of_a_kind_or_a_short_number():
    assert tick(Axis("law", "", (0.0, 1.0), ("soft", "hard")), 1.0) == "hard"
    assert tick(Axis("mass", "kg", (1.0, 12345.6), full=(1e6,)), 12345.6) == "1.2e4"
