"""A trajectory on the disk: times and poses as .npz or .csv, whole or not at all."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mbs_ref.atomic_file import write_atomic
from mbs_ref.trajectory import Trajectory


def write_poses(trajectory: Trajectory, bodies: list[str], path: Path) -> None:
    """Write times (s), positions (m), orientations (rad or Euler parameters) and velocities."""
    write_atomic(path, FORMATS[path.suffix](trajectory, bodies))


def _npz(trajectory: Trajectory, bodies: list[str]) -> bytes:
    buffer = io.BytesIO()
    estimate = trajectory.estimate
    np.savez_compressed(
        buffer,
        bodies=np.array(bodies),
        times=trajectory.times,
        position=trajectory.position,
        orientation=trajectory.orientation,
        velocity=trajectory.velocity,
        angular_velocity=trajectory.angular_velocity,
        estimate=np.zeros(0) if estimate is None else estimate.over_time,  # (n_t,) m; none where it was not made
    )
    return buffer.getvalue()


def _csv(trajectory: Trajectory, bodies: list[str]) -> bytes:
    """One row a time; columns such as rod.x, rod.y, rod.angle, rod.vx, rod.vy, rod.rate."""
    count, n = len(trajectory.times), len(bodies)
    blocks = [trajectory.position, trajectory.orientation, trajectory.velocity, trajectory.angular_velocity]
    rows = np.concatenate([block.reshape(count, n, -1) for block in blocks], axis=2)  # (n_t, n_bodies, columns)
    spatial = trajectory.position.shape[2] == 3
    planar_columns = ["x", "y", "angle", "vx", "vy", "rate"]
    spatial_columns = ["x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "wx", "wy", "wz"]
    columns = spatial_columns if spatial else planar_columns
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["t", *(f"{body}.{column}" for body in bodies for column in columns)])
    for t, row in zip(trajectory.times, rows, strict=True):
        writer.writerow([repr(float(t)), *(repr(float(value)) for value in row.ravel())])
    return buffer.getvalue().encode()


FORMATS: dict[str, Callable[[Trajectory, list[str]], bytes]] = {".npz": _npz, ".csv": _csv}
