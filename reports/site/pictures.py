"""python -m reports.site.pictures [REPORT]: the pictures of the README, from the files of a report (reports/out)."""

from __future__ import annotations

import base64
import io
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from PIL import Image
from rich.console import Console
from rich.text import Text

from cross_checks.records.figures import work_precision
from mbs_ref import scenes
from mbs_ref.atomic_file import write_atomic
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.film.files import beside
from reports.page.build import read_data
from reports.page.render import INDEX

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
SCREEN = (1400, 900)  # pixels of the report's first screen
PANEL = (1400, 620)  # pixels of a mechanism beside its plot
LOADING_MS = 10_000  # ms of a page's own time until it is drawn
COLOURS = 128  # of a PNG: text stays smooth, and the file below 200 kB
COLUMNS = 110  # characters of the terminal
SCENE = "slider_crank"
SAMPLE = 20  # of the run whose pose is drawn
SESSION = ("mbs-ref simulate pendulum --rtol 1e-12 --t-end 10", "mbs-ref simulate slider_crank --plot")
PAGE = """<!doctype html><meta charset="utf-8"><style>
body { margin: 0; display: flex; align-items: center; background: #fff; font-family: sans-serif; }
img { width: 560px; } body > div { flex: 1; }
</style><img src="data:image/png;base64,%s"><div>%s</div>"""


def first_screen(report: Path) -> bytes:
    """Return the first screen of a report as PNG."""
    return screenshot(report / INDEX, SCREEN)


def mechanism(report: Path) -> bytes:
    """Return a pose of SCENE beside its work-precision plot of a report's records, as PNG."""
    scene = scenes.make(SCENE)
    pose, drawn = io.BytesIO(), beside(scene, {"": simulate(scene, Settings(estimate="off"))})[SAMPLE]
    drawn.save(pose, "PNG")
    records = [record for record in read_data(report).records if record.label == SCENE]
    plot = work_precision(records).to_html(include_plotlyjs=True, full_html=False)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "mechanism.html"
        page.write_text(PAGE % (base64.b64encode(pose.getvalue()).decode(), plot), encoding="utf-8")
        return screenshot(page, PANEL)


def terminal(report: Path) -> bytes:
    """Return the commands of SESSION with what they print, as SVG."""
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    for line in SESSION:
        program, *words = shlex.split(line)
        done = subprocess.run(
            [Path(sys.executable).with_name(program), *words], capture_output=True, text=True, check=True
        )
        console.print(Text(f"$ {line}", style="bold"))
        console.print(Text(done.stdout.rstrip()), "", sep="\n")
    return console.export_svg(title="mbs-ref", unique_id="terminal").encode()


PICTURES: dict[str, Callable[[Path], bytes]] = {
    "report.png": first_screen,
    "mechanism.png": mechanism,
    "terminal.svg": terminal,
}


def screenshot(page: Path, size: tuple[int, int]) -> bytes:
    """Return a page as a browser without a window draws it, as PNG. FileNotFoundError where no browser is installed."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise FileNotFoundError(f"a screenshot needs one of {', '.join(BROWSERS)}")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "page.png"
        options = ("--headless", "--no-sandbox", "--hide-scrollbars", f"--user-data-dir={folder}/profile")
        shown = (f"--virtual-time-budget={LOADING_MS}", f"--window-size={size[0]},{size[1]}")
        command = [browser, *options, *shown, f"--screenshot={target}", page.resolve().as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        picture = Image.open(target).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


if __name__ == "__main__":
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "reports" / "out"
    IMAGES.mkdir(exist_ok=True)
    for name, picture in PICTURES.items():
        print(name, file=sys.stderr, flush=True)
        write_atomic(IMAGES / name, picture(source))
