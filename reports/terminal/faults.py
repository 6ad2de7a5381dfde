"""Failures of storage, memory and packages, and defects of our own: each ends a command in one line."""

from __future__ import annotations

import errno
import os
import tempfile
import traceback
from contextlib import suppress
from pathlib import Path

import click

from reports.terminal.console import Defect, Incomplete

FAULTS = (OSError, MemoryError, ImportError)  # that a command cannot answer for
NEXT = {
    errno.ENOSPC: "free space", errno.EDQUOT: "free space", errno.EMFILE: "allow more open files (ulimit -n)",
    **dict.fromkeys(
        (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR),
        "name a place that can be read and written (by an option, MBS_REF_STORE or XDG_CACHE_HOME)",
    ),
}  # fmt: skip


def fault(error: Exception) -> click.ClickException:
    """Return what the command line prints in place of a traceback, and exits with."""
    if not isinstance(error, FAULTS):
        return _defect(error)
    return Incomplete(" ".join(f"{_sentence(error)}, and repeat the command; what was computed is stored".split()))


def _sentence(error: BaseException) -> str:
    match error:
        case OSError(errno=None):
            return str(error)
        case OSError():
            named = "" if error.filename is None else f"{error.filename}: "
            return f"{named}{error.strerror}: {NEXT.get(error.errno or 0, 'restore what is named')}"
        case ImportError():
            return f"{error}: install the module (`mbs-ref doctor` shows what is missing)"
        case _:
            return f"memory is exhausted {error}: request fewer samples or runs at once"


def _defect(error: Exception) -> Defect:
    """Return the line for an error that no input should cause; its traceback is stored."""
    last, file = (
        traceback.extract_tb(error.__traceback__)[-1],
        Path(tempfile.gettempdir(), f"mbs-ref-{os.getpid()}.txt"),
    )
    with suppress(OSError):
        file.write_text("".join(traceback.format_exception(error)))
    where = f"{type(error).__name__} at {last.filename}:{last.lineno}: {error}"
    return Defect(
        f"this is a defect of mbs-ref; please report it with the command and {file}: {' '.join(where.split())}"
    )
