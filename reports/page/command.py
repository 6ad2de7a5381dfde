"""The exact command that makes a record again."""

from __future__ import annotations

import shlex

from cross_checks.judge.ladder import SAMPLES
from cross_checks.records.record import Record
from reports.page.report_data import chosen_parameters

OPTIONS = {"step": "--step", "rtol": "--rtol", "atol": "--atol", "stabilization": "--stabilization", "t_end": "--t-end"}


def command(record: Record) -> str:
    """Return the `mbs-ref simulate` line that reproduces a record, quoted for a shell."""
    words = ["mbs-ref", "simulate", record.scene]
    for name, value in chosen_parameters(record.scene, record.parameters).items():
        words += ["-p", f"{name}={value}"]
    words += ["--engine", record.engine, "--method", record.method]
    for key, option in OPTIONS.items():
        if record.settings.get(key) is not None:
            words += [option, str(record.settings[key])]
    words += ["--samples", str(SAMPLES)]  # fixed steps divide this grid, and errors are the largest over it
    return shlex.join(words)
