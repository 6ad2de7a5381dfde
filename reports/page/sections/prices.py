"""Cost at equal error on one scene: each engine's cheapest setting at each target, and the box that picks one."""

from typing import Any

from cross_checks.judge.vocabulary import ANSWERS, OURS
from cross_checks.records.numbers import duration, metres, setting, short
from cross_checks.records.plots import work_precision
from cross_checks.records.record import is_busy, is_timed, known_error, loop_time, usable
from reports.facts.report_data import INSIDE, Entry, ReportData, Section, entries, over_cheapest
from reports.page.slug import command


def price_table(data: ReportData, scene: str) -> list[dict[str, Any]]:
    """Return one block a target error, with a row an engine; the fastest of the ranked carries no factor."""
    return [_block(data, scene, target) for target in data.targets]


def _block(data: ReportData, scene: str, target: float) -> dict[str, Any]:
    result = entries(data, scene, target)
    factors = over_cheapest(result)
    present = [entry for entry in result if entry.engine not in data.missing]
    ordered = sorted(present, key=lambda entry: entry.engine == OURS)
    return {"target": short(target), "rows": [_row(entry, factors.get(entry.engine)) for entry in ordered]}


def cannot(blocks: list[dict[str, Any]]) -> dict[str, str]:
    """Return the engines that run the scene at no target, with the reason, which stands once below the table."""
    every = [{row["engine"]: row["missed"] for row in b["rows"] if row["answer"] == "cannot"} for b in blocks]
    return {name: why for name, why in every[0].items() if all(name in one for one in every)}


def _row(entry: Entry, factor: float | None) -> dict[str, Any]:
    inside = INSIDE.get(entry.engine, "")
    row = {"engine": entry.engine, "ours": entry.engine == OURS, "answer": entry.answer, "inside": inside}
    record = entry.best
    if record is None or record.error is None:
        text = f"{ANSWERS[entry.answer][0]}: {entry.reason or 'no reason was given'}"
        named = f" ({entry.method})" if entry.method and entry.answer != "cannot" else ""
        return row | {"missed": text + named}
    return row | {
        "missed": "", "method": record.method, "setting": setting(record.settings), "error": short(record.error.value),
        "metres": metres(record.error.metres), "compliance": metres(record.measure("compliance_position")),
        "time": duration(loop_time(record)), "spread": spread(record), "factor": _factor(entry, factor),
        "command": command(record),
    }  # fmt: skip


def _factor(entry: Entry, factor: float | None) -> str:
    if factor is None:
        return "alone"
    return "cheapest" if factor == 1.0 and entry.engine != OURS else f"{short(factor)} ×"


def inside(data: ReportData) -> dict[str, str]:
    """Return what lies inside the timed loop of each engine that was timed."""
    return {
        name: INSIDE[name] for name in data.engines if name in INSIDE and any(r.engine == name for r in data.records)
    }


def spread(record) -> str:
    """Return the interval of the loop's times, and whether the machine was busy."""
    if not is_timed(record):
        return "one run, beside others"
    times = record.times
    several = f"{duration(times['loop_s'])} to {duration(times['loop_most_s'])} in {times['loop_runs']:.0f} runs"
    text = several if times["loop_runs"] > 1 else "one run"
    return f"{text}; busy machine" if is_busy(record) else text


def pick_rows(data: ReportData) -> list[dict[str, Any]]:
    """Return what the pick box chooses from: every finished run with its cost and command."""
    return [
        {"scene": r.label, "engine": r.engine, "ours": r.engine == OURS, "method": r.method,
         "setting": setting(r.settings), "error": known_error(r), "floor": r.error.uncertainty if r.error else 0.0,
         "compliance": r.measure("compliance_position"), "ms": r.times["loop_s"] * 1e3, "command": command(r)}
        for r in data.records if usable(r)
    ]  # fmt: skip


def context(data: ReportData) -> dict[str, Any]:
    plots = {scene: work_precision(data.of_scene(scene)) for scene in data.scenes if data.of_scene(scene)}
    tables = {scene: price_table(data, scene) for scene in data.scenes}
    never = {scene: cannot(blocks) for scene, blocks in tables.items()}
    return {"plots": plots, "tables": tables, "never": never, "pick_rows": pick_rows(data), "inside": inside(data)}


SECTION = Section("prices", "Cost at equal error", context)
