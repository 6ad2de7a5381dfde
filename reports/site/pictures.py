"""python -m reports.site.pictures [REPORT]: the pictures of the README, from the files of a report (reports/out)."""

import base64
import io
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from rich.console import Console
from rich.text import Text

from cross_checks.records.figures import work_precision
from mbs_ref import Settings, scenes
from mbs_ref.files import write_atomic
from mbs_ref.scene.toml import loads
from mbs_ref.simulate import simulate
from reports.film.files import filmstrip, png
from reports.page.build import drawn, read_data
from reports.page.render import INDEX

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
SCREEN = (1400, 900)  # pixels of the report's first screen
PANEL = (1100, 740)  # pixels of a mechanism above its plot
COLUMNS = 110  # characters of the terminal
SCENE = scenes.make("pendulum_chain", links=3)  # of every report, a quick one too
MOMENTS = 4  # of the run
SESSION = "mbs-ref simulate slider_crank --plot"
PAGE = """<!doctype html><meta charset="utf-8"><body style="margin: 0; background: #fff; font-family: sans-serif">
<img style="width: 100%%" src="data:image/png;base64,%s">%s"""


def mechanism(report: Path) -> bytes:
    """Return moments of SCENE above its work-precision plot of a report's records, as PNG."""
    strip = filmstrip(SCENE, simulate(SCENE, Settings(estimate="off")), MOMENTS)
    label = scenes.label(SCENE.name, SCENE.parameters)
    records = [record for record in read_data(report).records if record.label == label]
    figure = work_precision(records)
    figure.for_each_trace(lambda line: line.update(name=line.legendgroup, legendgrouptitle=None))
    figure.data = list(figure.select_traces(lambda line: line.visible is None))  # the frontier of each engine
    plot = figure.to_html(include_plotlyjs=True, full_html=False, config={"displayModeBar": False})
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "mechanism.html"
        page.write_text(PAGE % (base64.b64encode(strip).decode(), plot), encoding="utf-8")
        return screenshot(page, PANEL)


def swing(report: Path) -> bytes:
    """Return moments of the tutorial's scene file, as PNG."""
    scene = loads((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0])
    return filmstrip(scene, simulate(scene, Settings(estimate="off")), MOMENTS)


def terminal(report: Path) -> bytes:
    """Return the command SESSION with what it prints, as SVG."""
    program, *words = shlex.split(SESSION)
    command = [Path(sys.executable).with_name(program), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    console.print(Text(f"$ {SESSION}", style="bold"), Text(done.stdout.rstrip()), sep="\n")
    return console.export_svg(title="mbs-ref", unique_id="terminal").encode()


PICTURES = {
    "report.png": lambda report: screenshot(report / INDEX, SCREEN), "terminal.svg": terminal,
    "mechanism.png": mechanism, "swing.png": swing,
}  # fmt: skip


def screenshot(page: Path, size: tuple[int, int]) -> bytes:
    """Return a page as a browser without a window draws it, as PNG. FileNotFoundError where no browser is installed."""
    content = drawn(page.resolve().as_uri(), "--screenshot", f"--window-size={size[0]},{size[1]}")
    return png(Image.open(io.BytesIO(content)).convert("RGB"))


if __name__ == "__main__":
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "reports" / "out"
    IMAGES.mkdir(exist_ok=True)
    for name, picture in PICTURES.items():
        print(name, file=sys.stderr, flush=True)
        write_atomic(IMAGES / name, picture(source))
