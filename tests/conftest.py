"""What every test may rely on."""

import signal


def pytest_configure() -> None:
    """Hear SIGINT as in a terminal: a shell that starts tests in the background leaves it ignored, by children too."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
