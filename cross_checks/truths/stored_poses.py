"""Truths stored as arrays: costly ones by `mbs-ref certify --write`, proven ones by `mbs-ref proofs --write`."""

import hashlib
import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.truths.truth import Truth
from mbs_ref import Scene
from mbs_ref.files import write_atomic

FOLDER = Path(__file__).parent / "data" / "poses"
PHYSICS = ("gravity", "bodies", "joints", "loads", "contacts", "events")  # what a truth depends on
ARRAYS = ("position", "orientation", "velocity", "angular_velocity", "rate_uncertainty")  # fields of Truth, by time
VALUES = ("uncertainty", "difference", "how", "kind")  # its other stored fields


def physics_of(scene: Scene) -> str:
    """Return a digest of everything that a motion depends on; neither the scene's name nor what is not given is."""
    dumped = scene.model_dump(mode="json", exclude_none=True)
    return hashlib.sha256(json.dumps([dumped[part] for part in PHYSICS], sort_keys=True).encode()).hexdigest()


def file_of(scene: Scene, folder: Path = FOLDER, suffix: str = ".npz") -> Path:
    """Return the file for these very physics: a changed scene has another name."""
    known = next(folder.glob(f"*-{physics_of(scene)[:12]}{suffix}"), None)
    return known or folder / f"{scene.name}-{physics_of(scene)[:12]}{suffix}"


def load(scene: Scene, times: np.ndarray, folder: Path = FOLDER) -> Truth | None:
    """Return the stored truth of a scene at `times` (s), or None where a time is not stored."""
    file = file_of(scene, folder)
    if not file.is_file():
        return None
    with np.load(file) as stored:
        rows = np.flatnonzero(np.isin(stored["times"], times))
        if "velocity" not in stored or len(rows) < len(times):
            return None
        arrays = {name: stored[name][rows] for name in ARRAYS}
        values: dict[str, Any] = {"kind": "converged"} | {
            name: stored[name].item() for name in VALUES if name in stored
        }
        return Truth(**arrays, **values, is_costly=values["kind"] != "proven")


def save(scene: Scene, times: np.ndarray, truth: Truth, folder: Path = FOLDER) -> Path:
    """Store a converged or proven truth with its rates; return its file."""
    folder.mkdir(parents=True, exist_ok=True)
    buffer, file = BytesIO(), file_of(scene, folder)
    values = {name: value for name in ARRAYS + VALUES if (value := getattr(truth, name)) is not None}
    np.savez_compressed(buffer, allow_pickle=False, times=times, **values)
    write_atomic(file, buffer.getvalue())
    return file
