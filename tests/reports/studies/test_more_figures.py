"""Figures of studies and plots that their neighbours leave out, from made-up runs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.judge.vocabulary import OURS, SILENT, Cell, Verdict
from cross_checks.records import frames
from cross_checks.records.plots import work_precision
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Measured
from reports.facts.report_data import Entry
from reports.page.sections import overview, plots
from reports.studies import androids, contact, pairs
from tests.reports.page.test_shown_figures import irregular


def run_of(engine: str, method: str, step: float, error: float, seconds: float = 1.0) -> Record:
    stated = Error(error, "exact", 1e-14, None)
    return Record("chain", {}, engine, method, {"step": step}, "success", error=stated, times={"loop_s": seconds})


def test_ratios_of_a_pair_are_over_our_time_at_the_same_target(monkeypatch):
    seconds = {OURS: {1e-3: 2.0, 1e-6: 3.0}, "exudyn": {1e-3: 5.0, 1e-6: 1.5}}
    monkeypatch.setattr(pairs, "_cells", lambda *given: [Cell("pendulum", {}, given[2], "m", Verdict.AGREES, "")])
    monkeypatch.setattr(pairs, "_timed", lambda *given: ())

    def entries(data, label, target):
        return [Entry(e, "reached", run_of(e, "m", 0.1, target, own[target])) for e, own in seconds.items()]

    monkeypatch.setattr(pairs, "entries", entries)
    request = pairs.Request("A", "", (("pendulum", {}),), ("exudyn",), (1e-3, 1e-6))
    rows = pairs.compared(SimpleNamespace(store=None), scenes.make("pendulum"), request)  # type: ignore[arg-type]
    assert [row.ratio for row in rows] == [1.0, 2.5, 1.0, 0.5]


def test_an_android_is_as_far_from_the_truth_as_its_places_are(monkeypatch):
    scene, rng = scenes.make("android_simplified", model="paper"), np.random.default_rng(1)
    n = len(scene.bodies)
    one, other = (Trajectory(np.arange(4.0), *(rng.normal(size=(4, n, *s)) for s in ((2,), (), (2,), ())))
                  for _ in range(2))  # fmt: skip
    monkeypatch.setattr(androids, "off_truth", lambda scene, path: [0.1, 0.2, 0.3, 0.4] if path is one else None)
    monkeypatch.setattr(androids, "truth_for", lambda scene, times: SimpleNamespace(uncertainty=0.05))
    paths = dict(zip(androids.UNLIKE, (one, other), strict=True))
    row = androids.add_convergence(Measured(), scene, paths)
    assert (row["error"], row["uncertainty"]) == (0.1, 0.05)


def test_every_method_enters_the_first_crash_and_those_listed_the_others(monkeypatch):
    methods = [SimpleNamespace(name=name) for name in ("dop853", "rk4")]
    able = [SimpleNamespace(name=name, able=lambda scene: methods) for name in (OURS, "pinocchio", "strange")]
    monkeypatch.setattr(androids.engines, "installed", lambda: able)
    for impact, count in (("front", 4), ("rear", 1)):
        scene: Any = SimpleNamespace(name="android_simplified", parameters={"impact": impact})
        found = [(name, method.name) for name, method in androids.entrants(scene)]
        assert len(found) == count
        assert ("pinocchio", "dop853") in found


def test_events_at_one_instant_share_an_edge_of_a_balance(monkeypatch):
    ball, original = contact._ball("progressive"), contact.simulate

    def twice(*given: Any) -> Trajectory:
        path = original(*given)
        at = path.event_times[0, 0]
        return replace(path, event_times=np.array([[at, 0.0], [at + 1e-11, 0.0]]))

    monkeypatch.setattr(contact, "simulate", twice)
    found = contact.balance(ball, Settings(method="dop853", rtol=1e-9, estimate="off", t_end=0.11), longest=0.05)
    assert np.diff(found.times).min() > 1e-9


def test_documented_wrong_limits_stand_in_the_overview():
    data = irregular(1)
    documented = replace(data, cells=tuple(replace(cell, exemption="soft") for cell in data.cells))
    for label in data.scenes:
        for engine in data.installed:
            wrong = [c for c in data.cells if (c.label, c.engine) == (label, engine) and c.verdict in SILENT]
            shown = overview._cell(documented, label, engine).get("wrong", "")
            assert shown.count("(documented)") == len(wrong)


def test_a_triangle_of_an_order_lies_below_the_lines_of_that_order_alone():
    own = {2: [(0.7, 0.02), (0.1, 1e-3)], 4: [(0.3, 3e-5), (0.05, 1e-9)]}
    runs = [run_of("exudyn", f"m{p}", step, error) for p, line in own.items() for step, error in line]
    figure: Any = plots.convergence(runs, "step", {("exudyn", f"m{p}"): p for p in own})
    triangles = [line for line in figure["data"] if "fill" in line]
    for (p, line), triangle in zip(own.items(), triangles, strict=True):
        assert (max(triangle["x"]), max(triangle["y"])) == pytest.approx((line[0][0], 0.3 * line[0][1]))
        assert min(triangle["y"]) == pytest.approx(0.3 * line[0][1] / 3.0**p)


def test_each_engine_has_the_frontier_of_its_own_runs():
    fast = [run_of("exudyn", "a", 0.1, 1e-3, 1.0), run_of("exudyn", "b", 0.1, 1e-6, 2.0)]
    slow = [run_of("mujoco", "c", 0.1, 1e-2, 5.0), run_of("mujoco", "c", 0.1, 1e-4, 7.0)]
    figure = work_precision([*fast, *slow])
    lines = {line["meta"]["engine"]: line["y"] for line in figure["data"] if line["name"] == "frontier"}
    assert lines == {"exudyn": [1e-3, 1e-6], "mujoco": [1e-2, 1e-4]}


def test_a_frame_has_the_columns_of_every_row(monkeypatch):
    monkeypatch.setattr(frames, "_library", lambda name: SimpleNamespace(DataFrame=dict))
    first, later = run_of("exudyn", "a", 0.1, 1e-3), run_of("exudyn", "b", 0.1, 1e-6)
    later = replace(later, settings={"rtol": 1e-3}, measures={"compliance_position": 0.25})
    table = frames.frame([first, later])
    assert table["settings.step"] == [0.1, None]
    assert table["settings.rtol"] == [None, 1e-3]
    assert table["measures.compliance_position"] == [None, 0.25]
