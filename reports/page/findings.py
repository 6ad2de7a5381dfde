"""Findings: sentences derived from the data, each by one rule that names no engine."""

from __future__ import annotations

from collections.abc import Iterator

from cross_checks.judge.vocabulary import OURS, WRONG, Cell, Verdict
from cross_checks.records.cost import known_error, loop_time, usable
from cross_checks.records.numbers import count, duration, joules, metres, of_scene, setting, short
from cross_checks.records.record import Record
from mbs_ref.trajectory import Status
from reports.facts.cheapest import MIDDLE, entries, standing_of
from reports.facts.report_data import Finding, ReportData, Section
from reports.studies.study import every

CAUGHT = (Status.NON_FINITE, Status.RESET)  # what engines do without saying so
ORDER_SLACK = 0.5  # an observed order lower than documented by more than this is worth a sentence
CLOSED_JOINTS = 1e-8  # m, compliance that looks perfect
FAR_OFF = 1e-2  # of the scene, an error anyone would mind
CONSERVED = 1e-6  # J, energy drift that looks perfect
MOST = 8  # findings of one rule shown


def findings(data: ReportData) -> list[Finding]:
    """Return every finding, the most alarming rule first."""
    rules = (*RULES, *(study.findings for study in every().values()))
    return [finding for rule in rules for finding in list(rule(data))[:MOST]]


def wrong_limits(data: ReportData) -> Iterator[Finding]:
    """Methods that converge to another answer."""
    for engine, methods, cells in grouped(data, Verdict.WRONG_LIMIT):
        worst = max((c.error for c in cells if c.error is not None), default=None)
        where = f"on {_scenes(cells)} it stays up to {of_scene(worst)} away however fine the setting"
        text = f"It converges, but not to the truth: {where}. {_sentence(cells[0].reason)}"
        yield Finding("bad", f"{engine} {methods}: a wrong limit", text.strip())


def failing_beside_a_sibling(data: ReportData) -> Iterator[Finding]:
    """Methods that fail where another method of the same engine agrees."""
    good = {(c.engine, c.label): c.method for c in data.cells if c.tone == "good"}
    for word in sorted(WRONG - {Verdict.WRONG_LIMIT}, key=list(Verdict).index):
        for engine, methods, cells in grouped(data, word):
            sibling = next((good[engine, c.label] for c in cells if (engine, c.label) in good), None)
            beside = f", where {sibling} agrees" if sibling else ""
            text = f"It does not reach the truth on {_scenes(cells)}{beside}. {_sentence(cells[0].reason)}"
            yield Finding("bad", f"{engine} {methods}: {word}", text.strip())


def silent_failures(data: ReportData) -> Iterator[Finding]:
    """Runs that engines ended silently and the adapters caught."""
    caught = [r for r in data.records if r.status in CAUGHT]
    for key in dict.fromkeys((r.engine, r.method, r.status) for r in caught):
        own = [r for r in caught if (r.engine, r.method, r.status) == key]
        scenes = ", ".join(dict.fromkeys(r.label for r in own))
        text = f"{count(len(own), 'run')} on {scenes} ended so. {_sentence(own[0].message)}"
        yield Finding("bad", f"{key[0]} {key[1]}: {key[2]}, caught by the adapter", text)


def low_orders(data: ReportData) -> Iterator[Finding]:
    """Methods whose observed order falls short of the documented one."""
    low = [
        f"{c.engine} {c.method} on {c.label}: {short(c.order)} instead of {c.documented_order}"
        for c in data.cells
        if c.order is not None and c.verdict not in (Verdict.WRONG_LIMIT, Verdict.LOST)
        and c.order < (c.documented_order or 0) - ORDER_SLACK
    ]  # fmt: skip
    if low:
        yield Finding("fair", "Observed orders below the documented ones", "; ".join(low) + ".")


