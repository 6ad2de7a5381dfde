"""Other conventions of columns and clocks, and other frames: turned, shifted or turning axes, another point."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.mistakes.case import Case, Hypothesis, vector
from cross_checks.trajectory_files.motion import described_motion
from mbs_ref import Trajectory
from mbs_ref.scene.euler_parameters import product, rotation_matrices
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import POSES

SWAPPED = {
    "quaternion wxyz": "quaternion xyzw", "quaternion xyzw": "quaternion wxyz",
    "body to world": "world to body", "world to body": "body to world", "body": "world", "world": "body",
}  # fmt: skip


def conventions(case: Case) -> Iterator[Hypothesis]:
    """Yield each other reading of one part's columns, of all bodies at once."""
    for part in POSES:
        stated = next((getattr(b, part) for b in case.stated.bodies.values() if getattr(b, part) is not None), None)
        for word, other in _other_words(part, stated):
            said = f"the {part.replace('_', ' ')} columns look like {other}; {getattr(stated, word)} is stated"
            yield Hypothesis(partial(_read, part, {word: other}), lambda x, said=said: said)


def _read(part: str, change: dict[str, Any], case: Case, x: np.ndarray) -> Case | None:
    bodies = dict(case.stated.bodies)
    for name, body in bodies.items():
        if (columns := getattr(body, part)) is not None:
            bodies[name] = body.model_copy(update={part: columns.model_copy(update=change)})
    stated = case.stated.model_copy(update={"bodies": bodies})
    try:
        return replace(case, stated=stated, path=described_motion(case.scene, case.columns, stated).path)
    except (FileError, ValueError):
        return None


def _other_words(part: str, stated: Any) -> Iterator[tuple[str, str]]:
    """Yield a field of the statement and another value of it."""
    if stated is None:
        return
    kind = {"position": "length", "orientation": "angle"}.get(part, part.replace("_", " "))
    if stated.unit is not None:
        yield from (("unit", unit) for unit in units.allowed(kind) if unit != stated.unit)
    for word in ("convention", "maps", "axes"):
        value = getattr(stated, word, None)
        if value in SWAPPED:
            yield word, SWAPPED[value]
    if getattr(stated, "convention", "").startswith("euler"):
        order = stated.convention.removeprefix("euler ")
        yield from (("convention", f"euler {other}") for other in (order.swapcase(), order[::-1]))


def signs(case: Case) -> Iterator[Hypothesis]:
    """Yield a world that is mirrored along an axis, and each component with the other sign."""
    groups = {"the file's world is mirrored": POSES, "positions and velocities are mirrored": ("position", "velocity")}
    groups |= {f"the {part.replace('_', ' ')} has the other sign": (part,) for part in POSES}
    for k, axis in enumerate("xyz"[: case.scene.dimension]):
        for words, parts in groups.items():
            yield Hypothesis(partial(_mirrored, parts, k), lambda x, said=f"{words} along {axis}": said)
    if case.scene.planar:
        said = "orientation and angular velocity count the other way round"
        yield Hypothesis(partial(_mirrored, ("orientation", "angular_velocity"), 0), lambda x: said)


def _mirrored(parts: tuple[str, ...], axis: int, case: Case, x: np.ndarray) -> Case | None:
    """Mirror vectors; turns are axial: along the axis they stay, across it they turn round."""
    mirror = np.ones(case.scene.dimension)
    mirror[axis] = -1.0
    turned = {"position": mirror, "velocity": mirror, "orientation": -1.0, "angular_velocity": -1.0}
    if not case.scene.planar:
        axial = -mirror if len(parts) > 1 else mirror
        turned |= {"orientation": np.append(1.0, axial), "angular_velocity": axial}
    changed = {part: getattr(case.path, part) * turned[part] for part in parts}
    return replace(case, path=replace(case.path, **changed))


def clocks(case: Case) -> Iterator[Hypothesis]:
    """Yield samples, or rates alone, of another time than is stated."""
    slight = 1e-9 * case.scene.duration
    for field, what in (("late", "samples"), ("rates_late", "velocities, by half a step perhaps,")):

        def say(x: np.ndarray, what: str = what) -> str:
            return f"{what} are {'late' if x[0] > 0.0 else 'early'} by {abs(x[0]):.4g} s"

        def change(case: Case, x: np.ndarray, field: str = field) -> Case | None:
            return case.rerun(**{field: getattr(case, field) + float(x[0])})

        yield Hypothesis(change, say, ((0.0,),), True, lambda x: not slight < abs(x[0]) < 0.5 * case.scene.duration)


NONE = 1e-9  # rad, or of the scene's length: a smaller turn or offset is none


