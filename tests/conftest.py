"""What every test may rely on."""

import os
import signal
import tempfile


def pytest_configure() -> None:
    """Hear SIGINT as in a terminal: a shell that starts tests in the background leaves it ignored, by children too."""
    os.environ["MBS_REF_STORE"] = os.path.join(tempfile.mkdtemp(prefix="mbs-ref-"), "runs.sqlite")
    signal.signal(signal.SIGINT, signal.default_int_handler)