def perfect_but_wrong(data: ReportData) -> Iterator[Finding]:
    """Methods whose joints or energy look perfect at their finest setting while the motion is wrong."""
    far = [r for r in _finest(data) if known_error(r) > FAR_OFF]
    closed = [r for r in far if (r.measure("compliance_position") or 1.0) < CLOSED_JOINTS]
    conserving = [r for r in far if (r.measure("energy_drift") or CONSERVED) < CONSERVED]
    if closed:
        text = f"Joints closed within {metres(CLOSED_JOINTS)}, and yet the motion is wrong: {_listed(closed)}."
        yield Finding("fair", "Closed joints do not prove a right answer", text)
    if conserving:
        text = f"Energy conserved within {joules(CONSERVED)}, and yet the motion is wrong: {_listed(conserving)}."
        yield Finding("fair", "Conserved energy does not prove a right answer", text)


def _finest(data: ReportData) -> list[Record]:
    """Return the most accurate finished record of each scene, engine and method."""
    best: dict[tuple[str, str, str], Record] = {}
    for record in filter(usable, data.records):
        key = (record.label, record.engine, record.method)
        if key not in best or known_error(record) < known_error(best[key]):
            best[key] = record
    return list(best.values())


def _run(record: Record) -> str:
    return f"{record.engine} {record.method} on {record.label}"


def _listed(records: list[Record]) -> str:
    worst = sorted(records, key=known_error, reverse=True)
    named = [f"{_run(record)} is {of_scene(known_error(record))} off" for record in worst]
    more = [f"{len(named) - MOST} more"] if len(named) > MOST else []
    return "; ".join(named[:MOST] + more)


def fastest(data: ReportData) -> Iterator[Finding]:
    """Which of the other engines is cheapest on how many scenes, by what margin, and how our own solver compares."""
    result = {s: [e.best for e in entries(data, s, MIDDLE) if e.best and e.engine != OURS] for s in data.scenes}
    reached = {scene: bests for scene, bests in result.items() if bests}
    for engine in dict.fromkeys(bests[0].engine for bests in reached.values()):
        won = {scene: bests for scene, bests in reached.items() if bests[0].engine == engine}
        margins = [loop_time(bests[1]) / loop_time(bests[0]) for bests in won.values() if len(bests) > 1]
        where = f"{len(won)} of {count(len(data.scenes), 'scene')}"
        title = f"Of the other engines {engine} is cheapest within {short(MIDDLE)} on {where}"
        parts = "; ".join(f"{scene}: {_cost(bests[0])}" for scene, bests in won.items())
        ending = f" The next engine takes {_span(margins)} times as long." if margins else ""
        yield Finding("good", title, f"{parts}.{ending}")
    yield from _ours(data)


def _ours(data: ReportData) -> Iterator[Finding]:
    standing = standing_of(data, OURS, MIDDLE)
    if standing is not None and standing.factors:
        ratios = list(standing.factors.values())
        text = f"Its time over that of the cheapest other engine: {_span(ratios)} on {count(len(ratios), 'scene')}."
        yield Finding("plain", f"Our own solver beside them, within {short(MIDDLE)}", text)


def _cost(record: Record) -> str:
    return f"{record.method}, {setting(record.settings)}, {duration(loop_time(record))}"


def _span(ratios: list[float]) -> str:
    low, high = short(min(ratios)), short(max(ratios))
    return low if low == high else f"{low} to {high}"


def grouped(data: ReportData, word: Verdict) -> Iterator[tuple[str, str, list[Cell]]]:
    """Yield engine, methods in words, and cells: the methods of an engine that share verdict and scenes together."""
    met = [c for c in data.cells if c.verdict is word]
    shared: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for engine, method in dict.fromkeys((c.engine, c.method) for c in met):
        scenes = tuple(c.label for c in met if (c.engine, c.method) == (engine, method))
        shared.setdefault((engine, scenes), []).append(method)
    for (engine, _), methods in shared.items():
        yield engine, ", ".join(methods), [c for c in met if c.engine == engine and c.method in methods]


def _sentence(text: str) -> str:
    """Give a reason its capital and its full stop."""
    return text[:1].upper() + text[1:] + ("" if not text or text.endswith((".", "!", "?")) else ".")


def _scenes(cells: list[Cell]) -> str:
    return ", ".join(dict.fromkeys(c.label for c in cells))


LEAD = "What a reader should take away, worded from the data of this very report."
SECTION = Section("findings", "Findings", LEAD, lambda data: {"findings": findings(data)})
RULES = (wrong_limits, failing_beside_a_sibling, silent_failures, perfect_but_wrong, low_orders, fastest)
