"""A file or arrays, the map of the columns, and the motion that they describe."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cross_checks.trajectory_files.column_map import ColumnMap, own_map, read_map
from cross_checks.trajectory_files.columns import Columns, FileError, columns_of, read_columns
from cross_checks.trajectory_files.told_motion import Told, told_motion
from mbs_ref.scene import Scene


class Read(NamedTuple):
    """What a file holds, what was stated of it, and the motion."""

    columns: Columns
    stated: ColumnMap
    told: Told


def read_motion(source: Path | Mapping[str, np.ndarray], scene: Scene, map_path: Path | None = None) -> Read:
    """Read a trajectory of a scene from a file or arrays; only columns named as by `mbs-ref simulate -o` need no map.

    Raises FileError.
    """
    stated = None if map_path is None else read_map(map_path)
    if isinstance(source, Path):
        columns = read_columns(source, "," if stated is None else stated.delimiter)
    else:
        columns = columns_of(source)
    stated = stated or own_map(list(columns.values), list(scene.body_names))
    if stated is None:
        raise FileError(
            f"{columns.path}: its columns are not those that mbs-ref writes of {scene.name}; state what they mean by "
            f"--map MAP.toml, which --write-map MAP.toml begins for you"
        )
    return Read(columns, stated, told_motion(scene, columns, stated))
