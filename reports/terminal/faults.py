"""Failures of storage, memory, packages and numbers: each ends a command in one line with the next step."""

from __future__ import annotations

import errno

from reports.terminal.console import Incomplete

FAULTS = (OSError, MemoryError, ImportError, ArithmeticError)  # that a command cannot answer for
NEXT = {
    errno.ENOSPC: "free space", errno.EDQUOT: "free space", errno.EMFILE: "allow more open files (ulimit -n)",
    **dict.fromkeys(
        (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR),
        "name a place that can be read and written (by an option, MBS_REF_STORE or XDG_CACHE_HOME)",
    ),
}  # fmt: skip


def fault(error: BaseException) -> Incomplete:
    """Return what the command line prints in place of a traceback, and exits with."""
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
        case MemoryError():
            return f"memory is exhausted {error}: request fewer samples or runs at once"
        case _:
            return f"a number leaves the range of double precision ({error}): correct the scene's numbers"
