"""Every number of ten sections, recomputed from random irregular records in a few lines of its own."""

from __future__ import annotations

import math
import random
import re
from collections import Counter
from dataclasses import replace
from statistics import median
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, OURS, Cell, Verdict
from cross_checks.records.numbers import short
from cross_checks.records.plots import work_precision
from cross_checks.records.record import Error, Record
from cross_checks.records.store import Store
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from reports.facts import curves, report_data
from reports.facts.report_data import ReportData, Section
from reports.facts.scene_facts import TruthFacts, truth_facts
from reports.facts.stored import Stored, adapter, keep, recall
from reports.page import advice, findings
from reports.page.render import RECORDS, templates
from reports.page.sections import extremes, matrix, method, overview, plots, prices, profiles
from tests.reports.page.test_shown_figures import LINKS, irregular

SEEDS = range(3)
UNITS = {"m": 1.0, "J": 1.0, "s": 1.0, "ms": 1e-3, "µs": 1e-6, "%": 1e-2, "×": 1.0}


@pytest.fixture(scope="module", params=SEEDS)
def data(request) -> ReportData:
    """Return an irregular report as the store gives it back."""
    made = irregular(request.param)
    with Store() as store:
        for k, cell in enumerate(made.cells):
            keep(store, str(k), Stored, Stored(cell))
        read = [recall(store, str(k), Stored) for k in range(len(made.cells))]
    kept = adapter(tuple[Record, ...])
    return ReportData(tuple(one.cell for one in read if one), kept.validate_json(kept.dump_json(made.records)))


def value(text: str) -> float:
    """Return the number in a text, in SI units."""
    number, unit = re.match(r"(-?[\d.]+(?:e-?\d+)?)(?: (\S+))?", text).groups()  # type: ignore[union-attr]
    return float(number) * UNITS.get(unit, 1.0)


def shown(x: float, digits: int = 2) -> object:
    """Return what a number is to `digits` significant figures."""
    return pytest.approx(float(f"{x:.{digits}g}"), rel=1e-9)


def ended(data: ReportData, **wanted) -> list[Record]:
    """Return the runs with an error, of an engine or of links."""
    return [r for r in data.records if r.error and r.status == "success"
            and wanted.get("engine", r.engine) == r.engine
            and wanted.get("links", r.parameters["links"]) == r.parameters["links"]]  # fmt: skip


def at_target(data: ReportData, links: int, target: float) -> dict[str, Record]:
    """Return the cheapest run of each engine that reaches a target, by the runs alone."""
    best: dict[str, Record] = {}
    for cell in data.cells:
        for result in cell.targets:
            if cell.parameters == {"links": links} and result.target == target and result.record is not None:
                (run,) = [r for r in ended(data) if r.settings == result.record.settings and r.error
                          and r.error.value == result.record.error.value]  # fmt: skip
                if run.engine not in best or run.times["loop_s"] < best[run.engine].times["loop_s"]:
                    best[run.engine] = run
    return best


def test_prices(data):
    for links in LINKS:
        block_scene = f"pendulum_chain links={links}"
        for target, block in zip(TARGETS, prices.price_table(data, block_scene), strict=True):
            best = at_target(data, links, target)
            assert value(block["target"]) == target
            ranked = sorted(best, key=lambda engine: (engine == OURS, best[engine].times["loop_s"]))
            assert [row["engine"] for row in block["rows"] if not row["missed"]] == ranked
            others = [row for row in block["rows"] if row["engine"] != OURS]
            assert [bool(row["missed"]) for row in others] == sorted(bool(row["missed"]) for row in others)
            for row in block["rows"]:
                if row["missed"]:
                    answers = {c.method: c.result(target).answer for c in data.cells_of(block_scene, row["engine"])}
                    assert row["answer"] == min(answers.values(), key=list(ANSWERS).index)
                    first = next(method for method in answers if f"{method} stops" in row["missed"])
                    assert answers[first] == row["answer"]
                    assert row["missed"].endswith(f"({first})") == (row["answer"] != "cannot")
                    continue
                run = best[row["engine"]]
                assert run.error
                loops, key = run.times, next(iter(run.settings))
                assert row["method"] == run.method
                assert row["setting"].startswith({"step": "h = ", "rtol": "rtol = "}[key])
                assert value(row["setting"].split("= ")[1]) == shown(run.settings[key])
                assert value(row["error"]) == shown(run.error.value)
                assert value(row["metres"]) == shown(run.error.value * run.error.length)
                assert value(row["compliance"]) == shown(run.measures["compliance_position"] or 0.0)
                assert value(row["time"]) == shown(loops["loop_s"], 3)
                assert row["spread"].endswith("busy machine") == bool(run.notes)
                if loops["loop_runs"] > 1:
                    least, most, count = re.match(r"(.+?) to (.+?) in (\d+) runs", row["spread"]).groups()  # type: ignore[union-attr]
                    assert (value(least), value(most)) == (shown(loops["loop_s"], 3), shown(loops["loop_most_s"], 3))
                    assert int(count) == loops["loop_runs"]


