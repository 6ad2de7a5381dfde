"""The command line that makes a record's run again, and the labels of scenes."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import cache
from typing import Any

from cross_checks import engines
from cross_checks.judge.ladder import SAMPLES
from cross_checks.records.record import Record
from mbs_ref import scenes


def command(record: Record, scene: str = "", kept: Sequence[str] = ()) -> str:
    """Return the mbs-ref command that runs what the record holds, of a `scene` that was named so: perhaps by a file.

    `kept` are the initial velocities that it was told to keep.
    """
    words = ["mbs-ref", "simulate", scene or record.scene, "--engine", engines.called(record.engine)]
    parameters = {} if scene.endswith(".toml") else chosen_parameters(record.scene, record.parameters)
    for name, value in parameters.items():
        words += ["-p", f"{name}={value}"]
    for rate in kept:
        words += ["--keep", rate]
    options = {"method": record.method or None, **{key: record.settings.get(key) for key in ("step", "rtol", "atol")}}
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    return shlex.join([*words, "--samples", str(SAMPLES)])


def scene_label(name: str, parameters: dict[str, Any]) -> str:
    """Return a scene's name with its counts and whatever else was chosen, as the command line takes them."""
    chosen = chosen_parameters(name, parameters)
    counts = {key: value for key, value in parameters.items() if type(value) is int}
    return " ".join([name, *(f"{key}={value}" for key, value in (counts | chosen).items())])


def chosen_parameters(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters that differ from the scene's defaults."""
    defaults = _defaults().get(name, {})
    return {key: value for key, value in parameters.items() if defaults.get(key) != value}


@cache
def _defaults() -> dict[str, dict[str, Any]]:
    return {name: scenes.describe(name).parameters for name in scenes.names()}
