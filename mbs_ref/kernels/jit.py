"""One compiler decorator, with a disk cache that can never serve stale code.

Numba's cache watches only the file of the compiled function, not the files it calls. The cache is
therefore kept in a folder named after a digest of every source file that can be compiled.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numba

_PACKAGE = Path(__file__).parent.parent


def source_digest() -> str:
    """Return a digest of all kernel and integrator sources and of Numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for folder in ("kernels", "integrators"):
        for path in sorted((_PACKAGE / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Return where compiled code is kept: under MBS_REF_CACHE, XDG_CACHE_HOME or ~/.cache."""
    root = os.environ.get("MBS_REF_CACHE") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "mbs-ref" / source_digest()


if "NUMBA_CACHE_DIR" not in os.environ:
    numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]

# Contraction (fused multiply-add) alone is allowed: it keeps NaN, infinities and the order of sums.
# Nobody calls these functions from C, and a wrapper for that would be a tenth of the compile time.
_OPTIONS: Any = {"error_model": "numpy", "fastmath": {"contract"}, "no_cfunc_wrapper": True}
jit = numba.njit(cache=True, **_OPTIONS)
# For the parts of a loop: called, each would pass a dozen arrays at every step, and count their references.
inlined = numba.njit(inline="always", **_OPTIONS)
