"""Sections on extremes, verdicts, advice, findings and capabilities, derived again from random cells."""

from __future__ import annotations

import math
import random
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.extremes import Axis, Extreme
from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.extremes.fate import Fate, Point, made_of
from cross_checks.judge.bounds import MOST_STEPS, TARGETS
from cross_checks.judge.capabilities import Ability, Capability
from cross_checks.judge.vocabulary import ANSWERS, MEANINGS, OURS, REFUSED, SILENT, Cell, TargetResult, Verdict
from cross_checks.records import numbers
from cross_checks.records.record import BUSY_NOTE, Error, Record
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory
from reports.facts import curves, report_data, scene_facts
from reports.facts.report_data import ReportData
from reports.page import advice, findings
from reports.page.sections import extremes, matrix, method, overview, prices
from tests.reports.page.test_shown_figures import irregular

LINKS, ENGINES, METHODS = (2, 3, 5, 7), (OURS, "exudyn", "mujoco", "absent"), ("one", "two", "six")
WORST_FIRST = (Fate.SILENTLY_WRONG, Fate.DEGRADED, Fate.STOPPED, Fate.SURVIVED)
WRONG = {Verdict.WRONG_LIMIT, Verdict.LOST, Verdict.DIVERGED}


def cells_of(seed: int) -> tuple[Cell, ...]:
    """Return cells of every verdict, at places of no pattern; one engine is not installed."""
    chance, cells = random.Random(seed), []
    for links in LINKS:
        for engine in ENGINES:
            verdicts = [v for v in Verdict if v is not Verdict.ENGINE_MISSING]
            refused = engine == "mujoco" and links == LINKS[-1]
            for name in METHODS if engine != "absent" else ("",):
                verdict = Verdict.CANNOT if refused else chance.choice(verdicts) if name else Verdict.ENGINE_MISSING
                answers = [chance.choice([a for a in ANSWERS if a != "reached"]) for _ in TARGETS]
                targets = tuple(
                    TargetResult(t, "cannot" if refused else a, reason=f"why {t:g}")
                    for t, a in zip(TARGETS, answers, strict=True)
                )
                cells.append(Cell("pendulum_chain", {"links": links}, engine, name, verdict, f"because {name}{links}",
                                  exemption=chance.choice(("", "", "soft")), error=10 ** chance.uniform(-9, 0),
                                  compliance=10 ** chance.uniform(-9, 0), order=chance.uniform(0.5, 5.0),
                                  documented_order=chance.randint(1, 5), targets=targets))  # fmt: skip
    return tuple(cells)


def axis_of(rising: bool, chance: random.Random) -> Axis:
    values = tuple(sorted((10 ** chance.uniform(-3, 3) for _ in range(5)), reverse=not rising))
    return Axis("stiffness", "N/m", values)


def extreme_cells(axis: Axis, chance: random.Random) -> list[ExtremeCell]:
    fates = [Fate.SURVIVED, Fate.SURVIVED, Fate.STOPPED, Fate.DEGRADED, Fate.SILENTLY_WRONG]
    cells = []
    for engine in (OURS, "exudyn", "mujoco"):
        for name in ("b", "a", "c"):
            points = []
            for value in axis.values:
                fate = chance.choice(fates)
                right = fate is Fate.SURVIVED or (fate is Fate.STOPPED and chance.random() < 0.5)
                status = chance.choice(("success", "reset"))
                points.append(Point(value, fate, 0.9 if right else 0.1, chance.random() < 0.7, None, status,
                                    f"{name} at {value:.3g}"))  # fmt: skip
            cells.append(made_of("made", "family", engine, name, False, points))
    chance.shuffle(cells)
    return cells


