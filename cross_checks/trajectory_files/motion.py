"""The motion that a file or arrays describe, by the map of their columns."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.column_map import AngularVelocity, Body, ColumnMap, Orientation, own_map, read_map
from cross_checks.trajectory_files.columns import Only, Report, columns_of, read_columns, read_header
from cross_checks.trajectory_files.formats import Columns, FileError
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.messages import suggest
from mbs_ref.trajectory import POSES, Trajectory, pose_shapes

SAME_TIME = 1e-9  # of the duration: samples of two files that are closer are of one time
UNIT = 1e-3  # Euler parameters further from a norm of one than this are something else


class DescribedMotion(NamedTuple):
    """A file's motion, and what the file leaves out."""

    path: Trajectory
    missing: tuple[str, ...]  # sentences


def described_motion(scene: Scene, columns: Columns, stated: ColumnMap) -> DescribedMotion:
    """Return what a file states of a scene's motion.

    Raises FileError: a body or column that does not exist, times that do not increase or leave the scene's duration, a
    convention that does not fit the scene's dimension, Euler parameters or matrices that are no rotation.
    """
    for body in stated.bodies:
        if body not in scene.body_names:
            allowed = f"allowed: {', '.join(scene.body_names)}"
            raise FileError(f"bodies.{body}: the scene has no such body{suggest(body, scene.body_names)}; {allowed}")
    times, d = _times(scene, columns, stated), scene.dimension
    shapes = zip(POSES, pose_shapes(len(scene.bodies), d), strict=True)
    state: dict[str, Any] = {part: np.full((len(times), *shape), np.nan) for part, shape in shapes}
    for name, body in stated.bodies.items():
        k = scene.body_names.index(name)
        for part, values in _Reader(columns, stated, d, name, times).read(body).items():
            state[part][:, k] = values
    return DescribedMotion(Trajectory(times, **state), _missing(scene, columns, stated))


def _missing(scene: Scene, columns: Columns, stated: ColumnMap) -> tuple[str, ...]:
    sentences = []
    if columns.stride > 1:
        rows = f"{len(columns)} of {columns.total} rows of {columns.path.name} are judged: every {columns.stride}th"
        sentences.append(f"{rows}, and of each part of the file the one at which a column bends most")
    for body in scene.bodies:
        own = stated.bodies.get(body.name)
        left_out = list(POSES) if own is None else own.missing
        if isinstance(body, PointMass):  # has neither orientation nor spin
            left_out = [part for part in left_out if part in ("position", "velocity")]
        if left_out:
            what = "anything" if own is None else ", ".join(left_out)
            sentences.append(f"the file does not state {what} of {body.name}")
    return tuple(sentences)


def _times(scene: Scene, columns: Columns, stated: ColumnMap) -> np.ndarray:
    name = stated.time.column
    times = _column(columns, name, "time") * units.factor("time", stated.time.unit)
    slack = 1e-9 * scene.duration
    outside = np.flatnonzero((times < -slack) | (times > scene.duration + slack))
    if len(outside):
        problem = f"{times[outside[0]]:g} s lies outside of the scene's 0 to {scene.duration:g} s; give --t-end"
        raise FileError(f"{columns.place(int(outside[0]), name)}: {problem}")
    return np.clip(times, 0.0, scene.duration)


def _column(columns: Columns, name: str, what: str) -> np.ndarray:
    if name not in columns.values:
        known = list(columns.values)
        allowed = f"it has: {', '.join(known[:20])}{', ...' if len(known) > 20 else ''}"
        raise FileError(f"{what}: {columns.path.name} has no column {name!r}{suggest(name, known)}; {allowed}")
    return columns.values[name]


