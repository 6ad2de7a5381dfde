"""mbs-ref conformance: the whole validation of somebody's solver, from its adapter file."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import click

from reports.exit_codes import Failed, NothingSelected

SUITE = "cross_checks.conformance.test_conformance"
PLUGIN = "cross_checks.conformance.plugin"


@click.command(name="conformance")
@click.argument("engine", metavar="ADAPTER.py|ENGINE")
def command(engine: str) -> None:
    """Examine a solver: refusals, order, compliance, agreement with truths, and how it fails.

    ADAPTER.py holds a subclass of cross_checks.engine.Engine and the line ENGINE = <that class>.
    """
    try:
        import pytest
    except ModuleNotFoundError as error:
        if error.name != "pytest":
            raise
        raise Failed("the package pytest is not installed (pip install mbs-ref[conformance])") from error

    suite = importlib.util.find_spec(SUITE)
    assert suite is not None
    assert suite.origin is not None
    chosen = ["--mbs-adapter" if engine.endswith(".py") else "--mbs-engine", engine]
    # as a plugin only once: an installed mbs-ref has registered it by its entry point
    early = [] if PLUGIN in sys.modules or _is_installed() else ["-p", PLUGIN]
    folder = str(Path(suite.origin).parent)
    quiet = ["-q", "-rs", "-c", "/dev/null", "-p", "no:cacheprovider", "--rootdir", folder]
    code = pytest.main([*early, *quiet, suite.origin, *chosen])
    if code == pytest.ExitCode.USAGE_ERROR:
        raise click.UsageError(f"{engine} cannot be examined")
    if code == pytest.ExitCode.NO_TESTS_COLLECTED:
        raise NothingSelected("no test was collected")
    if code != pytest.ExitCode.OK:
        raise Failed(f"{engine} does not conform")


def _is_installed() -> bool:
    """Look at every distribution, as pytest does: an older one on the path must not hide the one installed."""
    from importlib.metadata import distributions

    entries = (entry for found in distributions() for entry in found.entry_points)
    return any(entry.group == "pytest11" and entry.value == PLUGIN for entry in entries)
