"""Work-precision curves, cost at equal error, and the box that picks a setting."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.page.cheapest import TARGETS, entries, floor, known_error, usable
from reports.page.command import command
from reports.page.numbers import duration, metres, setting, short
from reports.page.plots.palette import styles
from reports.page.plots.work_precision import work_precision
from reports.page.report_data import ReportData, scene_label
from reports.page.section import Section

LEAD = "Lower and further left is better: how long each method computes to come within a given distance of the truth."


def equal_error_table(data: ReportData, scene: str) -> list[dict[str, Any]]:
    """Return one block a target error, with a row an engine; the fastest carries the factor 1."""
    records = data.of_scene(scene)
    return [_block(records, data.engines, target) for target in TARGETS]


def _block(records: list[Record], engines: list[str], target: float) -> dict[str, Any]:
    if target < floor(records):
        told = f"not ranked: the truth of this scene judges no error below {metres(floor(records))}"
        return {"target": metres(target), "rows": [], "unjudged": told}
    found = entries(records, engines, target)
    first = found[0].best if found else None
    return {"target": metres(target), "rows": [_row(entry, first) for entry in found], "unjudged": ""}


def _row(entry, first) -> dict[str, str]:
    if entry.best is None:
        why = "no run of it finished on this scene" if entry.reached is None else f"its best is {metres(entry.reached)}"
        return {"engine": entry.engine, "missed": f"not reached: {why}"}
    record = entry.best
    factor = record.times["loop_s"] / first.times["loop_s"]
    return {
        "engine": entry.engine,
        "method": record.method,
        "setting": setting(record.settings),
        "error": metres(known_error(record)),
        "time": duration(record.times["loop_s"]),
        "factor": "fastest" if record is first else f"{short(factor)} ×",
        "missed": "",
    }


def pick_rows(data: ReportData) -> list[dict[str, Any]]:
    """Return what the pick box chooses from: every finished run with its cost and command."""
    return [
        {
            "scene": scene_label(r.scene, r.parameters),
            "engine": r.engine,
            "method": r.method,
            "setting": setting(r.settings),
            "error": known_error(r),
            "floor": r.error.floor if r.error else 0.0,
            "compliance": r.measure("compliance_position"),
            "ms": r.times["loop_s"] * 1e3,
            "command": command(r),
        }
        for r in data.records
        if usable(r)
    ]


def context(data: ReportData) -> dict[str, Any]:
    style = styles(data.records, data.engines)
    plots = {scene: work_precision(data.of_scene(scene), style) for scene in data.scenes if data.of_scene(scene)}
    tables = {scene: equal_error_table(data, scene) for scene in plots}
    return {"plots": plots, "tables": tables, "pick_rows": pick_rows(data)}


SECTION = Section("work_precision", "Work and precision", LEAD, context, plots=True)