@pytest.mark.parametrize("seed", range(8))
def test_extremes(monkeypatch, seed):
    chance = random.Random(seed)
    axis = axis_of(seed % 2 == 0, chance)
    cells = extreme_cells(axis, chance)
    extreme = Extreme("made", "family", "Title.", axis, lambda value: None)  # type: ignore[arg-type,return-value]
    monkeypatch.setattr(extremes, "every", lambda: [extreme])
    shown = extremes.context(ReportData((), (), extremes=tuple(cells)))
    ordered = sorted(cells, key=lambda c: (c.engine != OURS, c.engine, c.method))
    (family,) = shown["families"]
    (one,) = family["extremes"]
    reach = {}
    for cell in cells:
        right = [point.odds >= 0.5 for point in cell.points]
        reach[cell.engine, cell.method] = right.index(False) if False in right else len(right)
    for line in one["advice"]:
        own = [c for c in ordered if c.engine == line["engine"]]
        most = max(reach[c.engine, c.method] for c in own)
        tied = [c for c in own if reach[c.engine, c.method] == most]
        names = ", ".join(c.method for c in tied)
        first = tied[0]
        unit = f"{numbers.short(axis.values[max(most, 1) - 1])} N/m"
        if most == 0:
            assert line["text"] == f"none of its methods is right even at {unit}: {first.points[0].reason}"
        elif most == len(axis.values):
            end = ", which is rightly refused" if first.points[-1].fate is Fate.STOPPED else ""
            assert line["text"] == f"trust {names} over the whole axis, to {unit}{end}"
        else:
            assert line["text"] == f"trust {names} up to {unit}; beyond, {first.points[most].reason}"
        lying = [c.method for c in own if any(p.fate is Fate.SILENTLY_WRONG for p in c.points)]
        warning = f"wrong without a word somewhere on the axis: {', '.join(lying)}"
        assert line["warning"] == (warning if lying else "")
    for entry in shown["tally"]:
        (own,) = (c for c in cells if (c.engine, c.method) == (entry["engine"], entry["method"]))
        caught = [p for p in own.points if p.is_silent and p.fate is Fate.SILENTLY_WRONG and p.status != "success"]
        assert entry["caught"] == len(caught)
        assert entry["counts"] == Counter([str(own.fate)])
        listed = [row for row in shown["silent"] if (row["engine"], row["method"]) == (own.engine, own.method)]
        assert [row["reason"] for row in listed] == [p.reason for p in caught[:1]]
    (entry,) = shown["table"]
    listed = {(engine, line["name"]): (fate, line["figure"], line["reason"])
              for fate, own in entry["fates"].items() for engine, lines in own.items() for line in lines}  # fmt: skip
    for cell in cells:
        worst = min((p.fate for p in cell.points), key=WORST_FIRST.index)
        most = reach[cell.engine, cell.method]
        figure = f"to {numbers.short(axis.values[most - 1])} N/m" if most else "nowhere right"
        why = [p.reason for p in cell.points if p.fate is worst and p.odds < 0.5]
        expected = (worst, "" if worst is Fate.SURVIVED else figure, *(why or [""])[:1])
        assert listed.pop((cell.engine, cell.method)) == expected
    assert not listed
    for k, (cell, row) in enumerate(zip(ordered, one["chart"]["rows"], strict=True)):
        xs = [extremes.LEFT + extremes.WIDTH * i / 4 for i in range(5)]
        assert [mark["x"] for mark in row["marks"]] == xs
        assert row["y"] == extremes.TOP + extremes.ROW * k + extremes.ROW // 2
        far = reach[cell.engine, cell.method]
        assert row["end"] == (xs[far - 1] if far else None)
        assert [mark["fate"] for mark in row["marks"]] == [str(p.fate) for p in cell.points]
    assert [t["label"] for t in one["chart"]["ticks"]] == [numbers.short(v) for v in axis.values]
    assert one["chart"]["axis"] == "stiffness (N/m)"
    assert one["chart"]["bottom"] == extremes.TOP + extremes.ROW * len(cells)


