"""Every run with its figures and the command that makes it again."""

from typing import Any

from cross_checks.records.numbers import ABSENT, duration, joules, metres, of_scene, setting
from cross_checks.records.record import Record
from reports.facts.report_data import ReportData, Section
from reports.page.slug import command


def row(record: Record) -> dict[str, Any]:
    """Return what a run's row shows."""
    return {
        "engine": record.engine,
        "method": record.method,
        "setting": setting(record.settings),
        "status": record.status or ABSENT,
        "message": record.message,
        "error": of_scene(record.error.value if record.error else None),
        "compliance": metres(record.measure("compliance_position")),
        "energy": joules(record.measure("energy_drift")),
        "steps": record.steps,
        "rhs_calls": record.rhs_calls,
        "loop": duration(record.times.get("loop_s")),
        "command": command(record),
    }


def context(data: ReportData) -> dict[str, Any]:
    return {"groups": {scene: [row(r) for r in data.of_scene(scene)] for scene in data.scenes if data.of_scene(scene)}}


SECTION = Section("records", "Records and commands", "", context)
