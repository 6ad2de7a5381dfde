"""python -m reports.site FOLDER: what mkdocs is to build the documentation from."""

from __future__ import annotations

import sys
from pathlib import Path

from reports.site.write import write_sources

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m reports.site FOLDER")
    write_sources(Path(sys.argv[1]), lambda text: print(text, file=sys.stderr, flush=True))