@pytest.mark.parametrize("seed", range(4))
def test_values_between_those_of_an_axis_stand_by_their_logarithms(seed):
    chance = random.Random(seed)
    values = axis_of(seed % 2 == 0, chance).values
    for k, (a, b) in enumerate(pairwise(values)):
        between = math.exp(chance.uniform(*sorted((math.log(a), math.log(b)))))
        share = k + math.log(between / a) / math.log(b / a)
        assert extremes.place(between, values) == pytest.approx(extremes.LEFT + extremes.WIDTH * share / 4, abs=0.051)
    if values[1] > values[0]:
        zero = (0.0, *values)
        middle = extremes.LEFT + extremes.WIDTH * 0.25 / 5
        assert extremes.place(0.25 * values[0], zero) == pytest.approx(middle, abs=0.051)


@pytest.mark.parametrize("seed", range(5))
def test_verdicts_by_method(seed):
    data = ReportData(cells_of(seed), ())
    ran = [c for c in data.cells if c.verdict not in REFUSED]
    shown = matrix.context(data)
    assert len(shown["rows"]) == len(ran)
    for row, cell in zip(shown["rows"], ran, strict=True):
        code, tone, sentence = MEANINGS[cell.verdict]
        assert (row["code"], row["meaning"], row["word"]) == (code, sentence, cell.verdict)
        assert row["tone"] == ("fair" if tone == "bad" and cell.exemption else tone)
        label = f"pendulum_chain links={cell.parameters['links']}"
        assert (row["scene"], row["engine"], row["method"]) == (label, cell.engine, cell.method)
        assert row["command"] == f"mbs-ref rerun {label.replace(' ', ',')}/{cell.engine}/{cell.method}"
        assert [t["reason"] for t in row["targets"]] == [f"why {t:g}" for t in TARGETS]
        assert [t["text"] for t in row["targets"]] == [ANSWERS[t.answer][0] for t in cell.targets]
        run = Record("s", {}, cell.engine, "m", {"step": 0.25}, "success")
        met = replace(cell, targets=tuple(replace(t, record=run, answer="reached") for t in cell.targets))
        assert {t["text"] for t in matrix.view(met)["targets"]} == {"h = 0.25 s"}
        assert [t["target"] for t in matrix.view(met)["targets"]] == ["1e-3", "1e-6", "1e-9"]
        assert [t["tone"] for t in row["targets"]] == [ANSWERS[t.answer][1] for t in cell.targets]
    refused = [c for c in data.cells if c.verdict is Verdict.CANNOT]
    assert sum(len(r.scenes.split(", ")) * len(r.methods.split(", ")) for r in shown["refused"]) == len(refused)
    assert {r.engine for r in shown["refused"]} == {c.engine for c in refused}
    one = replace(data, targets=TARGETS[:1])
    assert all(len(row["targets"]) == 1 for row in matrix.context(one)["rows"])
    for engines in (ENGINES[:1], ENGINES[:2]):
        assert matrix.context(data.only(engines=engines))["several_engines"] == (len(engines) > 1)
    label = ran[0].label
    assert not matrix.context(data.only(scenes=[label]))["several_scenes"]


