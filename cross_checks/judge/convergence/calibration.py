"""How often verdicts were right on synthetic methods of known behaviour: the table of the method page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("calibration.json")


def calibration() -> dict[str, Any]:
    """Return counts of verdicts by the true behaviour, and stated odds of a wrong limit beside what came true.

    `python -m tests.cross_checks.convergence.searched --write` measures them.
    """
    return json.loads(FILE.read_text(encoding="utf-8"))
