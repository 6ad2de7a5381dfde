"""Findings: sentences derived from the data, each by one rule that names no engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cross_checks.record import Record
from mbs_ref.trajectory import Status
from reports.page.cheapest import entries, known_error, usable
from reports.page.numbers import count, duration, joules, metres, setting, short
from reports.page.report_data import Cell, ReportData, scene_label
from reports.page.verdicts import verdict

SILENT = (Status.NON_FINITE, Status.RESET)  # what engines do without saying so
ORDER_SLACK = 0.5  # an observed order lower than documented by more than this is worth a sentence
CLOSED_JOINTS = 1e-8  # m, compliance that looks perfect
FAR_OFF = 1e-2  # m, an error anyone would mind
CONSERVED = 1e-6  # J, energy drift that looks perfect
MOST = 8  # findings of one rule shown


@dataclass(frozen=True)
class Finding:
    """One sentence with its title and tone (good | fair | bad | plain)."""

    tone: str
    title: str
    text: str


def findings(data: ReportData) -> list[Finding]:
    """Return every finding, the most alarming rule first."""
    return [finding for rule in RULES for finding in list(rule(data))[:MOST]]


def wrong_limits(data: ReportData) -> Iterator[Finding]:
    """Methods that converge to another answer."""
    for engine, method, cells in _by_method(data, {"wrong-limit"}):
        worst = max((c.error for c in cells if c.error is not None), default=None)
        where = f"on {_scenes(cells)} it stays up to {metres(worst)} away however small the step"
        text = f"It converges, but not to the truth: {where}. {_sentence(cells[0].reason)}"
        yield Finding("bad", f"{engine} {method}: a wrong limit", text.strip())


def failing_beside_a_sibling(data: ReportData) -> Iterator[Finding]:
    """Methods that fail where another method of the same engine agrees."""
    good = {(c.engine, c.scene): c.method for c in data.cells if verdict(c.verdict).tone == "good"}
    for engine, method, cells in _by_method(data, {"failed", "diverged", "crashed", "timeout"}):
        sibling = next((good[engine, c.scene] for c in cells if (engine, c.scene) in good), None)
        beside = f" where {sibling} agrees" if sibling else ""
        text = f"It does not reach the truth on {_scenes(cells)}{beside}. {_sentence(cells[0].reason)}"
        yield Finding("bad", f"{engine} {method}: {cells[0].verdict}", text.strip())


def silent_failures(data: ReportData) -> Iterator[Finding]:
    """Runs that engines ended silently and the adapters caught."""
    caught = [r for r in data.records if r.status in SILENT]
    for key in dict.fromkeys((r.engine, r.method, r.status) for r in caught):
        own = [r for r in caught if (r.engine, r.method, r.status) == key]
        scenes = ", ".join(dict.fromkeys(scene_label(r.scene, r.parameters) for r in own))
        text = f"{count(len(own), 'run')} on {scenes} ended so. {_sentence(own[0].message)}"
        yield Finding("bad", f"{key[0]} {key[1]}: {key[2]}, caught by the adapter", text)


def low_orders(data: ReportData) -> Iterator[Finding]:
    """Methods whose observed order falls short of the documented one."""
    for cell in data.cells:
        documented = data.orders.get((cell.engine, cell.method))
        if documented is None or cell.order is None or cell.verdict == "wrong-limit":
            continue
        if cell.order < documented - ORDER_SLACK:
            text = f"On {cell.scene} the error falls with order {short(cell.order)}; the method documents {documented}."
            yield Finding("fair", f"{cell.engine} {cell.method}: order below its documentation", text)


def perfect_but_wrong(data: ReportData) -> Iterator[Finding]:
    """Runs whose joints or energy look perfect while the motion is wrong."""
    for record in sorted((r for r in data.records if usable(r)), key=known_error, reverse=True):
        if known_error(record) < FAR_OFF:
            return
        gap, drift = record.compliance.get("position"), record.energy_drift
        looks = [f"its joints are closed to {metres(gap)}"] if gap is not None and gap < CLOSED_JOINTS else []
        looks += [f"its energy holds to {joules(drift)}"] if drift is not None and drift < CONSERVED else []
        if looks:
            title = f"{record.engine} {record.method}: looks perfect, is {metres(known_error(record))} off"
            where = f"On {scene_label(record.scene, record.parameters)} at {setting(record.settings)}"
            moral = "Compliance and energy are necessary, not sufficient."
            yield Finding("fair", title, f"{where} {' and '.join(looks)}. {moral}")


def fastest(data: ReportData) -> Iterator[Finding]:
    """Who is cheapest at a micrometre on how many scenes, and by what margin."""
    ranked = {scene: entries(data.of_scene(scene), data.engines, 1e-6) for scene in data.scenes}
    found = {scene: [entry.best for entry in ranking if entry.best] for scene, ranking in ranked.items()}
    reached = {scene: bests for scene, bests in found.items() if bests}
    for engine in dict.fromkeys(bests[0].engine for bests in reached.values()):
        won = {scene: bests for scene, bests in reached.items() if bests[0].engine == engine}
        margins = [bests[1].times["loop_s"] / bests[0].times["loop_s"] for bests in won.values() if len(bests) > 1]
        title = f"{engine} is cheapest within 1e-6 m on {len(won)} of {count(len(data.scenes), 'scene')}"
        parts = "; ".join(f"{scene}: {_cost(bests[0])}" for scene, bests in won.items())
        ending = f" The next engine takes {_span(margins)} times as long." if margins else ""
        yield Finding("good", title, f"{parts}.{ending}")


def _cost(record: Record) -> str:
    return f"{record.method}, {setting(record.settings)}, {duration(record.times['loop_s'])}"


def _span(ratios: list[float]) -> str:
    low, high = short(min(ratios)), short(max(ratios))
    return low if low == high else f"{low} to {high}"


def _by_method(data: ReportData, words: set[str]) -> Iterator[tuple[str, str, list[Cell]]]:
    met = [c for c in data.cells if c.verdict in words]
    for engine, method in dict.fromkeys((c.engine, c.method) for c in met):
        yield engine, method, [c for c in met if (c.engine, c.method) == (engine, method)]


def _sentence(text: str) -> str:
    """Give a reason its capital and its full stop."""
    return text[:1].upper() + text[1:] + ("" if not text or text.endswith((".", "!", "?")) else ".")


def _scenes(cells: list[Cell]) -> str:
    return ", ".join(c.scene for c in cells)


RULES = (wrong_limits, failing_beside_a_sibling, silent_failures, perfect_but_wrong, low_orders, fastest)