@pytest.mark.parametrize("seed", range(6))
def test_findings_of_wrong_answers(seed):
    cells = [replace(c, targets=()) for c in cells_of(seed)]
    found = findings.findings(ReportData(tuple(cells), ()))
    met = Counter()
    for one in found:
        engine, words = one.title.split(" ", 1)
        if " instead of " in words:
            (cell,) = (
                c for c in cells if c.engine == engine and c.label == one.scene and words.startswith(f"{c.method}:")
            )
            assert cell.verdict not in WRONG
            assert (cell.order or 0.0) < (cell.documented_order or 0) - 0.5
            met["orders"] += 1
            continue
        methods, word = words.split(": ")
        own = [c for c in cells if c.engine == engine and c.method in methods.split(", ") and c.verdict == word]
        worst = max(own, key=lambda c: c.error or 0.0)
        good = [c for c in cells if (c.engine, c.label) == (engine, worst.label) and MEANINGS[c.verdict].tone == "good"]
        assert (" of the same engine agrees" in one.text) == bool(good)
        assert not good or f"where {good[-1].method} of" in one.text
        places = list(dict.fromkeys(c.label for c in own))
        if word in WRONG:
            assert one.error == worst.error
            closed = numbers.closure(worst.compliance)
            assert f"closed within {closed}, {numbers.of_scene(worst.error)} from" in one.text
            others = [place for place in places if place != worst.label]
            assert one.text.partition("Also on ")[2].rstrip(".").split(", ") == (others or [""])
        else:
            assert one.error == 0.0
            assert one.text.startswith(f"It fails on {', '.join(places)}")
        assert one.tone == ("fair" if worst.exemption else "bad")
        assert one.why.startswith(f"Because {worst.method}{worst.parameters['links']}")
        assert one.why.endswith("documented: soft." if worst.exemption else ".")
        assert (one.scene, one.command) == (worst.label, f"mbs-ref rerun {worst.name}")
        met[word] += len(own)
    wrong = Counter(str(c.verdict) for c in cells if MEANINGS[c.verdict].tone == "bad")
    assert {word: met[word] for word in wrong} == wrong
    short = [c for c in cells if c.verdict not in WRONG and (c.order or 9) + 0.5 < (c.documented_order or 0)]
    assert met["orders"] == len(short)
    assert [(-one.error, one.tone == "fair") for one in found] == sorted(
        (-one.error, one.tone == "fair") for one in found
    )
    last = len(Verdict)  # orders follow all verdicts
    words = [one.title.split(": ")[-1] for one in found]
    places = [list(Verdict).index(Verdict(word)) if word in [*Verdict] else last for word in words]
    ranks = [(-one.error, one.tone, place) for one, place in zip(found, places, strict=True)]
    assert ranks == sorted(ranks)
    first = findings.context(ReportData(tuple(cells), ()), 3)
    assert (first["findings"], first["number"]) == (found[:3], len(found))


@pytest.mark.parametrize("seed", range(5))
def test_advice_where_targets_are_missed(seed):
    data = ReportData(cells_of(seed), ())
    for line in advice.advice(data):
        own = [c for c in data.cells if c.engine == line.engine]
        if line.engine == "absent":
            assert line.use == "Not installed here: nothing is known of it."
            continue
        able = [label for label in data.scenes if any(c.label == label and c.verdict not in REFUSED for c in own)]
        if not able:
            assert (line.use, line.limit) == ("It runs none of these scenes.", "")
            continue
        count = "1 scene" if len(able) == 1 else f"{len(able)} scenes"
        assert line.use == f"It comes within {numbers.short(TARGETS[0])} of the truth on none of {count}."
        parts: dict[str, list[str]] = {}
        for label in able:
            here = [c for c in own if c.label == label]
            answers = [result.answer for c in here if (result := c.result(1e-6))]
            parts.setdefault(min(answers, key=list(ANSWERS).index), []).append(label)
        text = line.limit
        for answer, labels in parts.items():
            words = {"not-reached": "Its own limit keeps it from 1e-6 on {}.",
                     "unjudged": "No truth judges 1e-6 on {}.",
                     "not-tried": f"1e-6 would take more than {MOST_STEPS:,} steps, or more time than the report "
                                  "allows, on {}.",
                     "cannot": "At no setting tried does it run to the end on {}."}  # fmt: skip
            sentence = words[answer].format(", ".join(labels))
            assert sentence in text
            text = text.replace(sentence, "")
        others = [label for label in data.scenes if label not in able]
        assert text.strip() == (f"It cannot model {', '.join(others)}." if others else "")
        assert len(line.silent) == sum(
            f.error > 0.0 for f in findings.findings(data) if f.title.startswith(line.engine)
        )


