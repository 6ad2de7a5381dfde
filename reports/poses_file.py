"""Times and poses on the disk, whole or not at all: of a run as .npz or .csv, of an ensemble as .parquet, too."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mbs_ref.atomic_file import write_atomic
from mbs_ref.simulate.many.ensemble import Ensemble
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
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["t", *_columns(bodies, trajectory.position.shape[2])])
    for t, row in zip(trajectory.times, rows, strict=True):
        writer.writerow([repr(float(t)), *(repr(float(value)) for value in row.ravel())])
    return buffer.getvalue().encode()


def _columns(bodies: list[str], dimension: int) -> list[str]:
    planar = ["x", "y", "angle", "vx", "vy", "rate"]
    spatial = ["x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "wx", "wy", "wz"]
    return [f"{body}.{column}" for body in bodies for column in (planar if dimension == 2 else spatial)]


FORMATS: dict[str, Callable[[Trajectory, list[str]], bytes]] = {".npz": _npz, ".csv": _csv}


def write_ensemble(ensemble: Ensemble, path: Path) -> None:
    """Write the inputs, the end and the samples of every run."""
    write_atomic(path, ENSEMBLE_FORMATS[path.suffix](ensemble))


def _ensemble_npz(ensemble: Ensemble) -> bytes:
    buffer, made = io.BytesIO(), len(ensemble.statuses)
    np.savez_compressed(
        buffer,
        bodies=np.array(ensemble.scene.body_names),
        inputs=np.array(ensemble.design.names),
        laws=np.array([str(law) for law in ensemble.design.laws.values()]),
        values=ensemble.design.values[:made],  # (n_runs, n_inputs)
        status=np.array([str(status) for status in ensemble.statuses]),
        reached=ensemble.reached,  # (n_runs,) s
        times=ensemble.times,
        **ensemble.samples._asdict(),  # (n_runs, n_t, n_bodies, ...); NaN where a run has none
        errors=ensemble.errors,  # (n_runs, n_t, 2) m and rad, estimated
    )
    return buffer.getvalue()


def _ensemble_columns(ensemble: Ensemble) -> dict[str, np.ndarray]:
    """Return a column an input, and a coordinate: one row a run and output time."""
    made, count = len(ensemble.statuses), len(ensemble.times)
    inputs = {name: np.repeat(column[:made], count) for name, column in
              zip(ensemble.design.names, ensemble.design.values.T, strict=True)}  # fmt: skip
    blocks = [part.reshape(*part.shape[:3], -1) for part in ensemble.samples]
    rows = np.concatenate(blocks, axis=3).reshape(made * count, -1)
    names = _columns(ensemble.scene.body_names, ensemble.scene.dimension)
    return {
        "run": np.repeat(np.arange(made), count), **{f"vary {name}": column for name, column in inputs.items()},
        "status": np.repeat(np.array([str(status) for status in ensemble.statuses], dtype=object), count),
        "t": np.tile(ensemble.times, made), **dict(zip(names, rows.T, strict=True)),
    }  # fmt: skip


def _ensemble_csv(ensemble: Ensemble) -> bytes:
    columns, buffer = _ensemble_columns(ensemble), io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return buffer.getvalue().encode()


def _ensemble_parquet(ensemble: Ensemble) -> bytes:
    """ImportError where pyarrow is not installed."""
    import pyarrow  # pyright: ignore[reportMissingImports]  # an optional extra
    import pyarrow.parquet  # pyright: ignore[reportMissingImports]

    buffer = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(_ensemble_columns(ensemble)), buffer)
    return buffer.getvalue()


ENSEMBLE_FORMATS: dict[str, Callable[[Ensemble], bytes]] = {
    ".npz": _ensemble_npz, ".csv": _ensemble_csv, ".parquet": _ensemble_parquet,
}  # fmt: skip
