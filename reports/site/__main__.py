"""python -m reports.site FOLDER: what mkdocs is to build the documentation from."""

import re
import shutil
import sys
from collections.abc import Callable, Collection
from pathlib import Path

from cross_checks.judge.capabilities import capabilities, tables
from cross_checks.truths.certificate import every
from mbs_ref import scenes
from reports.query import open_runs
from reports.site.gallery import gallery, rendered

ROOT = Path(__file__).parents[2]
PATIENCE = 2.0  # s that a run of the gallery's plots may take; they have a store of their own
BESIDE = ("CHANGELOG.md", "CONTRIBUTING.md")  # pages that stand beside docs/


def write_sources(target: Path, say: Callable[[str], None], only: Collection[str] | None = None) -> None:
    """Write everything to a folder that is emptied first; `only` names the scenes of the gallery, else all.

    FileNotFoundError where the tree has no docs, as an installed package has none.
    """
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(ROOT / "docs", target)
    for name in BESIDE:
        shutil.copy(ROOT / name, target / name)
    for page in target.glob("*.md"):  # in the tree these pages stand one folder higher
        text = page.read_text(encoding="utf-8")
        page.write_text(re.sub(rf"\]\(\.\./({'|'.join(map(re.escape, BESIDE))})", r"](\1", text), encoding="utf-8")
    say("what engines can")
    able = capabilities()
    (target / "capabilities.md").write_text(rendered("capabilities", tables=tables(able)), encoding="utf-8")
    (target / "truths.md").write_text(rendered("truths", certificates=every()), encoding="utf-8")
    pictures = target / "gallery"
    pictures.mkdir()
    shown = scenes.names() if only is None else only
    with open_runs([], str(target.with_suffix(".sqlite")), PATIENCE) as runs:
        (target / "gallery.md").write_text(gallery(runs, shown, able, pictures, say), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m reports.site FOLDER")
    write_sources(Path(sys.argv[1]), lambda text: print(text, file=sys.stderr, flush=True))
