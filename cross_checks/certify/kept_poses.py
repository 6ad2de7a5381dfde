"""World poses of truths that take long to make, kept on disk: what `mbs-ref certify --write` made is read again."""

from __future__ import annotations

import hashlib
import json
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mbs_ref.atomic_file import write_atomic
from mbs_ref.scene import Scene

FOLDER = Path(__file__).parent / "poses"
PHYSICS = ("gravity", "bodies", "joints", "loads", "contacts", "events")  # what a truth depends on


class KeptPoses(NamedTuple):
    """A truth as arrays and words; see cross_checks.truths.Truth."""

    times: np.ndarray  # (n_t,) s
    position: np.ndarray  # (n_t, n_bodies, dimension) m
    angle: np.ndarray  # (n_t, n_bodies) rad
    uncertainty: float  # m
    difference: float  # m
    how: str


def file_of(scene: Scene, folder: Path = FOLDER) -> Path:
    """Return the file that holds these very physics: a changed scene has another name."""
    dumped = scene.model_dump(mode="json")
    digest = hashlib.sha256(json.dumps([dumped[part] for part in PHYSICS], sort_keys=True).encode()).hexdigest()
    return folder / f"{scene.name}-{digest[:12]}.npz"


def find(scene: Scene, times: np.ndarray, folder: Path = FOLDER) -> KeptPoses | None:
    """Return what is kept of a scene at `times` (s), or None."""
    if not any(folder.glob(f"{scene.name}-*.npz")):
        return None
    file = file_of(scene, folder)
    if not file.is_file():
        return None
    with np.load(file) as kept:
        rows = np.flatnonzero(np.isin(kept["times"], times))
        if len(rows) < len(times):
            return None
        times, position, angle = (kept[name][rows] for name in ("times", "position", "angle"))
        uncertainty, difference = (float(kept[name]) for name in ("uncertainty", "difference"))
        return KeptPoses(times, position, angle, uncertainty, difference, str(kept["how"]))


def keep(scene: Scene, poses: KeptPoses, folder: Path = FOLDER) -> Path:
    """Keep the poses; return their file."""
    folder.mkdir(parents=True, exist_ok=True)
    buffer, file = BytesIO(), file_of(scene, folder)
    np.savez_compressed(buffer, allow_pickle=False, **poses._asdict())
    write_atomic(file, buffer.getvalue())
    return file