def test_advice_falls_back_to_the_first_target_and_excludes_what_its_method_gets_wrong():
    data = irregular(2)
    kept = {(c.engine, c.label): [t for t in c.targets if t.target == TARGETS[0]] for c in data.cells}
    cells = [replace(c, verdict=Verdict.AGREES, targets=tuple(t for t in c.targets if t.target == TARGETS[0]))
             for c in data.cells]  # fmt: skip
    only_first = replace(data, cells=tuple(cells))
    engine, best = "exudyn", advice.reached(only_first, "exudyn", TARGETS[0])
    used = Counter(run.method for run in best.values()).most_common(1)[0]
    line = next(one for one in advice.advice(only_first) if one.engine == engine)
    assert line.use.startswith(f"Use {used[0]} at ")
    assert (
        f" for {numbers.short(TARGETS[0])}: it is the cheapest of its methods on {used[1]} of {len(best)}." in line.use
    )
    assert kept
    spoiled = [replace(c, verdict=Verdict.DIVERGED) if (c.engine, c.method) != (engine, used[0]) else c for c in cells]
    same = next(one for one in advice.advice(replace(data, cells=tuple(spoiled))) if one.engine == engine)
    assert same.use == line.use
    scene = next(label for label, run in best.items() if run.method != used[0])
    wrong = [replace(c, verdict=Verdict.LOST) if (c.engine, c.method, c.label) == (engine, used[0], scene) else c
             for c in cells]  # fmt: skip
    other = next(one for one in advice.advice(replace(data, cells=tuple(wrong))) if one.engine == engine)
    assert f", {best[scene].method} on {scene}: it is" in other.use


def test_engines_that_cannot_run_a_scene_at_any_target():
    rows = [{"engine": "a", "answer": "cannot", "missed": "1"}, {"engine": "b", "answer": "not-tried", "missed": "2"},
            {"engine": "c", "answer": "cannot", "missed": "3"}]  # fmt: skip
    blocks: list[dict[str, Any]] = [{"rows": rows}, {"rows": [rows[0], rows[1], rows[2] | {"answer": "not-reached"}]}]
    assert prices.cannot(blocks) == {"a": "1"}
    assert prices.cannot(blocks[::-1]) == {"a": "1"}


def test_runs_timed_alone_and_on_a_busy_machine_are_counted():
    base = Record("pendulum", {}, "exudyn", "m", {}, "success", times={"loop_s": 1.0})
    timed = {"loop_s": 1.0, "loop_median_s": 1.5, "loop_most_s": 2.0, "loop_runs": 3.0}
    runs = [base, replace(base, times=timed), replace(base, notes=(BUSY_NOTE,)),
            replace(base, times=timed, notes=(BUSY_NOTE,)), replace(base, times=timed)]  # fmt: skip
    shown = method.context(ReportData((), tuple(runs)))
    assert (shown["ranked"], shown["busy"], shown["most_steps"]) == (3, 1, MOST_STEPS)
    assert [prices.spread(run) for run in runs[:4]] == [
        "one run, beside others", "1 s to 2 s in 3 runs", "one run, beside others",
        "1 s to 2 s in 3 runs; busy machine"]  # fmt: skip
    assert shown["inside"] == {"exudyn": report_data.INSIDE["exudyn"]}
    strange = ReportData((), (replace(base, engine="strange"),))
    assert method.context(strange)["inside"] == prices.inside(strange) == {}
    constants = {name: value for name, value, _ in shown["constants"]}
    assert constants["most steps"].replace("_", "") == str(MOST_STEPS)


