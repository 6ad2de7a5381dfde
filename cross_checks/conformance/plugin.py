"""The pytest plugin: --mbs-adapter FILE or --mbs-engine NAME chooses whom the conformance suite examines."""

from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("mbs-ref", "conformance of engines of multibody dynamics")
    group.addoption("--mbs-engine", metavar="NAME", help="an engine mbs-ref knows, by entry point or as its own")
    group.addoption("--mbs-adapter", metavar="FILE", help="an adapter file: <engine>_.py with a class and ENGINE")


def pytest_configure(config: pytest.Config) -> None:
    """Make the adapter file known to this process and its children."""
    file = config.getoption("--mbs-adapter")
    if file is None:
        return
    from cross_checks.conformance.loading import NoEngine, announce

    try:
        announce(Path(file))
    except NoEngine as error:
        raise pytest.UsageError(f"--mbs-adapter {error}") from None


@pytest.fixture(scope="session")
def engine_name(pytestconfig: pytest.Config) -> str:
    """Return the name of the engine under examination."""
    file, name = pytestconfig.getoption("--mbs-adapter"), pytestconfig.getoption("--mbs-engine")
    if file is None and name is None:
        pytest.skip("choose an engine with --mbs-adapter FILE or --mbs-engine NAME")
    return name or Path(str(file)).stem.removesuffix("_")


@pytest.fixture(scope="session")
def engine(engine_name: str):
    """Return the engine under examination."""
    from cross_checks import engines

    return engines.get(engine_name)
