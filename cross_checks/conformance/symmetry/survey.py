"""What symmetry leaves of each engine, as plain data: every violation with its size."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from cross_checks import engines
from cross_checks.conformance.cases import Case
from cross_checks.conformance.symmetry.violation import NotRunError, violations
from cross_checks.isolation.parent import Isolated, Lost

PATIENCE = 300.0  # s of one case: some twelve runs


def facts(case: Case) -> dict[str, Any]:
    """Return how many symmetries could be judged, those broken beyond roundoff, and why there is none."""
    try:
        found = violations(engines.get(case.engine), case.built(), case.settings)
    except NotRunError as error:
        return _told(case, stopped=str(error))
    broken = [asdict(one) | {"exceeds_error": one.exceeds_error} for one in found if one.is_broken]
    return _told(case, judged=sum(one.size is not None for one in found), broken=broken)


def isolated(case: Case, call: Isolated) -> dict[str, Any]:
    """Return the facts of a case that is run in a child process, which may not come back."""
    call.timeout = PATIENCE
    try:
        return call(facts, case)
    except Lost as error:
        return _told(case, stopped=f"{error.status}: {error}")


def _told(case: Case, *, judged: int = 0, broken: list[dict[str, Any]] | None = None, stopped: str = "") -> dict:
    return {"engine": case.engine, "method": case.method, "scene": case.scene, "parameters": case.parameters,
            "setting": case.setting, "judged": judged, "broken": broken or [], "stopped": stopped}  # fmt: skip


def by_method(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each engine and method: cases run, symmetries judged, and what is broken beyond what."""
    rows = []
    for engine, method in dict.fromkeys((one["engine"], one["method"]) for one in found):
        mine = [one for one in found if (one["engine"], one["method"]) == (engine, method)]
        broken = [each for one in mine for each in one["broken"]]
        rows.append({
            "engine": engine, "method": method, "cases": len(mine),
            "stopped": sum(bool(one["stopped"]) for one in mine),
            "judged": sum(one["judged"] for one in mine), "broken": len(broken),
            "beyond_error": sum(each["exceeds_error"] for each in broken),
        })  # fmt: skip
    return rows
