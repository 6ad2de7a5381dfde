"""The first screen: engine by scene, what accuracy costs each engine over all scenes, and what went wrong."""

import math
from collections import Counter
from statistics import median
from typing import Any

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import OURS, SILENT, Verdict
from cross_checks.records.numbers import count, duration, of_scene, short
from cross_checks.records.plots import add_series, lines, new_figure, style_of, to_data
from cross_checks.records.record import known_error, loop_time, usable
from reports.facts.report_data import MIDDLE, ReportData, Section, entries, least_time
from reports.page.slug import engine_file, scene_file

DIGITS = 15  # of an error that fills its bar
# Errors at which costs are compared: no engine was to go below the last.
LEVELS = tuple(10.0 ** (-0.5 * k) for k in range(2, round(-2.0 * math.log10(min(TARGETS))) + 1))


def context(data: ReportData) -> dict[str, Any]:
    rows = [
        {"scene": scene, "file": scene_file(scene), "cells": [_cell(data, scene, name) for name in data.installed]}
        for scene in data.scenes
    ]
    files = {name: engine_file(name) for name in data.installed}
    return {"engines": data.installed, "rows": rows, "ours": OURS, "files": files}


def _cell(data: ReportData, scene: str, engine: str) -> dict[str, Any]:
    cells = data.cells_of(scene, engine)
    errors = [known_error(run) for run in data.of_scene(scene) if run.engine == engine and usable(run)]
    if not errors:
        why = next((cell.reason for cell in cells), "not run")
        return {"error": "", "why": why, "can": scene in data.modelled(engine)}
    entry = next(e for e in entries(data, scene, MIDDLE) if e.engine == engine)
    digits = min(max(-math.log10(max(min(errors), 1e-99)), 0.0), DIGITS)
    wrong = [f"{c.method}: {of_scene(c.error)} off{' (documented)' if c.exemption else ''}"
             for c in cells if c.verdict in SILENT]  # fmt: skip
    return {
        "error": short(min(errors)), "share": round(100.0 * digits / DIGITS), "wrong": "; ".join(wrong),
        "time": duration(loop_time(entry.best)) if entry.best else "", "method": entry.method,
    }  # fmt: skip


def counted(data: ReportData) -> str:
    """Return how many cells there are, and what became of them."""
    if not data.cells:
        return "No validation was run: this page holds no cells."
    counts = Counter(cell.verdict for cell in data.cells)
    parts = ", ".join(f"{counts[word]} {word}" for word in Verdict if counts[word])
    return f"{count(len(data.cells), 'cell')} of {count(len(data.scenes), 'scene')} and every method: {parts}."


SECTION = Section("landscape", "Engine by scene", context)


def frontier_plot(data: ReportData) -> dict[str, Any] | None:
    """Return the figure of the error over the median cost of every engine; None where no ranked engine was timed."""
    base = {scene: time for scene in data.scenes if (time := least_time(entries(data, scene, MIDDLE))) is not None}
    figure = new_figure("loop time over that of the cheapest ranked engine at 1e-6", "error over the scene's scales")
    for engine in data.installed:
        costs = {scene: _costs(data, scene, engine, base[scene]) for scene in data.modelled(engine) if scene in base}
        if not costs:
            continue
        at = {level: [min((c for c, error in own if error <= level), default=math.inf) for own in costs.values()]
              for level in LEVELS}  # fmt: skip
        drawn = {level: median(own) for level, own in at.items() if math.isfinite(median(own))}
        text = [lines(engine, f"{short(cost)} × within {short(level)}",
                      f"reached on {sum(map(math.isfinite, at[level]))} of {count(len(costs), 'scene')}")
                for level, cost in drawn.items()]  # fmt: skip
        add_series(figure, engine, f"median of {count(len(costs), 'scene')}", style_of(engine), list(drawn.values()),
                   list(drawn), text=text, hovertemplate="%{text}<extra></extra>")  # fmt: skip
    return to_data(figure) if figure.data else None


def _costs(data: ReportData, scene: str, engine: str, base: float) -> list[tuple[float, float]]:
    """Return cost and error of each finished run of an engine."""
    own = [run for run in data.of_scene(scene) if run.engine == engine and usable(run)]
    return [(loop_time(run) / base, known_error(run)) for run in own]


FRONTIER = Section("frontier", "What accuracy costs, over all scenes", lambda data: {
    "plot": frontier_plot(data), "counted": counted(data),
    "absent": [name for name in data.engines if name in data.missing],
})  # fmt: skip
