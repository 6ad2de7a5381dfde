"""The command line that makes a record's run again."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from cross_checks import engines
from cross_checks.judge.ladder import SAMPLES
from cross_checks.records.record import Record
from mbs_ref import scenes


def command(record: Record, scene: str = "", kept: Sequence[str] = ()) -> str:
    """Return the mbs-ref command that runs what the record holds, of a `scene` that was named so: perhaps by a file.

    `kept` are the initial velocities that it keeps.
    """
    words = ["mbs-ref", "simulate", scene or record.scene, "--engine", engines.called(record.engine)]
    parameters = {} if scene.endswith(".toml") else scenes.chosen(record.scene, record.parameters)
    for name, value in parameters.items():
        words += ["-p", f"{name}={value}"]
    for rate in kept:
        words += ["--keep", rate]
    options = {"method": record.method or None, **{key: record.settings.get(key) for key in ("step", "rtol", "atol")}}
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    return shlex.join([*words, "--samples", str(SAMPLES)])
