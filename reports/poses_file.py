"""Tables as .npz, .csv or .parquet: times and poses of a run or an ensemble, written whole or not at all."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.files import write_atomic
from mbs_ref.simulate.many.ensemble import Ensemble
from mbs_ref.trajectory import Trajectory, pose_columns

Columns = Mapping[str, np.ndarray]  # (n_rows,) by heading


def write_poses(trajectory: Trajectory, bodies: list[str], path: Path) -> None:
    """Write times (s), positions (m), orientations (rad or Euler parameters) and velocities."""
    estimate, poses = trajectory.estimate, Poses.of(trajectory)
    over_time = np.zeros(0) if estimate is None else estimate.over_time  # (n_t,) m; none where it was not computed
    arrays = {"bodies": np.array(bodies), "times": trajectory.times, **poses._asdict(), "estimate": over_time}
    columns = {"t": trajectory.times, **pose_columns(bodies, poses)}
    write_atomic(path, FORMATS[path.suffix](arrays, columns))


def write_ensemble(ensemble: Ensemble, path: Path) -> None:
    """Write the inputs, the end and the samples of every run."""
    built, count, design = len(ensemble.statuses), len(ensemble.times), ensemble.design
    status = np.array([str(status) for status in ensemble.statuses])
    values = design.values[:built]  # (n_runs, n_inputs)
    arrays = {
        "bodies": np.array(ensemble.scene.body_names), "inputs": np.array(design.names),
        "laws": np.array([str(law) for law in design.laws.values()]), "values": values, "status": status,
        "reached": ensemble.reached, "times": ensemble.times,  # (n_runs,) s, (n_t,) s
        **ensemble.samples._asdict(),  # (n_runs, n_t, n_bodies, ...); NaN where a run has none
        "errors": ensemble.errors,  # (n_runs, n_t, 2) m and rad, estimated
    }  # fmt: skip
    inputs = {f"vary {name}": np.repeat(own, count) for name, own in zip(design.names, values.T, strict=True)}
    about = {"run": np.repeat(np.arange(built), count), **inputs, "status": np.repeat(status.astype(object), count)}
    rows = Poses(*(part.reshape(built * count, *part.shape[2:]) for part in ensemble.samples))
    columns = about | {"t": np.tile(ensemble.times, built), **pose_columns(ensemble.scene.body_names, rows)}
    write_atomic(path, FORMATS[path.suffix](arrays, columns))


def _npz(arrays: Mapping[str, np.ndarray], _: Columns) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


def csv_table(columns: Mapping[str, Sequence[Any]]) -> str:
    """Return columns as CSV with a heading; None is an empty field."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return buffer.getvalue()


def parquet_table(columns: Mapping[str, Any]) -> bytes:
    """Return columns as a Parquet file; ImportError where pyarrow is not installed."""
    import pyarrow  # pyright: ignore[reportMissingImports]  # an optional extra
    import pyarrow.parquet  # pyright: ignore[reportMissingImports]

    buffer = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(dict(columns)), buffer)
    return buffer.getvalue()


FORMATS: dict[str, Callable[[Mapping[str, np.ndarray], Columns], bytes]] = {
    ".npz": _npz,
    ".csv": lambda _, columns: csv_table({name: column.tolist() for name, column in columns.items()}).encode(),
    ".parquet": lambda _, columns: parquet_table(columns),
}