def test_runs_that_are_timed_again_are_those_within_half_of_the_cheapest(data):
    runs = sorted(ended(data), key=lambda run: run.times["loop_s"])
    expected = [run for run in runs if run.times["loop_s"] <= 1.5 * runs[0].times["loop_s"]]
    assert report_data.near(runs) == expected
    assert len(expected) < len(runs)


@pytest.mark.parametrize(("count", "kept"), [(3, 3), (201, 201), (401, 201), (1001, 201)])
def test_a_curve_is_thinned_where_it_is_long_alone(count, kept):
    x = np.random.default_rng(1).uniform(1.0, 9.0, count)
    made = curves.curves(x, {"a": 2.0 * x}, "m")
    assert made.x == pytest.approx(x[:: max(1, (count - 1) // 200)], rel=1e-5)
    assert made.lines["a"] == pytest.approx(2.0 * np.array(made.x), rel=1e-5)
    assert len(made.x) == kept


@pytest.mark.parametrize(
    "changed", [{"scene": "kepler", "parameters": {}}, {"parameters": {"links": 99}}, {"engine": "x"}, {"method": "x"}]
)
def test_equal_settings_on_another_scene_or_by_another_method_are_another_run(data, changed):
    """Whatever else two runs share, each is measured as itself."""
    for run in data.records:
        other = replace(run, **changed, steps=-7)
        both = ReportData((), (run, other))
        assert [both.measured(replace(one, steps=0)) for one in (run, other)] == [run, other]
        assert ReportData((), (run,)).measured(other) is other


def test_runs_that_differ_in_one_setting_are_two_runs(data):
    run = data.records[0]
    for changed in ({"step": 1.0}, {"rtol": 1.0}, {"step": 2.0, "rtol": 1.0}):
        other = replace(run, settings=changed, steps=7)
        assert ReportData((), (run, other)).measured(replace(other, steps=0)).steps == 7
        assert ReportData((), (run,)).measured(other) is other


def test_the_rows_to_pick_from(data):
    rows = prices.pick_rows(data)
    assert len(rows) == len(ended(data))
    for row, run in zip(rows, ended(data), strict=True):
        assert run.error
        assert row["error"] == pytest.approx(run.error.value + run.error.uncertainty)
        assert row["floor"] == pytest.approx(run.error.uncertainty)
        assert row["ms"] == pytest.approx(1000.0 * run.times["loop_s"])
        assert row["compliance"] == run.measures["compliance_position"]
        assert (row["engine"], row["ours"]) == (run.engine, run.engine == OURS)


def test_profiles(data):
    for target, block in zip(TARGETS, profiles.context(data)["blocks"], strict=True):
        factors: dict[str, list[float]] = {}
        for links in LINKS:
            best = {e: r.times["loop_s"] for e, r in at_target(data, links, target).items() if e != OURS}
            for engine, time in best.items():
                factors.setdefault(engine, []).append(time / min(best.values()))
        problems = sum(own.count(1.0) for own in factors.values())
        assert block["problems"] == problems
        assert set(block["missed"]) == {r.engine for r in data.records} - {OURS, *factors}
        end = min(1e4, 2.0 * max(max(own) for own in factors.values()))
        lines = {line["meta"]["engine"]: line for line in block["plot"]["data"]}
        for row in block["rows"]:
            own = factors[row["engine"]]
            assert row["solved"] == f"{len(own)} of {problems}"
            assert row["shares"] == [f"{sum(x <= tau for x in own) / problems:.0%}" for tau in (1, 2, 10)]
            assert value(row["median"]) == shown(median(own))
            x, y = lines[row["engine"]]["x"], lines[row["engine"]]["y"]
            assert x == pytest.approx([1.0, *sorted(f for f in own if f < end), end])
            assert y == pytest.approx([sum(f <= tau for f in own) / problems for tau in x])


def test_engines_by_scene(data):
    context = overview.context(data)
    for links, row in zip(LINKS, context["rows"], strict=True):
        best = at_target(data, links, 1e-6)
        for engine, cell in zip(context["engines"], row["cells"], strict=True):
            runs = ended(data, engine=engine, links=links)
            if not runs:
                assert cell["error"] == ""
                continue
            least = min(r.error.value + r.error.uncertainty for r in runs if r.error)
            assert value(cell["error"]) == shown(least)
            assert cell["share"] == round(100.0 * min(15.0, max(0.0, -math.log10(least))) / 15.0)
            wrong = [c for c in data.cells if (c.engine, c.parameters["links"]) == (engine, links)
                     and c.verdict in ("wrong-limit", "diverged")]  # fmt: skip
            assert cell["wrong"].count(" off") == len(wrong)
            assert (cell["time"] == "") == (engine not in best)
            if engine in best:
                assert value(cell["time"]) == shown(best[engine].times["loop_s"], 3)
                assert cell["method"] == best[engine].method


def test_what_accuracy_costs(data):
    figure = overview.frontier_plot(data)
    assert figure
    titles = [figure["layout"][axis]["title"]["text"] for axis in ("xaxis", "yaxis")]
    assert titles == ["loop time over that of the cheapest ranked engine at 1e-6", "error over the scene's scales"]
    for line in figure["data"]:
        engine, costs = line["meta"]["engine"], {}
        for links in LINKS:
            base = min((r.times["loop_s"] for e, r in at_target(data, links, 1e-6).items() if e != OURS), default=None)
            if base is not None:
                costs[links] = [(r.times["loop_s"] / base, r.error.value + r.error.uncertainty)
                                for r in ended(data, engine=engine, links=links) if r.error]  # fmt: skip
        for cost, level in zip(line["x"], line["y"], strict=True):
            least = [min((c for c, e in own if e <= level), default=math.inf) for own in costs.values()]
            assert cost == pytest.approx(median(least))


def test_verdicts(data):
    rows = matrix.context(data)["rows"]
    for row, cell in zip(rows, data.cells, strict=True):
        assert value(row["error"]) == shown(cell.error or 0.0)
        assert value(row["compliance"]) == shown(cell.compliance or 0.0)
        assert [float(x) for x in row["order"].split(" of ")] == [shown(cell.order or 0.0), cell.documented_order]


def printed(section: Section, data: ReportData) -> list[list[str]]:
    """Return the texts of a section's table, a list a row; a cell's small text is a text of its own."""
    html = (
        templates().get_template(f"{section.name}.html").render(section=section, page_title="", **section.context(data))
    )
    rows = re.findall(r"<tr><th scope=\"row\".*?</tr>", html, re.DOTALL)
    return [[text for text in re.split(r"(?:<[^>]*>)+", row) if text] for row in rows]


def test_records(data):
    rows = iter(printed(RECORDS, data))
    for links in dict.fromkeys(scene.partition("links=")[2] for scene in data.scenes):
        for run in (r for r in data.records if str(r.parameters["links"]) == links):
            engine, _, _, status, *texts, steps, calls, loop, _ = [x for x in next(rows) if x != run.message]
            assert (engine, status, int(steps), int(calls.split()[0])) == (
                run.engine, run.status, run.steps, run.rhs_calls)  # fmt: skip
            assert value(loop) == shown(run.times["loop_s"], 3)
            error, compliance, energy = texts
            assert value(compliance) == shown(run.measures["compliance_position"] or 0.0)
            assert value(energy) == shown(run.measures["energy_drift"] or 0.0)
            assert error == "–" if run.error is None else value(error) == shown(run.error.value)
    assert next(rows, None) is None


@pytest.mark.parametrize("first", [len(LINKS), 1])
def test_decisions(data, first):
    """Each sentence as a whole; of one scene, too."""
    data, links = data.only(scenes=data.scenes[:first]), LINKS[:first]
    models = "1 scene" if first == 1 else f"{first} scenes"
    names = dict(zip(TARGETS, ("1e-3", "1e-6", "1e-9"), strict=True))
    for line in advice.advice(data):
        hits = {t: {n: at_target(data, n, t)[line.engine] for n in links if line.engine in at_target(data, n, t)}
                for t in TARGETS}  # fmt: skip
        target = next((t for t in (1e-6, 1e-3) if hits[t]), None)
        if target is None:
            assert (line.use, line.reach) == (f"It comes within 1e-3 of the truth on none of {models}.", "")
            continue
        reach = ", ".join(f"{name} on {len(hits[t])}" for t, name in names.items())
        assert line.reach == f"Of {models} it models, it reaches {reach}."
        used = Counter(run.method for run in hits[target].values())
        name = next(one for one in used if used[one] == max(used.values()))
        own = [run.settings for run in hits[target].values() if run.method == name]
        key = "step" if any("step" in one for one in own) else "rtol"
        sizes = [one[key] for one in own if key in one]
        span = " to ".join(dict.fromkeys(short(x) for x in (min(sizes), max(sizes))))
        how = f"h = {span} s" if key == "step" else f"rtol = {span}"
        wrong = [c.parameters["links"] for c in data.cells if (c.engine, c.method) == (line.engine, name)
                 and c.verdict in ("wrong-limit", "diverged")]  # fmt: skip
        others = "".join(f", {run.method} on pendulum_chain links={n}" for n, run in hits[target].items() if n in wrong)
        assert line.use == (f"Use {name} at {how} for {names[target]}{others}: it is the cheapest of its methods on "
                            f"{used[name]} of {len(hits[target])}.")  # fmt: skip


def test_findings(data):
    found = findings.findings(data)
    assert [one.error for one in found] == sorted((one.error for one in found), reverse=True)
    for one in found:
        engine = one.title.split()[0]
        silent = re.match(r"\w+ ([\w, ]+): (wrong-limit|diverged)", one.title)
        caught = re.match(r"\w+ (\w+): (non-finite|reset)", one.title)
        low = re.match(r"\w+ (\w+): order (\S+) instead of (\d)", one.title)
        if silent:
            cells = [c for c in data.cells if c.engine == engine and c.verdict == silent[2]
                     and c.method in silent[1].split(", ")]  # fmt: skip
            assert one.error == max(c.error or 0.0 for c in cells)
            off = re.search(r"([\d.e-]+(?: %)?(?: of the scene)?) from the truth", one.text)[1]  # type: ignore[index]
            assert value(off) == shown(one.error)
        elif caught:
            own = [r for r in data.records if (r.engine, r.method, r.status) == (engine, caught[1], caught[2])]
            assert int(one.text.split()[0]) == len(own)
        else:
            assert low
            cell = next(c for c in data.cells if (c.engine, c.method, c.label) == (engine, low[1], one.scene))
            assert (float(low[2]), int(low[3])) == (shown(cell.order or 0.0), cell.documented_order)
            assert (cell.order or 0.0) + 0.5 < (cell.documented_order or 0)
    short = [c for c in data.cells if c.verdict in ("agrees", "converging")
             and (c.order or 0.0) + 0.5 < (c.documented_order or 0)]  # fmt: skip
    assert sum(" instead of " in one.title for one in found) == len(short)


@pytest.mark.parametrize("over", ["step", "rtol"])
def test_convergence(data, over):
    for links in LINKS:
        figure = plots.convergence(data.of_scene(f"pendulum_chain links={links}"), over, {})
        for line in figure["data"] if figure else ():
            runs = [r for r in ended(data, engine=line["meta"]["engine"], links=links)
                    if r.method == line["name"] and over in r.settings]  # fmt: skip
            assert list(zip(line["x"], line["y"], strict=True)) == sorted(
                (r.settings[over], r.error.value) for r in runs if r.error
            )


def test_a_triangle_has_the_slope_of_its_order(data):
    scene = data.of_scene("pendulum_chain links=5")
    orders = {("pinocchio", "rk4"): 4, (OURS, "rk4"): 4, ("exudyn", "alpha"): 2, ("exudyn", "tree"): 3}
    triangles = {
        over: [line for line in (plots.convergence(scene, over, orders) or {"data": []})["data"] if "fill" in line]
        for over in ("step", "rtol")
    }
    assert triangles["step"]
    assert not triangles["rtol"]
    for line in triangles["step"]:
        (x0, x1, _, _), (y0, _, y1, _) = line["x"], line["y"]
        assert x1 / x0 == pytest.approx(3.0)
        assert round(math.log(y1 / y0) / math.log(x1 / x0), 9) in (2.0, 3.0, 4.0)


@pytest.mark.parametrize("lowest", range(3))
def test_a_triangle_is_below_every_line_of_its_order(lowest):
    errors = {f"m{k}": 1e-5 if k == lowest else 10.0 ** (k - 4) for k in range(3)}
    made = [Record("pendulum", {}, "exudyn", name, {"step": step}, "success", times={"loop_s": 1.0},
                   error=Error(error * step**4, "exact", 0.0, None))
            for name, error in errors.items() for step in (1.0, 0.5, 0.25)]  # fmt: skip
    figure = plots.convergence(made, "step", {("exudyn", name): 4 for name in errors})
    assert figure
    (triangle,) = (line for line in figure["data"] if "fill" in line)
    for step, low in zip(triangle["x"], triangle["y"], strict=True):
        assert low <= 0.3001 * min(errors.values()) * step**4


def test_error_against_time(data):
    for links in LINKS:
        figure = work_precision(data.of_scene(f"pendulum_chain links={links}"))
        for line in figure["data"]:
            runs = [(1000.0 * r.times["loop_s"], r.error.value) for r in ended(data, links=links) if r.error
                    and (r.engine, line["name"]) in ((line["meta"]["engine"], r.method),
                                                     (line["meta"]["engine"], "frontier"))]  # fmt: skip
            if line["name"] == "frontier":
                runs = [(x, y) for x, y in runs if not any(a < x and b <= y for a, b in runs)]
            points = list(zip(line["x"], line["y"], strict=True))
            assert points == [pytest.approx(point) for point in sorted(runs)]
        errors = [r.error for r in ended(data, links=links) if r.error]
        floor, values = max(e.uncertainty for e in errors), [e.value for e in errors]
        low, high = 10.0 ** np.array(figure["layout"]["yaxis"]["range"])
        assert (low, high) == pytest.approx((min(floor / 10.0, min(values) / 3.0), 3.0 * max(values)))
        assert figure["layout"]["shapes"][0]["y1"] == pytest.approx(floor)


def test_time_split(data):
    for links in LINKS:
        figure = plots.time_split(data.of_scene(f"pendulum_chain links={links}"))
        assert figure
        loops = figure["data"][2]["x"]
        assert loops == sorted(loops, reverse=True)
        for bar, phase in zip(figure["data"], ("build_s", "first_call_s", "loop_s"), strict=True):
            for name, ms in zip(bar["y"], bar["x"], strict=True):
                engine = name.split(" · ")[0]
                runs = ended(data, engine=engine, links=links)
                within = [r for r in runs if r.error and r.error.value + r.error.uncertainty <= 1e-6]
                best = min(within or runs, key=lambda r: r.times["loop_s"] if within else r.error.bound)
                assert ms == pytest.approx(1000.0 * best.times[phase])


def test_a_truth_is_known_over_the_scenes_length():
    """The rods of 4 m count as long; turns are known over the least radius of gyration, L / sqrt(12)."""
    scene = scenes.make("double_pendulum", length_1=4.0, length_2=4.0)
    zero = np.zeros((2, 2, 2))
    found = truth_facts("a", scene, Truth(zero, zero[..., 0], 1e-7, "exact", ""))
    assert found.known_to == pytest.approx(1e-7 / min(scales_of(scene).length, 4.0 / 12**0.5))


def test_truths():
    chance = random.Random(4)
    for _ in range(20):
        known, floor, two, length, off, confirmed = (10 ** chance.uniform(-15, 3) for _ in range(6))
        facts = TruthFacts("a", "", "exact", "", known, floor, two, length, "2026-01-01", "x", confirmed, off)
        (row,) = printed(method.TRUTHS, ReportData((), (), truths=(facts,)))
        for text, figure in zip((*row[2:7], row[9][7:]), (known, floor, length, two, confirmed, off), strict=True):
            assert value(text) == shown(figure), row


def test_failures_that_an_engine_reports_are_not_sorted_by_their_error():
    """A failed method has an error from runs that ended, and is no wrong answer."""
    verdicts = Verdict.FAILED, Verdict.LOST, Verdict.TIMEOUT, Verdict.WRONG_LIMIT
    made = zip("abcd", verdicts, (0.7, 0.02, 3.0, 0.5), strict=True)
    cells = [Cell("chain", {}, "exudyn", name, verdict, "stops", error=error) for name, verdict, error in made]
    found = {
        one.title.split(":")[0].split(" ")[1]: one.error for one in findings.findings(ReportData(tuple(cells), ()))
    }
    assert found == {"a": 0.0, "b": 0.02, "c": 0.0, "d": 0.5}
    assert list(found)[:2] == ["d", "b"]


def test_what_our_checks_caught_is_counted_by_runs():
    cells: list[Any] = [SimpleNamespace(engine=engine, method="rk4", fate=fate, points=[
        SimpleNamespace(caught=caught) for caught in own]) for engine, fate, own in (
        ("quick", "stopped", (True, True, False)), ("quick", "survived", (False,)), ("other", "stopped", (True,)),
        ("quick", "stopped", (True, False, True)))]  # fmt: skip
    row = extremes._tally("quick", "rk4", cells)
    assert (row["caught"], row["counts"]) == (4, {"stopped": 2, "survived": 1})
