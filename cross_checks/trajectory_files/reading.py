"""A file, the map of its columns, and the motion that they tell."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from cross_checks.trajectory_files.column_map import ColumnMap, own_map, read_map
from cross_checks.trajectory_files.columns import Columns, FileError, read_columns
from cross_checks.trajectory_files.told_motion import Told, told_motion
from mbs_ref.scene import Scene


class Read(NamedTuple):
    """What a file holds, what was stated of it, and the motion."""

    columns: Columns
    stated: ColumnMap
    told: Told


def read_motion(path: Path, scene: Scene, map_path: Path | None = None) -> Read:
    """Read a trajectory of a scene. Only the files of `mbs-ref simulate -o` need no map. Raises FileError."""
    stated = None if map_path is None else read_map(map_path)
    columns = read_columns(path, "," if stated is None else stated.delimiter)
    stated = stated or own_map(list(columns.values), list(scene.body_names))
    if stated is None:
        raise FileError(
            f"{path}: its columns are not those that mbs-ref writes of {scene.name}; state what they mean by --map "
            f"MAP.toml, which --write-map MAP.toml begins for you"
        )
    return Read(columns, stated, told_motion(scene, columns, stated))