@pytest.mark.parametrize("seed", range(3))
def test_the_overview_counts_scenes_and_cells(seed):
    data = irregular(seed)
    figure = overview.frontier_plot(data)
    assert figure
    for line in figure["data"]:
        engine = line["meta"]["engine"]
        for level, text in zip(line["y"], line["text"], strict=True):
            base = [
                s
                for s in data.scenes
                if report_data.least_time(report_data.entries(data, s, report_data.MIDDLE)) is not None
            ]
            runs = {s: [r for r in data.of_scene(s) if r.engine == engine and r.error and r.status == "success"]
                    for s in base}  # fmt: skip
            hit = [s for s in base if any(r.error and r.error.bound <= level for r in runs[s])]
            assert text.endswith(f"reached on {len(hit)} of {len(base)} scenes")
    cells = cells_of(seed)
    found = overview.counted(ReportData(cells, ()))
    tally = Counter(c.verdict for c in cells)
    parts = ", ".join(f"{tally[v]} {v}" for v in Verdict if tally[v])
    assert found == f"{len(cells)} cells of {len(LINKS)} scenes and every method: {parts}."
    for label in ReportData(cells, ()).scenes:
        for engine in ENGINES:
            cell = overview._cell(ReportData(cells, ()), label, engine)
            own = [c for c in cells if (c.label, c.engine) == (label, engine)]
            assert (cell["why"], cell["can"]) == (own[0].reason, any(c.verdict not in REFUSED for c in own))


def test_wrong_answers_stand_in_the_overview_with_their_size():
    data = irregular(1)
    for label in data.scenes:
        for engine in data.installed:
            own = [c for c in data.cells if (c.label, c.engine) == (label, engine) and c.verdict in SILENT]
            shown = overview._cell(data, label, engine)
            expected = "; ".join(f"{c.method}: {numbers.of_scene(c.error)} off" for c in own)
            assert shown.get("wrong", expected) == expected


def test_capabilities():
    one = Capability("a", True, parts={"rod": True, "wheel": False}, traits={"loop": Ability("some", "by two of four")})
    two = Capability("b", True, parts={"rod": False, "pin": True}, traits={"loop": Ability("never", "a tree")})
    absent = Capability("c", False, "not installed")
    shown = matrix.capabilities_context(ReportData((), (), capabilities=(one, absent, two)))
    assert (shown["engines"], shown["absent"]) == (["a", "b"], {"c": "not installed"})
    words = {row["name"]: [cell["word"] for cell in row["cells"]] for group in shown["groups"] for row in group["rows"]}
    assert words == {"rod": ["can", "not yet"], "wheel": ["not yet", "not tested"], "pin": ["not tested", "can"],
                     "loop": ["some methods", "never"]}  # fmt: skip
    tones = [cell["tone"] for cell in shown["groups"][1]["rows"][0]["cells"]]
    assert tones == ["fair", "bad"]
    assert shown["groups"][1]["rows"][0]["cells"][0]["reason"] == "by two of four"


@pytest.mark.parametrize("seed", range(3))
def test_standings_and_entries(seed):
    data = irregular(seed)
    for target in TARGETS:
        firsts = []
        for scene in data.scenes:
            best = {}
            for c in data.cells:
                result = c.result(target)
                if c.label == scene and result and result.record:
                    run = data.measured(result.record)
                    if c.engine not in best or run.times["loop_s"] < best[c.engine]:
                        best[c.engine] = run.times["loop_s"]
            found = report_data.entries(data, scene, target)
            reached = [e for e in found if e.answer == "reached"]
            assert [e.engine for e in reached] == sorted(best, key=best.__getitem__)
            ranked = {e: t for e, t in best.items() if e != OURS}
            firsts += [min(ranked, key=ranked.__getitem__)] if ranked else []
            for entry in found[len(reached) :]:
                own = [c for c in data.cells if (c.label, c.engine) == (scene, entry.engine)]
                worth = min(
                    (list(ANSWERS).index(r.answer), c.error or 0.0, c.method) for c in own if (r := c.result(target))
                )
                assert (entry.answer, entry.method) == (list(ANSWERS)[worth[0]], worth[2])
        standing = {one.engine: one for one in report_data.standings(data, target)}
        assert {e: one.cheapest for e, one in standing.items() if e != OURS} == {
            e: firsts.count(e) for e in standing if e != OURS}  # fmt: skip
        places = [one for one in report_data.standings(data, target) if one.engine != OURS]
        assert places == sorted(places, key=lambda one: (-one.cheapest, -one.reached, one.median))
        assert report_data.standings(data, target)[-1].engine == OURS


