"""What every test may rely on."""

import gc
import os
import shutil
import signal
import tempfile

import pytest
from hypothesis import settings

# The same examples in every run; `make nightly` draws new ones.
settings.register_profile("repeated", derandomize=True)
settings.load_profile("repeated")
# Of BLAS, before NumPy is loaded: workers share the cores, and threads that wait for small matrices occupy them.
os.environ["OMP_NUM_THREADS"] = "1"


def pytest_configure(config: pytest.Config) -> None:
    """Give all workers one store of runs, and hear SIGINT as in a terminal.

    The store is thrown away unless MBS_REF_TEST_STORE names its file. A shell that starts tests in the background
    leaves SIGINT ignored, by children too.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.set_threshold(20_000, 50, 1000)  # Numba and the tests leave millions of objects that never become garbage
    if "PYTEST_XDIST_WORKER" in os.environ:
        return
    kept = os.environ.pop("MBS_REF_TEST_STORE", "")  # not for tests that this one starts
    if kept:
        os.environ["MBS_REF_STORE"] = os.path.abspath(kept)
        return
    folder = tempfile.mkdtemp(prefix="mbs-ref-")
    os.environ["MBS_REF_STORE"] = os.path.join(folder, "runs.sqlite")
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))


def pytest_collection_finish() -> None:
    """Spare the collected tests in searches for garbage."""
    gc.freeze()
