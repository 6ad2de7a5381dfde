"""The machine and the packages of the report."""

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from cross_checks import engines
from cross_checks.records.record import processor

PACKAGES = ("mbs-ref", "numpy", "scipy", "numba", "pydantic", "plotly")


def environment() -> dict[str, str]:
    """Return the facts a reader needs to judge or repeat the figures."""
    return {
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"), "commit": commit(), "processor": processor(),
        "processors": str(os.cpu_count()), "system": platform.platform(), "python": platform.python_version(),
        **{name: package_version(name) for name in PACKAGES},
        **{f"engine {name}": version for name, version in engine_versions()},
    }  # fmt: skip


def commit() -> str:
    """Return the revision of the source tree, or that there is none."""
    wanted = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty"]
    try:
        result = subprocess.run(wanted, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "unknown: no git here"
    return result.stdout.strip() or "unknown: not a git checkout"


def package_version(package: str) -> str:
    """Return the version of an installed package, or that there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed as a package"


def engine_versions() -> tuple[tuple[str, str], ...]:
    """Return every engine with its version, or why it is missing."""
    return tuple((name, _engine(name)) for name in engines.names())


def _engine(name: str) -> str:
    try:
        return engines.get(name).version()
    except engines.EngineMissing as error:
        return f"missing: {error}"