class _Reader:
    """Reads one body's parts into the scene's axes."""

    def __init__(self, columns: Columns, stated: ColumnMap, dimension: int, body: str, times: np.ndarray) -> None:
        self.columns, self.dimension, self.body, self.planar = columns, dimension, body, dimension == 2
        axes = stated.world.axes[:dimension]
        if len(axes) < dimension:
            raise FileError(f"world.axes = {list(axes)} has {len(axes)} axes; the scene has {dimension}")
        self.turn = np.zeros((dimension, dimension))  # scene = turn @ file
        for row, axis in enumerate(axes):
            self.turn[row, "xyz".index(axis[-1])] = -1.0 if axis[0] == "-" else 1.0
        if np.linalg.det(self.turn) < 0.0:
            raise FileError(f"world.axes = {list(axes)} mirrors the world: those axes are left-handed")
        self.origin = np.array(stated.world.origin[:dimension])
        self.world = stated.world
        self.turning = self._turning(times)

    def read(self, body: Body) -> dict[str, np.ndarray]:
        parts: dict[str, np.ndarray] = {}
        if body.position is not None:
            place = self._numbers(body.position, "position", self.dimension)
            parts["position"] = self.origin + self._in_scene(place * units.factor("length", body.position.unit))
        if body.velocity is not None:
            speed = self._numbers(body.velocity, "velocity", self.dimension)
            seen = self._in_scene(speed * units.factor("velocity", body.velocity.unit))
            parts["velocity"] = seen + self._carried(parts.get("position"))
        if body.orientation is not None:
            parts["orientation"] = self._orientation(body.orientation)
        if body.angular_velocity is not None:
            parts["angular_velocity"] = self._spin(body.angular_velocity, parts.get("orientation"))
        return parts

    def _turning(self, times: np.ndarray) -> Rotation | None:
        """Return how far the file's world has turned at each time; None where it stands still."""
        spin, turned = np.array(self.world.spin), self.world.turned
        if not spin.any() and turned is None:
            return None
        if self.planar:
            raise FileError("world.spin and world.turned are for scenes in space")
        turning = Rotation.from_rotvec(times[:, None] * spin)
        if turned is None:
            return turning
        angle = _column(self.columns, turned.column, "world.turned") * units.factor("angle", turned.unit)
        return turning * Rotation.from_euler(turned.about, angle[:, None])

    def _in_scene(self, vectors: np.ndarray) -> np.ndarray:
        turned = vectors @ self.turn.T
        return turned if self.turning is None else self.turning.apply(turned)

    def _carried(self, position: np.ndarray | None) -> np.ndarray | float:
        """Return the velocity (m/s) of the file's world where the body is."""
        if self.turning is None:
            return 0.0
        place = f"bodies.{self.body}.velocity"
        if self.world.turned is not None:
            raise FileError(
                f"{place}: the angular velocity of a frame whose angle is a column is unknown; remove `velocity`"
            )
        if position is None:
            raise FileError(f"{place} in a world that turns needs the position, which the file does not state")
        return np.cross(self.world.spin, position - self.origin)

    def _numbers(self, part: Any, what: str, count: int) -> np.ndarray:
        place = f"bodies.{self.body}.{what}"
        if len(part.columns) != count:
            raise FileError(f"{place}.columns: {len(part.columns)} are given; expected: {count}")
        return np.column_stack([_column(self.columns, name, place) for name in part.columns])

    def _orientation(self, part: Orientation) -> np.ndarray:
        place = f"bodies.{self.body}.orientation"
        if (part.convention == "angle") != self.planar:
            problem = f"does not fit a scene in {self.dimension} dimensions"
            raise FileError(f"{place}.convention = {part.convention!r} {problem}")
        if part.convention == "angle":
            tilt = np.arctan2(self.turn[1, 0], self.turn[0, 0])
            return self._numbers(part, "orientation", 1)[:, 0] * self._angle(part, place) + tilt
        if part.maps is None:
            raise FileError(f"{place}.maps is missing; allowed: body to world, world to body")
        turned = self._rotation(part, place)
        turned = turned.inv() if part.maps == "world to body" else turned
        turned = Rotation.from_matrix(self.turn) * turned
        return (turned if self.turning is None else self.turning * turned).as_quat(scalar_first=True)

    def _angle(self, part: Orientation, place: str) -> float:
        if part.unit is None:
            raise FileError(f"{place}.unit is missing; allowed: {', '.join(units.allowed('angle'))}")
        return units.factor("angle", part.unit)

    def _rotation(self, part: Orientation, place: str) -> Rotation:
        word, _, order = part.convention.partition(" ")
        if word == "euler":
            angles = self._numbers(part, "orientation", 3) * self._angle(part, place)
            return Rotation.from_euler(order, angles)
        if word == "matrix":
            matrices = self._numbers(part, "orientation", 9).reshape(-1, 3, 3)
            self._check(np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)), part, "A A^T - 1")
            return Rotation.from_matrix(matrices)
        numbers = self._numbers(part, "orientation", 4)
        self._check(np.abs(np.linalg.norm(numbers, axis=1) - 1.0), part, "the norm less one")
        return Rotation.from_quat(numbers, scalar_first=order == "wxyz")

    def _check(self, off: np.ndarray, part: Orientation, what: str) -> None:
        bad = np.flatnonzero(off > UNIT)
        if len(bad):
            place = self.columns.place(int(bad[0]), part.columns[0])
            raise FileError(f"{place}: no rotation: {what} is {off[bad[0]]:.2g}; expected: at most {UNIT:g}")

    def _spin(self, part: AngularVelocity, orientation: np.ndarray | None) -> np.ndarray:
        place, scale = f"bodies.{self.body}.angular_velocity", units.factor("angular velocity", part.unit)
        if self.planar:
            return self._numbers(part, "angular_velocity", 1)[:, 0] * scale
        spin = self._numbers(part, "angular_velocity", 3) * scale
        if part.axes == "world":
            return self._in_scene(spin)
        if part.axes is None:
            raise FileError(f"{place}.axes is missing; allowed: world, body")
        if orientation is None:
            raise FileError(f"{place}.axes = 'body' needs the orientation, which the file does not state")
        return Rotation.from_quat(orientation, scalar_first=True).apply(spin)


