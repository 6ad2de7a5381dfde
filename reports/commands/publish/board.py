"""mbs-ref board: one page of a release, engines ranked at equal error from stored records.

Our own solver is shown apart and takes no part in any ranking, nor is it what others are measured by. Each claim has an
anchor to link to, and the command that repeats its run.
"""

from pathlib import Path
from typing import Any

import click

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import OURS, WRONG, Cell
from cross_checks.records.numbers import short
from mbs_ref.files import write_atomic
from reports import inputs
from reports.commands.publish.show import last_report
from reports.facts.report_data import ReportData, standings
from reports.page.render import templates
from reports.page.sections.matrix import view
from reports.page.sections.prices import inside, price_table
from reports.page.slug import slug


@click.command(name="board", epilog="Example: mbs-ref board -o board.html")
@click.option("-o", "output", default="board.html", show_default=True, metavar="FILE.html", help="Where to write.")
@click.option(
    "--from", "folder", default="reports/out", show_default=True, type=inputs.FOLDER, help="Where the report is."
)
def command(output: str, folder: Path) -> None:
    """Write one page from the last report, to be published.

    Nothing is run. Every number has the command that makes it again, every claim an anchor to link to; our own solver
    is shown apart, and ranked nowhere.
    """
    target = inputs.output(output, (".html",))
    assert target is not None
    write_atomic(target, board(last_report(folder)))
    click.echo(str(target))


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


def claim(cell: Cell) -> dict[str, Any]:
    """Return a verdict that classifies a method as wrong, with the command that repeats it."""
    return view(cell) | {"anchor": slug(f"{cell.label} {cell.engine} {cell.method}")}
