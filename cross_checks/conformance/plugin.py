"""The pytest plugin: the fixture `mbs_judge`, and whom the conformance suite examines: --mbs-adapter, --mbs-engine."""

from pathlib import Path
from typing import Any

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


@pytest.fixture
def mbs_judge():
    """Return `cross_checks.judge` as an assertion: the test fails unless the motion agrees with the truth to `error`.

    It is called as mbs_judge(scene, times, poses, error=1e-4), or with what else `cross_checks.judge` takes.
    """
    import cross_checks

    def agrees(*motion: Any, **options: Any) -> Any:
        __tracebackhide__ = True
        result = cross_checks.judge(*motion, **options)
        if result.verdict != "agrees":
            pytest.fail(str(result), pytrace=False)
        return result

    return agrees
