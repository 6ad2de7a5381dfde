"""Write a file whole or not at all."""

import os
from pathlib import Path


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
