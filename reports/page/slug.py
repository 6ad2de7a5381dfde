"""Names of the report's files, and the command line that repeats a record's run."""

import hashlib
import re
import shlex
from collections.abc import Sequence
from inspect import signature
from pathlib import Path
from typing import Any

from cross_checks import engines
from cross_checks.judge.ladder import SAMPLES
from cross_checks.records.record import Record
from mbs_ref import scenes
from mbs_ref.scene.toml import read_builder

LONGEST = 80


def slug(text: str) -> str:
    """Return a file name without markup; two texts that differ in what was dropped differ by a digest."""
    plain = re.sub(r"[^\w.+=-]+", "-", text).strip("-")[:LONGEST]
    same = plain.replace("-", " ") == text
    return plain if same else f"{plain}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def scene_file(label: str) -> str:
    return f"scene-{slug(label)}.html"


def engine_file(name: str) -> str:
    return f"engine-{slug(name)}.html"


def _of_file(file: str, record: Record) -> dict[str, Any]:
    """Return the parameters of a record that a scene file has other defaults for, or none.

    A file that is absent is one that a report writes of the built scene: it has no parameters.
    """
    if not Path(file).is_file():
        return {}
    defaults = dict.fromkeys(scenes.OF_EVERY_SCENE)
    defaults |= {key: one.default for key, one in signature(read_builder(file)).parameters.items()}
    return {key: value for key, value in record.parameters.items() if defaults.get(key, value) != value}


def command(record: Record, scene: str = "", fixed: Sequence[str] = ()) -> str:
    """Return the mbs-ref command that runs what the record holds, of a `scene` that was named so: perhaps by a file.

    `fixed` are the initial velocities that it fixes (--keep).
    """
    words = ["mbs-ref", "simulate", scene or record.scene, "--engine", engines.called(record.engine)]
    parameters = _of_file(scene, record) if scene.endswith(".toml") else scenes.chosen(record.scene, record.parameters)
    for name, value in parameters.items():
        words += ["-p", f"{name}={value}"]
    for rate in fixed:
        words += ["--keep", rate]
    options = {"method": record.method or None, **{key: record.settings.get(key) for key in ("step", "rtol", "atol")}}
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    return shlex.join([*words, "--samples", str(SAMPLES)])
