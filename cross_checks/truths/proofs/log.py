"""Logs of proofs in files: compressed JSON."""

import gzip
import json
from pathlib import Path
from typing import Any

from cross_checks.truths.proofs.checker.formulas import Refused
from mbs_ref.atomic_file import write_atomic


def write_log(log: dict[str, Any], file: Path) -> int:
    """Write a log; return its bytes."""
    data = gzip.compress(json.dumps(log, separators=(",", ":")).encode(), mtime=0)
    write_atomic(file, data)
    return len(data)


def read_log(file: Path) -> dict[str, Any]:
    """Return the log in a file. Refused where it holds none."""
    try:
        log = json.loads(gzip.decompress(file.read_bytes()))
    except (OSError, EOFError, ValueError) as error:
        raise Refused(f"{file} holds no log: {error}") from error
    if not isinstance(log, dict):
        raise Refused(f"{file} holds no log")
    return log
