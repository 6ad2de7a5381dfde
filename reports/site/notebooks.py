"""python -m reports.site.notebooks FOLDER: run the notebooks in FOLDER/notebooks, and make pages of them.

A cell that raises ends it. Figures are drawn by plotly's own script, which is written beside the pages: nothing is
fetched. Needs the extra `notebooks`.
"""

import html
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LIMIT = 900  # s, of a cell
SCRIPT = "plotly.min.js"
DRAW = Path(__file__).parent / "templates" / "draw.html"
FIGURE = "application/vnd.plotly.v1+json"


def executed(notebook: Path) -> Any:
    """Return the notebook with its outputs; CellExecutionError where a cell raises."""
    import nbformat  # pyright: ignore[reportMissingImports]
    from nbclient import NotebookClient  # pyright: ignore[reportMissingImports]

    os.environ["PLOTLY_RENDERER"] = "plotly_mimetype"  # of the kernel, which inherits it
    sentence = nbformat.read(notebook, as_version=4)
    NotebookClient(sentence, timeout=LIMIT, kernel_name="python3").execute(cwd=str(notebook.parent))
    return sentence


def page(notebook: Any, name: str) -> str:
    """Return an executed notebook as Markdown with HTML."""
    parts = [part for k, cell in enumerate(notebook.cells) for part in _cell(cell, f"{name}-{k}")]
    link = f"[This page as a notebook]({name}.ipynb)"
    draw = DRAW.read_text(encoding="utf-8")
    return "\n\n".join([*parts, link, f'<script src="{SCRIPT}"></script>', draw])


def _cell(cell: Any, name: str) -> Iterator[str]:
    if cell.cell_type == "markdown":
        yield cell.source
        return
    yield f"```python\n{cell.source}\n```"
    for k, output in enumerate(cell.outputs):
        if output.output_type == "stream":
            yield _text(output.text)
        elif output.output_type in ("display_data", "execute_result"):
            yield _shown(output.data, f"{name}-{k}")


def _shown(data: Any, name: str) -> str:
    """Return the richest form of an output that a page can show."""
    if FIGURE in data:
        figure = json.dumps({key: data[FIGURE][key] for key in ("data", "layout")}).replace("</", "<\\/")
        return f'<div id="{name}"></div><script type="application/json" data-figure="{name}">{figure}</script>'
    if "text/html" in data:
        lines = (line for line in str(data["text/html"]).splitlines() if line.strip())  # a blank one ends the HTML
        return "<div>" + "\n".join(lines) + "</div>"
    return _text(data["text/plain"])


def _text(text: str) -> str:
    lines = html.escape(text.rstrip()).replace("\n\n", "\n&#8203;\n")
    return f"<pre>{lines}</pre>"


def write_pages(folder: Path) -> None:
    """Run every notebook of FOLDER/notebooks, and write its page beside it."""
    from plotly.offline import get_plotlyjs

    for notebook in sorted((folder / "notebooks").glob("*.ipynb")):
        print(f"running {notebook.name}", file=sys.stderr, flush=True)
        notebook.with_suffix(".md").write_text(page(executed(notebook), notebook.stem), encoding="utf-8")
    (folder / "notebooks" / SCRIPT).write_text(get_plotlyjs(), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m reports.site.notebooks FOLDER")
    write_pages(Path(sys.argv[1]))
