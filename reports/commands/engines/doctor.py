"""mbs-ref doctor: is everything in place, and does a run come out right?"""

import math
import os
import platform
from typing import Any

import click

from cross_checks.isolation.environments import home_of
from mbs_ref.kernels.jit import cache_folder
from reports import inputs
from reports.console import Failed, answer, number, show_table
from reports.facts.environment import engine_versions, package_version

PACKAGES = ("mbs-ref", "numpy", "scipy", "numba", "llvmlite", "pydantic")
LARGEST_ERROR = 1e-6  # m, of a pendulum at rtol 1e-9 against its exact motion: two digits of room


@click.command(name="doctor", epilog="Example: mbs-ref doctor")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """Show versions and engines, and simulate a pendulum. The compiler's cache is shown, too."""
    cache = cache_folder()
    result: dict[str, Any] = {
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors",
        "packages": {name: package_version(name) for name in PACKAGES},
        "engines": {name: _with_home(name, version) for name, version in engine_versions()},
        "numba_cache": {"folder": str(cache), "writable": os.access(cache, os.W_OK)},
        "sanity": _sanity(),
    }
    answer(result, None, as_json, _show)
    if not result["sanity"]["ok"]:
        raise Failed(f"the pendulum came out wrong: {result['sanity']['message']}")


def _with_home(name: str, version: str) -> str:
    home = home_of(name)
    return f"{version}, in its environment {home}" if home and not version.startswith("missing") else version


def _sanity() -> dict[str, Any]:
    from cross_checks.judge import one_run as compare

    record = compare.evaluate(inputs.scene("pendulum"), "mbs_ref", inputs.settings(rtol=1e-9, t_end=2.0))
    error = record.error.metres if record.error else math.inf
    return {"ok": record.status == "success" and error < LARGEST_ERROR, "error": error, "message": record.message}


def _show(result: dict[str, Any]) -> None:
    cache, sanity = result["numba_cache"], result["sanity"]
    trouble = "" if cache["writable"] else " (not writable: every start compiles anew)"
    rows = [
        ("Python", f"{result['python']}, {result['machine']}"), *result["packages"].items(), *result["engines"].items(),
        ("compiled kernels", f"{cache['folder']}{trouble}"),
        ("pendulum", f"{'right' if sanity['ok'] else 'WRONG'}, error {number(sanity['error'])} m"),
    ]  # fmt: skip
    show_table("", ("", ""), rows)
