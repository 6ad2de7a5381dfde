"""Chromium without a window: it draws a page as a picture, prints it, or returns it with its plots drawn."""

import shutil
import subprocess
import tempfile
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
LOADING_MS = 20_000  # ms of a page's own time until it is drawn
PATIENCE = 600.0  # s


def browser() -> str | None:
    """Return the path of an installed browser, if there is one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def drawn(address: str, option: str, *options: str) -> bytes:
    """Return the file that a browser's `option`, such as --screenshot, makes of a page.

    FileNotFoundError where no browser is installed.
    """
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "drawn.png"  # a screenshot has to end so, a print may
        loaded(address, *options, f"{option}={target}")
        return target.read_bytes()


def loaded(address: str, *options: str) -> bytes:
    """Return what a browser prints once it has drawn a page; FileNotFoundError where no browser is installed."""
    program = browser()
    if program is None:
        raise FileNotFoundError(f"no browser is installed; this needs one of {', '.join(BROWSERS)}")
    with tempfile.TemporaryDirectory() as folder:
        fixed = ("--headless", "--no-sandbox", "--hide-scrollbars", f"--user-data-dir={folder}/profile")
        shown = (*fixed, f"--virtual-time-budget={LOADING_MS}", *options, address)
        return subprocess.run([program, *shown], check=True, capture_output=True, timeout=PATIENCE).stdout