def test_what_concerns_some_scenes_and_engines_alone():
    data = irregular(3)
    extra = ReportData(data.cells, data.records, capabilities=tuple(Capability(e, True) for e in ("exudyn", "mujoco")),
                       truths=tuple(scene_facts.TruthFacts(s) for s in data.scenes),
                       extremes=(ExtremeCell("x", "f", "exudyn", "m", False, Fate.CANNOT, None, ()),
                                 ExtremeCell("x", "f", "mujoco", "m", False, Fate.CANNOT, None, ())))  # fmt: skip
    scene, engine = data.scenes[2], "mujoco"
    found = extra.only(scenes=[scene], engines=[engine], targets=TARGETS[1:2])
    assert found.cells == tuple(c for c in data.cells if (c.label, c.engine) == (scene, engine))
    assert found.records == tuple(r for r in data.records if (r.label, r.engine) == (scene, engine))
    assert [c.engine for c in (*found.capabilities, *found.extremes)] == [engine] * 2
    assert [t.scene for t in found.truths] == [scene]
    assert found.targets == TARGETS[1:2]
    assert extra.only() == extra


def test_facts_of_a_truth_and_of_its_certificate(monkeypatch):
    scene = scenes.make("double_pendulum")
    rng = np.random.default_rng(5)
    place = rng.normal(size=(3, 2, 2))
    truth = Truth(place, place[..., 0], 2e-7, "converged", "by hand", difference=3e-8)
    end = {
        name: (place[-1, k] + (3e-3, 4e-3) if k else place[-1, k]).tolist() for k, name in enumerate(scene.body_names)
    }
    certified = SimpleNamespace(made="2026-02-03", confirmed_by="radau", confirmed_to=4e-9, end=end)
    monkeypatch.setattr(scene_facts.certificate, "stored", lambda scene: certified)
    found = scene_facts.truth_facts("label", scene, truth)
    assert (found.scene, found.none, found.kind, found.how) == ("label", "", "converged", "by hand")
    assert (found.uncertainty, found.difference, found.length) == (2e-7, 3e-8, scales_of(scene).length)
    assert (found.certified, found.confirmed_by, found.confirmed_to) == ("2026-02-03", "radau", 4e-9)
    assert found.departs_by == pytest.approx(5e-3)
    certified.end = {name: [None, None] for name in scene.body_names}
    assert scene_facts.truth_facts("label", scene, truth).departs_by is None
    assert scene_facts.truth_facts("label", scene, NoTruth("none known")).none == "none known"


def test_lines_of_several_curves_on_one_figure():
    x = np.array([0.0, 1.0, 2.0])
    first = curves.curves(x, {"a": x, "b": -x}, "y, m", log=True)
    second = replace(curves.curves(x + 4.0, {"c": 3.0 * x}, "other"), marks="markers", equal=True, x_label="x, N")
    shown = curves.overlay({"one": first, "two": second, "": second})
    assert [line["name"] for line in shown["data"]] == ["one: a", "one: b", "two", "c"]
    assert [line["x"][0] for line in shown["data"]] == [0.0, 0.0, 4.0, 4.0]
    assert [line["marker"]["color"] for line in shown["data"]] == [line["line"]["color"] for line in shown["data"]]
    marks = [(line["marker"]["color"], line["marker"]["symbol"]) for line in shown["data"]]
    assert marks == list(zip(curves.COLOURS, curves.SYMBOLS, strict=True))[:4]
    (known,) = curves.overlay({"": curves.curves(x, {"exudyn": x}, "y, m")})["data"]
    assert (known["marker"]["color"], known["marker"]["symbol"]) == (
        curves.style_of("exudyn").colour, curves.style_of("exudyn").symbol)  # fmt: skip
    assert shown["data"][1]["y"] == [curves.FLOOR, 1.0, 2.0]
    assert shown["data"][2]["y"] == [0.0, 3.0, 6.0]
    assert [line["mode"] for line in shown["data"]] == ["lines", "lines", "markers", "markers"]
    axes = shown["layout"]["xaxis"], shown["layout"]["yaxis"]
    assert [axis["title"]["text"] for axis in axes] == ["t, s", "y, m"]
    assert [axis["type"] for axis in axes] == ["-", "log"]
    assert "scaleanchor" not in axes[1]
    assert curves.overlay({"": second})["layout"]["yaxis"]["scaleanchor"] == "x"
    with pytest.raises(ValueError, match="not finite"):
        curves.plain([1.0, np.nan])
    assert curves.plain([1.23456789e-7]) == (1.23457e-7,)


