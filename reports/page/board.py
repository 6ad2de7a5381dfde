"""The neutral board of a release: engines ranked at equal error from kept records, one page that stands alone.

Our own solver is shown apart and takes no part in any ranking, nor is it what others are measured by. Each claim has an
anchor to link to, and the command that makes its run again.
"""

from __future__ import annotations

from statistics import median
from typing import Any, NamedTuple

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import WRONG
from reports.drawing.numbers import short
from reports.facts.cheapest import entries, loop_time
from reports.facts.report_data import OURS, Cell, ReportData
from reports.page.render import templates
from reports.page.sections.prices import inside, price_table
from reports.page.slug import slug


class Standing(NamedTuple):
    """How an engine does at one target, over all scenes of the report."""

    engine: str
    reached: int  # scenes
    cheapest: int  # of those, among the ranked engines
    factor: float | None  # median of its time over the cheapest ranked engine's, where it reached the target


def standings(data: ReportData, target: float) -> list[Standing]:
    """Return the ranked engines, the one that is cheapest most often first; then ours, which no rank counts."""
    found = {scene: entries(data, scene, target) for scene in data.scenes}
    best = {scene: [e for e in each if e.best and e.engine != OURS][:1] for scene, each in found.items()}

    def standing(engine: str) -> Standing:
        own = {scene: e for scene, each in found.items() for e in each if e.engine == engine and e.best is not None}
        against = [scene for scene in own if best[scene]]
        ratios = [loop_time(own[s].best) / loop_time(best[s][0].best) for s in against]  # type: ignore[arg-type]
        first = sum(best[s][0].engine == engine for s in against)
        return Standing(engine, len(own), first, median(ratios) if ratios else None)

    ranked = [standing(name) for name in data.engines if name != OURS]
    ranked = [one for one in ranked if one.reached]
    ranked.sort(key=lambda one: (-one.cheapest, -one.reached, one.factor or float("inf")))
    return ranked + [standing(name) for name in data.engines if name == OURS]


def board(data: ReportData) -> bytes:
    """Return the page: text from the data is escaped, nothing is loaded from elsewhere, nothing runs."""
    ranks = [
        {"target": short(target), "anchor": f"rank-{short(target)}", "rows": standings(data, target)}
        for target in TARGETS
    ]
    wrong = [claim(cell) for cell in data.cells if cell.verdict in WRONG and cell.engine != OURS]
    own = [claim(cell) for cell in data.cells if cell.verdict in WRONG and cell.engine == OURS]
    scenes = [{"name": scene, "anchor": slug(scene), "blocks": _blocks(data, scene)} for scene in data.scenes]
    context = {"ranks": ranks, "wrong": wrong, "own": own, "scenes": scenes, "inside": inside(data), "ours": OURS}
    return templates().get_template("board.html").render(data=data, short=short, **context).encode()


def _blocks(data: ReportData, scene: str) -> list[dict[str, Any]]:
    """Return the scene's prices, an anchor a claim."""
    blocks = price_table(data, scene)
    for block in blocks:
        block["rows"] = [row | {"anchor": slug(f"{scene} {block['target']} {row['engine']}")} for row in block["rows"]]
    return blocks


def claim(cell: Cell) -> dict[str, str]:
    """Return a verdict that accuses, with what makes it again."""
    again = f"mbs-ref rerun {cell.name}"
    return {
        "anchor": slug(f"{cell.scene} {cell.engine} {cell.method}"), "scene": cell.scene, "engine": cell.engine,
        "method": cell.method, "verdict": cell.verdict, "reason": cell.reason, "excuse": cell.excuse, "command": again,
    }  # fmt: skip
