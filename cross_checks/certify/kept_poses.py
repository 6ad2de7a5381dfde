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
    """A truth as arrays and words; see cross_checks.truth.Truth."""

    times: np.ndarray  # (n_t,) s
    position: np.ndarray  # (n_t, n_bodies, dimension) m
    orientation: np.ndarray  # (n_t, n_bodies) rad, or (n_t, n_bodies, 4) Euler parameters
    velocity: np.ndarray  # (n_t, n_bodies, dimension) m/s
    angular_velocity: np.ndarray  # (n_t, n_bodies) or (n_t, n_bodies, 3) rad/s
    rate_uncertainty: np.ndarray  # (n_t,) m/s and rad/s
    uncertainty: float  # m
    difference: float  # m
    how: str


def physics_of(scene: Scene) -> str:
    """Return a digest of everything that a motion depends on; the scene's name is no part of it."""
    dumped = scene.model_dump(mode="json")
    return hashlib.sha256(json.dumps([dumped[part] for part in PHYSICS], sort_keys=True).encode()).hexdigest()


def file_of(scene: Scene, folder: Path = FOLDER) -> Path:
    """Return the file that holds these very physics: a changed scene has another name."""
    known = next(folder.glob(f"*-{physics_of(scene)[:12]}.npz"), None)
    return known or folder / f"{scene.name}-{physics_of(scene)[:12]}.npz"


def find(scene: Scene, times: np.ndarray, folder: Path = FOLDER) -> KeptPoses | None:
    """Return what is kept of a scene at `times` (s), or None."""
    file = file_of(scene, folder)
    if not file.is_file():
        return None
    with np.load(file) as kept:
        if "velocity" not in kept:
            return None
        rows = np.flatnonzero(np.isin(kept["times"], times))
        if len(rows) < len(times):
            return None
        arrays = {name: kept[name][rows] for name in KeptPoses._fields[:6]}
        return KeptPoses(**arrays, uncertainty=float(kept["uncertainty"]), difference=float(kept["difference"]),
                         how=str(kept["how"]))  # fmt: skip


def keep(scene: Scene, poses: KeptPoses, folder: Path = FOLDER) -> Path:
    """Keep the poses; return their file."""
    folder.mkdir(parents=True, exist_ok=True)
    buffer, file = BytesIO(), file_of(scene, folder)
    np.savez_compressed(buffer, allow_pickle=False, **poses._asdict())
    write_atomic(file, buffer.getvalue())
    return file