def test_a_film_shows_every_so_manieth_sample(monkeypatch):
    rng, seen = np.random.default_rng(1), []
    path = Trajectory(np.arange(7.0), *(rng.normal(size=(7, 1, *s)) for s in ((2,), (), (2,), ())))
    monkeypatch.setattr(curves, "gif", lambda scene, few: seen.append(few) or b"gif")
    monkeypatch.setattr(curves, "filmstrip", lambda scene, few: b"strip")
    found = curves.film(scenes.make("pendulum"), path, 3)
    assert (found.gif, found.strip) == ("Z2lm", "c3RyaXA=")
    for name in ("times", "position", "orientation", "velocity", "angular_velocity"):
        assert np.array_equal(getattr(seen[0], name), getattr(path, name)[::3])


def test_the_error_of_a_run_in_a_row_of_prices_is_its_own():
    error = Error(3e-5, "exact", 2e-6, None, length=4.0)
    run = Record("pendulum", {}, "exudyn", "m", {"step": 0.1}, "success", error=error,
                 times={"loop_s": 0.25}, measures={"compliance_position": 7e-9})  # fmt: skip
    row = prices._row(report_data.Entry("exudyn", "reached", run), 2.5)
    shown = [row[key] for key in ("error", "metres", "compliance", "time", "factor", "setting", "method")]
    assert shown == ["3e-5", "1.2e-4 m", "7e-9 m", "250 ms", "2.5 ×", "h = 0.1 s", "m"]
    missed = prices._row(report_data.Entry("exudyn", "not-tried", None, "exudyn is slow", "m"), None)
    for own in (row, missed):
        assert (own["inside"], own["ours"]) == (report_data.INSIDE["exudyn"], False)
    assert missed["missed"] == f"{ANSWERS['not-tried'][0]}: exudyn is slow (m)"
    assert prices._row(report_data.Entry("strange", "cannot", None, "", "m"), None)["missed"] == (
        f"{ANSWERS['cannot'][0]}: no reason was given")  # fmt: skip
    assert [prices._factor(report_data.Entry(e, "reached", run), f) for e, f in (
        ("exudyn", 1.0), (OURS, 1.0), ("exudyn", None))] == ["cheapest", "1 ×", "alone"]  # fmt: skip


def test_methods_of_an_engine_stand_together_where_they_fail_on_the_same_scenes():
    """And apart where one of them fails on one scene more, or with another verdict."""

    def cell(method: str, links: int, verdict: Verdict = Verdict.LOST) -> Cell:
        return Cell("chain", {"links": links}, "exudyn", method, verdict, "why")

    cells = (cell("a", 1), cell("b", 1), cell("c", 1), cell("c", 2), cell("d", 2, Verdict.FAILED))
    found = list(findings.grouped(ReportData(cells, ()), Verdict.LOST))
    assert found == [("exudyn", "a, b", list(cells[:2])), ("exudyn", "c", list(cells[2:4]))]
