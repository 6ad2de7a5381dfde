"""The androids by method and engine: the paper's numerics beside others, stable steps, convergence, agreement."""

from __future__ import annotations

from typing import Any

from reports.drawing.numbers import ABSENT, duration, in_words, order_of, setting, short
from reports.drawing.plots.figure import FLOOR, new_figure, to_data
from reports.drawing.plots.histories import HEIGHT, add_line, histories
from reports.drawing.section import Section
from reports.facts.curves import Curves
from reports.facts.report_data import ReportData
from reports.studies.androids.facts import AndroidFacts, Convergence, Peer, Run, Stable

LEAD = (
    "The paper's integrators and others on the same crash, judged by a truth made without the solver's code: "
    "Hamilton's equations in body angles, extrapolated from event to event. That of the vertebral android takes a "
    "minute to make: its poses are kept on disk, and mbs-ref certify android_vertebral makes it again."
)


VERTEBRAL = "android_vertebral"


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(AndroidFacts)
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
    crash = ("android_simplified", "front")  # the paper's
    found = {run.method: run.compliance for run in facts.runs if (run.scene, run.impact) == crash}
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
    good = [run for run in met if run.ok]
    if not good:
        return "".join(f" LSODAR fails, as the paper saw: {run.message}." for run in met[:1])
    switches = [run.switches or 0 for run in good]
    return (
        f" LSODAR, which the paper saw fail on the stiffness, reaches the end in {len(good)} of {len(met)} runs: it "
        f"changes between Adams and BDF {min(switches)} to {max(switches)} times and restarts at every event."
    )


def _label(run: Run) -> str:
    return f"{run.scene}, {run.impact}"


def _name(run: Run) -> str:
    return f"{run.method}, {setting(run.settings)}"


def _row(run: Run) -> list[str]:
    switches = "none kept" if run.switches is None else str(run.switches)
    ended = "reached 0.2 s" if run.ok else f"{run.status}: {run.message}"
    figures = (run.steps, run.rejected, run.rhs_calls, switches, run.events, duration(run.loop_s))
    return [_label(run), _name(run), ended, short(run.error), short(run.compliance), *map(str, figures), run.paper_test]


def _compliance(runs: list[Run]) -> dict[str, Any]:
    """Draw |C| over time, a line for each method and setting."""
    figure = new_figure("t, s", "largest |C| since the last sample, m", x_log=False, height=HEIGHT + 60)
    for k, run in enumerate(runs):
        if run.curve is not None:
            add_line(figure, k, _name(run), run.curve.x, [max(gap, FLOOR) for gap in run.curve.lines["|C|"]])
    return to_data(figure)


def _stable(found: Stable) -> dict[str, Any]:
    figure = new_figure("real part, 1/s", "imaginary part, 1/s", x_log=False, y_log=False, height=HEIGHT)
    figure.add_scatter(x=list(found.real), y=list(found.imaginary), mode="markers", name="eigenvalues")
    limits = ", ".join(f"{name} {short(limit)} s" for name, limit in found.limits.items())
    told = ", ".join(f"{name} = {short(value)} s" for name, value in found.rules.items())
    return {
        "name": found.scene, "plot": to_data(figure), "decay": short(found.fastest_decay, 3),
        "limits": limits, "rules": told, "beyond": short(found.beyond), "refusal": found.refusal,
        "forced": found.forced,
    }  # fmt: skip


def _converged(found: Convergence) -> list[str]:
    gaps = [short(max(gap)) for gap in found.gaps.lines.values()]
    kept = [short(value) for value in found.compliance.values()]
    return [f"{found.scene}, {found.impact}", *gaps, *kept, short(found.error), short(found.uncertainty)]


def _gaps(found: tuple[Convergence, ...]) -> dict[str, Any]:
    lines = {f"{c.scene}, {c.impact}: {part}": gap for c in found for part, gap in c.gaps.lines.items()}
    return histories(Curves(found[0].gaps.x, lines, "distance, m", log=True))


def _peer(peer: Peer) -> list[str]:
    cell = peer.cell
    crash, method = f"{cell.scene}, {cell.parameters['impact']}", f"{cell.engine} {cell.method}"
    reactions = "none given" if peer.reaction_error is None else short(peer.reaction_error)
    shown = (order_of(cell.order, cell.documented_order), in_words(cell.setting))
    figures = (short(cell.error), *(text or ABSENT for text in shown), duration(cell.loop_s), reactions)
    return [crash, method, f"{cell.verdict} {cell.code}", *figures, cell.reason]


SECTION = Section("android_numerics", "The androids by method and engine", LEAD, context)
