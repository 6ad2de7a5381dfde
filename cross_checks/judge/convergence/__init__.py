"""One statistical model of convergence: every verdict, observed order and choice of a next setting queries it."""

from functools import cache
from pathlib import Path
from typing import Any

from mbs_ref.files import package_data

FILE = Path(__file__).with_name("calibration.json")


@cache
def calibration() -> dict[str, Any]:
    """Return counts of verdicts by the true behaviour, and stated odds of a wrong limit with the share that came true.

    `python -m tests.cross_checks.convergence.searched --write` measures them.
    """
    return package_data(__name__, FILE.name)
