"""Each shown figure, computed again from random irregular runs; a figure on two pages is the same on both."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from statistics import median

import pytest

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, OURS, Cell, TargetResult, Verdict
from cross_checks.prices.timing import with_loops
from cross_checks.records.numbers import count, short
from cross_checks.records.record import BUSY_NOTE, Error, Record
from reports.commands.publish.board import board
from reports.facts.report_data import MIDDLE, ReportData, Standing, near, standings
from reports.page.advice import advice
from reports.page.findings import low_orders
from reports.page.sections.prices import price_table
from reports.page.sections.profiles import context as profiles

LINKS = (2, 3, 5, 7, 11, 13)
OFFERED = {OURS: ("dop853", "rk4"), "exudyn": ("tree", "alpha"), "mujoco": ("rk4",), "pinocchio": ("dop853", "rk4")}


def irregular(seed: int) -> ReportData:
    """Return a report in which each method reaches some targets on some scenes, at times of no pattern."""
    chance, cells, records = random.Random(seed), [], []
    for links in LINKS:
        for engine, method in ((engine, method) for engine, methods in OFFERED.items() for method in methods):
            results = []
            for target in TARGETS:
                if chance.random() < 0.35:
                    results.append(TargetResult(target, chance.choice(list(ANSWERS)[1:]), reason=f"{method} stops"))
                    continue
                error = Error(target * chance.uniform(0.1, 0.9), "exact", target * chance.uniform(0, 0.1), 0.0,
                              length=chance.uniform(0.3, 7))  # fmt: skip
                run = Record(
                    "pendulum_chain", {"links": links}, engine, method,
                    {chance.choice(("step", "rtol")): 10 ** chance.uniform(-9, -2)}, "success", error=error,
                    steps=chance.randrange(10**6), rhs_calls=chance.randrange(10**7),
                    measures={"compliance_position": 10 ** chance.uniform(-15, 1),
                              "energy_drift": 10 ** chance.uniform(-15, 5)},
                    times={"loop_s": 10 ** chance.uniform(-5, 1), "build_s": 10 ** chance.uniform(-5, 1),
                           "first_call_s": 10 ** chance.uniform(-5, 1)},
                )  # fmt: skip
                results.append(TargetResult(target, "reached", run))
                loops = [run.times["loop_s"] * chance.uniform(0.5, 2) for _ in range(chance.randint(1, 5))]
                records.append(with_loops(run, loops, BUSY_NOTE if chance.random() < 0.3 else ""))
            verdict = chance.choice((Verdict.CONVERGING, Verdict.AGREES, Verdict.WRONG_LIMIT, Verdict.DIVERGED))
            figures = {"error": 10 ** chance.uniform(-9, 1), "compliance": 10 ** chance.uniform(-15, 1),
                       "order": chance.uniform(0.5, 9), "documented_order": chance.randint(1, 8)}  # fmt: skip
            facts = ("pendulum_chain", {"links": links}, engine, method, verdict, "")
            cells.append(Cell(*facts, **figures, targets=tuple(results)))
    for key in chance.sample(range(len(records)), 9):  # runs that engines ended without a report
        status = chance.choice(("non-finite", "reset"))
        records[key:key] = [replace(records[key], status=status, error=None, settings={"step": chance.random()})]
    return ReportData(tuple(cells), tuple(records))


def ratios(data: ReportData, target: float) -> dict[str, list[float]]:
    """Return each engine's times over those of the cheapest ranked engine, from the runs alone."""
    found: dict[str, list[float]] = {engine: [] for engine in OFFERED}
    for links in LINKS:
        cells = [cell for cell in data.cells if cell.parameters == {"links": links}]
        keys = [(c.engine, c.method, t.record.settings) for c in cells for t in c.targets
                if t.target == target and t.record]  # fmt: skip
        alone = [r for r in data.records if r.parameters == {"links": links}]
        times = {e: min(r.times["loop_s"] for r in alone if (r.engine, r.method, r.settings) in own)
                 for e in OFFERED if (own := [key for key in keys if key[0] == e])}  # fmt: skip
        least = min((time for engine, time in times.items() if engine != OURS), default=None)
        for engine in times if least is not None else ():
            found[engine].append(times[engine] / (least or 1.0))
    return found


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("target", TARGETS)
def test_standings(seed, target):
    data, expected = irregular(seed), ratios(irregular(seed), target)
    problems = sum(ratio == 1.0 for engine, own in expected.items() if engine != OURS for ratio in own)
    for one in standings(data, target):
        own = expected[one.engine]
        assert sorted(one.factors.values()) == pytest.approx(sorted(own))
        assert one.median == pytest.approx(median(own))
        assert one.problems == problems
        assert [one.share(tau) for tau in (1.0, 2.0)] == [sum(x <= tau for x in own) / problems for tau in (1.0, 2.0)]
        if one.engine != OURS:
            assert (one.cheapest, one.reached) == (own.count(1.0), len(own))


