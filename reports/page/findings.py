"""Findings: what went wrong, in sentences derived from the data, each by one rule that names no engine."""

from collections.abc import Iterator
from typing import Any

from cross_checks.judge.vocabulary import SILENT, WRONG, Cell, Verdict
from cross_checks.records.numbers import closure, count, of_scene, short
from mbs_ref import Status
from reports.facts.report_data import Finding, ReportData, Section
from reports.page.slug import command, scene_file

CAUGHT = (Status.NON_FINITE, Status.RESET)  # what engines do without reporting it
ORDER_SLACK = 0.5  # an observed order lower than documented by more than this is worth a sentence
FIRST = 6  # findings on the first screen


def findings(data: ReportData) -> list[Finding]:
    """Return every finding: the largest error delivered as a success first, then what was noticed."""
    return sorted((finding for rule in RULES for finding in rule(data)), key=lambda f: (-f.error, f.tone))


def wrong_answers(data: ReportData) -> Iterator[Finding]:
    """Methods whose runs fail or report success and are wrong, those of an engine with one verdict together."""
    good = {(c.engine, c.label): c.method for c in data.cells if c.tone == "good"}
    for word in sorted(WRONG, key=list(Verdict).index):
        for engine, methods, cells in grouped(data, word):
            worst = max(cells, key=lambda c: c.error or 0.0)
            sibling = good.get((engine, worst.label))
            beside = f", where {sibling} of the same engine agrees" if sibling else ""
            text = f"It fails on {_scenes(cells)}{beside}."
            if word in SILENT and worst.error is not None:
                closed = f" and joints closed within {closure(worst.compliance)}" if worst.compliance else ""
                text = f"Success is reported{closed}, {of_scene(worst.error)} from the truth on {worst.label}{beside}."
                others = _scenes([cell for cell in cells if cell.label != worst.label])
                text += f" Also on {others}." if others else ""
            error = (worst.error or 0.0) if word in SILENT else 0.0
            why = f"{worst.reason}; documented: {worst.exemption}" if worst.exemption else worst.reason
            yield _of(worst, worst.tone, f"{engine} {methods}: {word}", text, error, _sentence(why))


def silent_failures(data: ReportData) -> Iterator[Finding]:
    """Runs that engines ended silently and the adapters caught."""
    caught = [r for r in data.records if r.status in CAUGHT]
    for key in dict.fromkeys((r.engine, r.method, r.status) for r in caught):
        own = [r for r in caught if (r.engine, r.method, r.status) == key]
        scenes = ", ".join(dict.fromkeys(r.label for r in own))
        text = f"{count(len(own), 'run')} on {scenes} ended so."
        title = f"{key[0]} {key[1]}: {key[2]}, caught by the adapter"
        yield Finding("bad", title, text, 0.0, own[0].label, command(own[0]), _sentence(own[0].message))


def low_orders(data: ReportData) -> Iterator[Finding]:
    """Methods whose observed order falls short of the documented one."""
    for c in data.cells:
        if c.order is not None and c.verdict not in SILENT and c.order < (c.documented_order or 0) - ORDER_SLACK:
            title = f"{c.engine} {c.method}: order {short(c.order)} instead of {c.documented_order}"
            yield _of(c, "fair", title, f"On {c.label}.")


def _of(cell: Cell, tone: str, title: str, text: str, error: float = 0.0, why: str = "") -> Finding:
    return Finding(tone, title, text, error, cell.label, f"mbs-ref rerun {cell.name}", why)


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
    """Return a reason as a sentence, with its capital and full stop."""
    return text[:1].upper() + text[1:] + ("" if not text or text.endswith((".", "!", "?")) else ".")


def _scenes(cells: list[Cell]) -> str:
    return ", ".join(dict.fromkeys(c.label for c in cells))


def context(data: ReportData, most: int | None = None) -> dict[str, Any]:
    every = findings(data)
    return {"findings": every[:most], "number": len(every), "file": scene_file}


RULES = (wrong_answers, silent_failures, low_orders)
SECTION = Section("findings", "What went wrong", context)
WORST = Section("worst", "What went wrong", lambda data: context(data, FIRST), template="findings.html")
