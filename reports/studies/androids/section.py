"""The androids by method and engine: the paper's numerics beside others, stable steps, convergence, agreement."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.judge.matrix import Cell
from reports.page.numbers import ABSENT, duration, setting, short
from reports.page.plots.figure import new_figure, to_data
from reports.page.plots.histories import HEIGHT, add_line, histories
from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.studies.androids.measure import VERTEBRAL, AndroidFacts, Convergence, Run, Stable

LEAD = (
    "The paper's integrators and others on the same crash, judged by a truth made without the solver's code: "
    "Hamilton's equations in body angles, extrapolated from event to event. That of the vertebral android takes a "
    "minute to make: its poses are kept on disk, and mbs-ref certify android_vertebral makes it again."
)


def context(data: ReportData) -> dict[str, Any]:
    facts = data.androids
    if facts is None:
        return {"facts": None}
    names = list(dict.fromkeys(_label(run) for run in facts.runs))
    return {
        "facts": facts,
        "claim": _claim(facts),
        "runs": [_row(run) for run in facts.runs],
        "compliance": {name: _compliance([r for r in facts.runs if _label(r) == name]) for name in names},
        "stable": [_stable(found) for found in facts.stable],
        "convergence": [_converged(found) for found in facts.convergence],
        "gaps": _gaps(facts.convergence),
        "peers": [_peer(peer) for peer in facts.peers],
    }


def _claim(facts: AndroidFacts) -> str:
    """Say what these data do to the paper's figure, from the runs themselves."""
    said = "The paper reports that RK4 at h = 1e-4 s ends at t = 0.1115 s with a compliance of 1.8e-4"
    found = {run.method: _largest(run) for run in facts.runs if run.scene == "android_simplified"}
    if not {"rk4", "euler"} <= found.keys():
        return f"{said}."
    return (
        f"{said}. These data do not reproduce that: RK4 at this step, without stabilization, reaches 0.2 s with "
        f"{short(found['rk4'])} m, while Euler ends with {short(found['euler'])} m and fails the paper's own test "
        "|C| < h. On the vertebral android the paper's step is beyond what RK4 can bear with these data, and it runs "
        f"at half of it.{_lsodar(facts)}"
    )


def _lsodar(facts: AndroidFacts) -> str:
    """Say how the paper's adaptive method fares on the stiff android."""
    met = [run for run in facts.runs if run.scene == VERTEBRAL and run.method == "lsodar"]
    good = [run for run in met if run.path.ok]
    if not good:
        return "".join(f" LSODAR fails, as the paper saw: {run.path.message}." for run in met[:1])
    switches = [run.path.method_switches or 0 for run in good]
    return (
        f" LSODAR, which the paper saw fail on the stiffness, reaches the end in {len(good)} of {len(met)} runs: it "
        f"changes between Adams and BDF {min(switches)} to {max(switches)} times and restarts at every event."
    )


def _label(run: Run) -> str:
    return f"{run.scene}, {run.impact}"


def _largest(run: Run) -> float:
    kept = run.path.step_compliance
    return float("nan") if kept is None or not len(kept) else float(np.max(kept[:, 1]))


def _name(run: Run) -> str:
    return f"{run.method}, {setting({'step': run.settings.step, 'rtol': run.settings.rtol})}"


def _row(run: Run) -> list[str]:
    path = run.path
    switches = "none kept" if path.method_switches is None else str(path.method_switches)
    ended = "reached 0.2 s" if path.ok else f"{path.status}: {path.message}"
    figures = (path.steps, path.rejected_steps, path.rhs_calls, switches, path.events, duration(path.timing.loop_s))
    accuracy = (short(run.error), short(_largest(run)))
    return [_label(run), _name(run), ended, *accuracy, *map(str, figures), run.paper_test]


def _compliance(runs: list[Run]) -> dict[str, Any]:
    """Draw |C| over time, a line for each method and setting."""
    figure = new_figure("t, s", "largest |C| since the last sample, m", x_log=False)
    figure.update_layout(height=HEIGHT + 60)
    for k, run in enumerate(runs):
        if run.path.step_compliance is not None and len(run.path.step_compliance) > 1:
            times, gap = run.path.step_compliance[1:].T
            add_line(figure, k, _name(run), times, np.maximum(gap, 1e-17))
    return to_data(figure)


def _stable(found: Stable) -> dict[str, Any]:
    figure = new_figure("real part, 1/s", "imaginary part, 1/s", x_log=False, y_log=False)
    figure.update_layout(height=HEIGHT)
    modes = found.stiffness.modes
    parts = np.real(modes).tolist(), np.imag(modes).tolist()
    figure.add_scatter(x=parts[0], y=parts[1], mode="markers", name="eigenvalues")
    limits = ", ".join(f"{name} {short(limit)} s" for name, limit in found.limits.items())
    rules = {"1/omega": found.stiffness.oscillation_rule, "m/c": found.stiffness.damping_rule}
    told = ", ".join(f"{name} = {short(value)} s" for name, value in rules.items() if np.isfinite(value))
    return {
        "name": found.scene, "plot": to_data(figure), "decay": short(found.stiffness.fastest_decay, 3),
        "limits": limits, "rules": told, "beyond": short(found.beyond), "refusal": found.refusal,
        "forced": found.forced,
    }  # fmt: skip


def _converged(found: Convergence) -> list[str]:
    gaps = [short(float(gap.max())) for gap in found.gaps.values()]
    kept = [short(value) for value in found.compliance.values()]
    return [f"{found.scene}, {found.impact}", *gaps, *kept, short(found.error), short(found.uncertainty)]


def _gaps(found: tuple[Convergence, ...]) -> dict[str, Any]:
    lines = {f"{c.scene}, {c.impact}: {part}": gap[1:] for c in found for part, gap in c.gaps.items()}
    return histories(found[0].times[1:], lines, "distance, m", log=True)


def _peer(cell: Cell) -> list[str]:
    crash, method = f"{cell.scene}, {cell.parameters['impact']}", f"{cell.engine} {cell.method}"
    order = ABSENT if cell.order is None else f"{cell.order:.2f} (documented {cell.documented_order})"
    reactions = "none given" if cell.reaction_error is None else short(cell.reaction_error)
    figures = (short(cell.error), order, cell.setting or ABSENT, duration(cell.loop_s), reactions)
    return [crash, method, str(cell.verdict), *figures, cell.reason]


SECTION = Section(
    "android_numerics", "The androids by method and engine", LEAD, context, template="androids/section.html"
)