@pytest.mark.parametrize("seed", range(5))
def test_the_median_factor_is_the_same_on_every_page(seed):
    data, expected = irregular(seed), ratios(irregular(seed), MIDDLE)
    shown = {engine: f"{short(median(own))} ×" for engine, own in expected.items() if own}
    rows = next(block["rows"] for block in profiles(data)["blocks"] if block["error"] == short(MIDDLE))
    assert {row["engine"]: row["median"] for row in rows} == {e: f for e, f in shown.items() if e != OURS}
    paces = {line.engine: line.pace for line in advice(data) if line.pace}
    assert {engine: text.split(" the time")[0] for engine, text in paces.items()} == shown
    for engine, text in paces.items():
        assert text.endswith(f"(median of {count(len(expected[engine]), 'scene')})")
    text = board(data).decode()
    listed = {e: re.search(rf'id="rank-1e-6-{e}".*?([\d.e-]+ ×)</td></tr>', text) for e in shown}
    assert {engine: found and found[1] for engine, found in listed.items()} == shown


@pytest.mark.parametrize("seed", range(3))
def test_price_factors(seed):
    data = irregular(seed)
    expected = ratios(data, MIDDLE)
    rows = [row for scene in data.scenes for block in price_table(data, scene) if block["target"] == short(MIDDLE)
            for row in block["rows"] if not row["missed"] and row["factor"] != "alone"]  # fmt: skip
    for engine, own in expected.items():
        told = ["cheapest" if ratio == 1.0 and engine != OURS else f"{short(ratio)} ×" for ratio in own]
        assert [row["factor"] for row in rows if row["engine"] == engine] == told


def test_no_figure_of_others_on_an_engines_own_page():
    data = irregular(1)
    assert all(line.pace for line in advice(data))
    for engine in OFFERED:
        assert [line.pace for line in advice(data.only(engines=[engine]))] == [""]


def test_limits_count_to_what_they_bound():
    """A share up to tau; runs within half of the cheapest; orders lower by half are not low; a truth explains as much
    as it is unsure.
    """
    one = Standing("a", 2, 1, {"x": 1.0, "y": 2.0}, 4)
    assert [one.share(tau) for tau in (0.99, 1.0, 1.99, 2.0, 1e9)] == [0.0, 0.25, 0.25, 0.5, 0.5]
    runs = [Record("s", {}, "a", "m", {}, "success", times={"loop_s": x}) for x in (1.0, 1.5, 1.51)]
    assert near(runs) == runs[:2]
    cells = [Cell("s", {}, "a", f"m{k}", Verdict.CONVERGING, "", order=x, documented_order=4)
             for k, x in enumerate((3.49, 3.5, 4.5))]  # fmt: skip
    low = [found.title for found in low_orders(ReportData(tuple(cells), ()))]
    assert low == ["a m0: order 3.5 instead of 4"]
    assert [Error(x, "exact", 0.5, None).is_judged for x in (0.5, 0.501)] == [False, True]
