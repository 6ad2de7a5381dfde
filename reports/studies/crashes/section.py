"""The androids of Fox 1999: the counterparts of the paper's figures, and what a detailed model changes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from reports.drawing.numbers import short
from reports.drawing.plots.histories import histories
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.studies.crashes.facts import Crash, CrashFacts, Whiplash

LEAD = (
    "Two planar crash occupants, 13 bodies, and 48 with every vertebra, at 50 km/h from the front and from the rear. "
    "These are the paper's bare models, without friction, joint stops or a toe-board: legs swing up, arms pass through "
    "the seat back from the rear, and the vertebral head through the thighs from the front. What stops, body_contacts "
    "and head_restraint of the scenes change stands under 'The papers and we' and 'What a model costs'; of the stops' "
    "ranges the spine's are estimates, which no table that we could read confirms level by level. TTI is made "
    "for side impacts; here it takes the accelerations of this one."
)
ABSENT = "rigid thorax"


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(CrashFacts)
    runs = [] if facts is None else list(facts.crashes)
    return {
        "androids": [_shown(run) for run in runs],
        "columns": [run.label for run in runs],
        "levels": _levels(runs) if runs else [],
        "changes": [_change(*pair) for pair in _pairs(runs)],
        "whiplash": [_whiplash(run.label, run.whiplash) for run in runs if run.whiplash],
    }


def _shown(run: Crash) -> dict[str, Any]:
    return {
        "name": run.label,
        "file": f"{run.android}-{run.impact}",
        "description": run.description,
        "film": run.film,
        "forces": {label: histories(found) for label, found in run.forces.items()},
        "plots": {label: histories(found) for label, found in run.plots.items()},
        "open": run.impact == "front",
    }


def _whiplash(label: str, found: Whiplash) -> dict[str, Any]:
    """Return the cervical torques and when they change sign."""
    return {
        "name": label,
        "plot": histories(found.torques),
        "rows": [
            (name, f"{found.largest[name]:.0f}", f"{found.least[name]:.0f}",
             ", ".join(f"{t:.3f} s" for t in when) or "never")
            for name, when in found.changes.items()
        ],
    }  # fmt: skip


def _levels(runs: list[Crash]) -> list[tuple[str, list[str]]]:
    """Return rows of what the detailed model changes, and its cost."""
    told = {
        "bodies": lambda run: str(run.bodies),
        "right-hand sides": lambda run: str(run.rhs_calls),
        "integration at rtol 1e-8, s": lambda run: f"{run.loop_s:.2f}",
        "largest |C|, m": lambda run: f"{run.compliance:.1e}",
        "energy less works, of the pulse's work": lambda run: f"{run.imbalance:.1e}",
        "peak seat force, N": lambda run: f"{run.peak_seat_force:.0f}",
        "peak belt force, N": lambda run: f"{run.peak_belt_force:.0f}",
        "head excursion, m": lambda run: f"{abs(run.head_excursion):.3f}",
        "hip excursion, m": lambda run: f"{abs(run.hip_excursion):.3f}",
    }
    rows = [(label, [tell(run) for run in runs]) for label, tell in told.items()]
    names = dict.fromkeys(name for run in runs for name in run.measures)
    return rows + [(name, [_measure(run, name) for run in runs]) for name in names]


def _pairs(runs: list[Crash]) -> list[tuple[Crash, Crash]]:
    """Return the coarser and the finer model of each impact that both ran in."""
    by_impact: dict[str, list[Crash]] = {}
    for run in sorted(runs, key=lambda run: run.bodies):
        by_impact.setdefault(run.impact, []).append(run)
    return [(pair[0], pair[1]) for pair in by_impact.values() if len(pair) == 2]


def _change(coarse: Crash, fine: Crash) -> dict[str, Any]:
    """Say and draw what the detailed model changes in one impact."""
    pair = (coarse, fine)
    figures = {
        "the head's travel along x": ("m", *(run.head_excursion for run in pair)),
        "the peak belt force": ("kN", *(run.peak_belt_force / 1e3 for run in pair)),
        "HIC36": ("", *(run.measures["HIC36"] for run in pair)),
        "Nij": ("", *(run.measures["Nij"] for run in pair)),
        "the right-hand sides": ("", *(float(run.rhs_calls) for run in pair)),
        "the time of integration": ("ms", *(1e3 * run.loop_s for run in pair)),
    }
    told = [f"{what} {short(a, 3)} to {short(b, 3)} {unit}".rstrip() for what, (unit, a, b) in figures.items()]
    return {
        "name": f"impact from the {coarse.impact}",
        "told": f"From {coarse.bodies} to {fine.bodies} bodies: {'; '.join(told)}.",
        "plots": {name: _both(coarse, fine, name) for name in coarse.compared},
    }


def _both(coarse: Crash, fine: Crash, name: str) -> dict[str, Any]:
    lines = {f"{run.bodies} bodies": run.compared[name].lines[name] for run in (coarse, fine)}
    return histories(replace(coarse.compared[name], lines=lines))


def _measure(run: Crash, name: str) -> str:
    value = run.measures.get(name)
    return ABSENT if value is None else f"{value:.4g}"


SECTION = Section("androids", "The androids of the first paper", LEAD, context)
