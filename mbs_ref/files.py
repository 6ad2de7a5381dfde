"""Files: data of a package are read, and results are written whole or not at all."""

import json
import os
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any


def package_data(module: str, *path: str) -> Any:
    """Return what a .toml or .json file holds, by its path from a package or from the folder of a module."""
    text = files(module).joinpath(*path).read_text(encoding="utf-8")
    return tomllib.loads(text) if path[-1].endswith(".toml") else json.loads(text)


def write_atomic(path: str | Path, content: bytes) -> None:
    """Replace the file by `content`; a reader, or a crash, sees the old file or the new one. OSError as usual."""
    target = Path(os.path.realpath(path))
    draft = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        with draft.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)