class Read(NamedTuple):
    """What a file holds, what was stated of it, and the motion."""

    columns: Columns
    stated: ColumnMap
    motion: DescribedMotion


def read_motion(
    source: Path | Mapping[str, np.ndarray], scene: Scene, map_path: Path | None = None, at: np.ndarray | None = None,
    report: Report | None = None,
) -> Read:  # fmt: skip
    """Read a trajectory of a scene from a file or arrays; only columns named as by `mbs-ref simulate -o` need no map.

    With `at` (s), the rows at those times alone. Raises FileError, for what header and map decide before rows are read.
    """
    stated = None if map_path is None else read_map(map_path)
    clock, unit = ("t", 1.0) if stated is None else (stated.time.column, units.factor("time", stated.time.unit))
    only: Only | None = None if at is None else (at / unit, SAME_TIME * scene.duration / unit)
    if not isinstance(source, Path):
        return _described(scene, columns_of(source, clock, only), stated)
    delimiter = "" if stated is None else stated.delimiter
    _described(scene, read_header(source, delimiter), stated)
    return _described(scene, read_columns(source, delimiter, clock, only, report), stated)


def _described(scene: Scene, columns: Columns, stated: ColumnMap | None) -> Read:
    stated = stated or own_map(list(columns.values), list(scene.body_names))
    if stated is None:
        raise FileError(
            f"{columns.path}: its columns are not those that mbs-ref writes of {scene.name}; state what they mean by "
            f"--map MAP.toml, which --write-map MAP.toml begins for you"
        )
    return Read(columns, stated, described_motion(scene, columns, stated))


def in_common(scene: Scene, files: Sequence[tuple[Path, Path | None]], report: Report) -> list[DescribedMotion]:
    """Read two files with their maps; of rows that are left out, the longer file's are at the times of the shorter."""
    both = [read_motion(path, scene, own, report=report) for path, own in files]
    if any(one.columns.stride > 1 for one in both):
        longer = int(both[1].columns.total > both[0].columns.total)
        path, own = files[longer]
        both[longer] = read_motion(path, scene, own, both[1 - longer].motion.path.times, report)
    return [one.motion for one in both]
