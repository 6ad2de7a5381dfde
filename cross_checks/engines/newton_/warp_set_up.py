"""Warp as Newton's kernels are to be compiled here; Newton's modules take that over when they are imported."""

from importlib.metadata import version

VERSION = version("newton")  # its absence means engine-missing, and is found before that of Warp

import warp  # noqa: E402

from mbs_ref.kernels.jit import cache_folder  # noqa: E402

warp.config.log_level = warp.LOG_ERROR  # else it writes to stdout
warp.config.kernel_cache_dir = str(cache_folder() / "warp")
warp.config.enable_backward = False  # derivatives of kernels, unasked for: without them compiling takes a tenth