def frames(case: Case) -> Iterator[Hypothesis]:
    """Yield frames and points other than those that are stated, whose place is fitted."""
    d, bodies = case.scene.dimension, len(case.scene.bodies)
    turns = 1 if case.scene.planar else 3  # numbers of a rotation vector
    units = np.append(np.ones(turns), np.full(d, scales_of(case.scene).length))
    quarters = (0.0, 0.5 * np.pi, np.pi)
    world = tuple(tuple(q * np.eye(turns + d)[k]) for k in range(turns) for q in quarters[(k > 0) :])
    yield Hypothesis(_turned_world, lambda x: _world(x, units), world, True, lambda x: _small(x / units))
    if not case.scene.planar:
        still = ((0.0, 0.0, 0.0),)
        yield Hypothesis(_turning_world, _turning, still, True, lambda x: _small(x * case.scene.duration))
    if not case.comparable_turns:
        return
    names, length = case.scene.body_names, scales_of(case.scene).length
    yield Hypothesis(_turned_bodies, lambda x: _axes(names, x), ((0.0,) * turns * bodies,), True, _small)
    for rates in (True, False):  # velocities may be of the centre of mass all the same
        yield Hypothesis(
            lambda case, x, rates=rates: _other_points(case, x, rates), lambda x: _points(names, x, length),
            ((0.0,) * d * bodies,), True, lambda x: _small(x / length),
        )  # fmt: skip


def _small(x: np.ndarray) -> bool:
    return bool(np.max(np.abs(x)) <= NONE)


def _rotation(turn: np.ndarray) -> Rotation:
    """Return the rotations of rotation vectors (..., 3), or of angles (..., 1) about the plane's normal."""
    return Rotation.from_rotvec(turn if turn.shape[-1] == 3 else turn * np.array([0.0, 0.0, 1.0]))


def _turned(path: Trajectory, turn: Rotation) -> Trajectory:
    """Return a motion in axes that are turned back, by one rotation or by one for each sample."""
    d = path.position.shape[2]
    matrices = turn.as_matrix()[..., None, :d, :d]
    position, velocity = ((matrices @ x[..., None])[..., 0] for x in (path.position, path.velocity))
    if d == 2:
        return replace(path, position=position, velocity=velocity, orientation=path.orientation + turn.as_rotvec()[2])
    spin = (matrices @ path.angular_velocity[..., None])[..., 0]
    orientation = product(turn.as_quat(scalar_first=True)[..., None, :], path.orientation)
    return replace(path, position=position, velocity=velocity, orientation=orientation, angular_velocity=spin)


def _turned_world(case: Case, x: np.ndarray) -> Case:
    d = case.scene.dimension
    path = _turned(case.path, _rotation(x[:-d]).inv())
    return replace(case, path=replace(path, position=path.position - x[-d:]))


def _world(x: np.ndarray, units: np.ndarray) -> str:
    d = 2 if len(x) == 3 else 3
    turn, words = _rotation(x[:-d]).inv(), []  # coordinates turn the other way round than axes
    if turn.magnitude() > NONE:
        words.append(f"turned by {_turn(turn)}")
    if not _small((x / units)[-d:]):
        words.append(f"shifted by {vector(x[-d:])} m")
    return f"the file's world is {' and '.join(words)}"


def _turning_world(case: Case, spin: np.ndarray) -> Case:
    """Remove a steady rotation of the file's axes, such as Earth-fixed ones, about the scene's origin."""
    path = _turned(case.path, Rotation.from_rotvec(case.path.times[:, None] * spin))
    return replace(case, path=replace(path, velocity=path.velocity + np.cross(spin, path.position)))


def _turning(spin: np.ndarray) -> str:
    speed = float(np.linalg.norm(spin))
    return f"the file's world turns by {np.degrees(speed):.4g} deg/s about {vector(spin / speed)}"


def _turned_bodies(case: Case, x: np.ndarray) -> Case:
    """Turn back the axes that the file has for each body."""
    path = case.path
    if case.scene.planar:
        return replace(case, path=replace(path, orientation=path.orientation - x))
    turns = Rotation.from_rotvec(-x.reshape(-1, 3)).as_quat(scalar_first=True)
    return replace(case, path=replace(path, orientation=product(path.orientation, turns)))


def _axes(names: list[str], x: np.ndarray) -> str:
    turns = [_rotation(row) for row in x.reshape(len(names), -1)]
    parts = (f"{name} by {_turn(turn)}" for name, turn in zip(names, turns, strict=True) if turn.magnitude() > NONE)
    return f"body axes are turned: {', '.join(parts)}"


def _turn(turn: Rotation) -> str:
    return f"{np.degrees(turn.magnitude()):.4g} deg about {vector(turn.as_rotvec() / turn.magnitude())}"


def _other_points(case: Case, x: np.ndarray, rates: bool) -> Case:
    """Subtract the arms (m, body axes) from the centres of mass to the points whose positions the file has."""
    arms, spin, path = x.reshape(len(case.scene.bodies), -1), case.truth.angular_velocity, case.path
    turns, velocity = case.truth.orientation, path.velocity
    if case.scene.planar:
        c, s = np.cos(turns), np.sin(turns)
        away = np.stack([c * arms[:, 0] - s * arms[:, 1], s * arms[:, 0] + c * arms[:, 1]], axis=-1)
    else:
        away = (rotation_matrices(turns) @ arms[:, :, None])[..., 0]
    if rates and spin is not None:
        turned = np.stack([-away[..., 1], away[..., 0]], -1)
        across = spin[..., None] * turned if case.scene.planar else np.cross(spin, away)
        velocity = velocity - across
    return replace(case, path=replace(path, position=path.position - away, velocity=velocity))


def _points(names: list[str], x: np.ndarray, length: float) -> str:
    arms = zip(names, x.reshape(len(names), -1), strict=True)
    parts = (f"{name} at {vector(arm)} m in body axes" for name, arm in arms if not _small(arm / length))
    return f"positions are not of the centre of mass, but of {', '.join(parts)}"
